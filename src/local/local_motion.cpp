#include "udar/local/local_motion.hpp"

#include <algorithm>

namespace udar::local {

std::size_t powers_for(double angle) {
  constexpr double kRoundOff = 1e-18;
  double term = 1.0;
  std::size_t count = 4;
  for (std::size_t k = 1; k < kMostPowers; ++k) {
    term *= angle / static_cast<double>(k);
    if (term < kRoundOff && k >= count) {
      break;
    }
    count = std::max(count, k + 1);
  }
  return count;
}

}  // namespace udar::local
