#include "numerics/wide.hpp"

#include <algorithm>
#include <cstdlib>

namespace udar::wide {
namespace {

int lanes_of_processor() {
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512dq") != 0 &&
      __builtin_cpu_supports("avx512vl") != 0) {
    return 8;
  }
  return __builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("fma") != 0 ? 4 : 2;
#else
  return 2;
#endif
}

int lanes_allowed() {
  const char* allowed = std::getenv("UDAR_LANES");
  if (allowed == nullptr) {
    return 8;
  }
  const long most = std::strtol(allowed, nullptr, 10);
  return most >= 8 ? 8 : most >= 4 ? 4 : 2;
}

}  // namespace

namespace detail {
const int kNativeLanes = std::min(lanes_of_processor(), lanes_allowed());
}

}  // namespace udar::wide
