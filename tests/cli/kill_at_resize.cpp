// Preloaded into a program: kills it where it would set the size of results.h5 for the KILL_AT_RESIZE-th time. HDF5
// does so last in a flush, so this is the longest moment in which a file is neither as it was nor as it will be.

#include <dlfcn.h>
#include <sys/types.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <system_error>

namespace {

using Resize = int (*)(int, off_t);

int resize(const char* name, int descriptor, off_t size) {
  static int calls = 0;
  std::error_code error;
  const auto path = std::filesystem::read_symlink("/proc/self/fd/" + std::to_string(descriptor), error);
  const char* limit = std::getenv("KILL_AT_RESIZE");
  if (limit != nullptr && path.filename() == "results.h5" && ++calls == std::atoi(limit)) {
    std::raise(SIGKILL);
  }
  return reinterpret_cast<Resize>(dlsym(RTLD_NEXT, name))(descriptor, size);
}

}  // namespace

extern "C" {

// NOLINTNEXTLINE(readability-inconsistent-declaration-parameter-name)
int ftruncate(int descriptor, off_t size) noexcept { return resize("ftruncate", descriptor, size); }

// NOLINTNEXTLINE(readability-inconsistent-declaration-parameter-name)
int ftruncate64(int descriptor, off64_t size) noexcept { return resize("ftruncate64", descriptor, size); }
}
