// Preloaded into a program, makes what it stands on fail, as the environment says:
// FAULT_FILE, FAULT_AFTER and FAULT_ERROR (an errno): as soon as there is a file of the second name in its folder, all
// writes into one whose name begins with the first fail, and waiting for them;
// FAULT_MEMORY_AFTER (a path): as soon as it is there, the last of all ranks gets no kilobyte of memory any more;
// FAULT_CLOCK: the time of day jumps by a day, forward and back, whenever somebody asks for it.

#include <dlfcn.h>
#include <sys/time.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <new>
#include <string>
#include <system_error>

namespace {

/// Whether an operation on a file is to fail; sets errno.
bool fails(int descriptor) {
  static const char* const name = std::getenv("FAULT_FILE");
  if (name == nullptr) {
    return false;
  }
  std::error_code error;
  const auto path = std::filesystem::read_symlink("/proc/self/fd/" + std::to_string(descriptor), error);
  if (!path.filename().string().starts_with(name) ||
      !std::filesystem::exists(path.parent_path() / std::getenv("FAULT_AFTER"), error)) {
    return false;
  }
  errno = std::atoi(std::getenv("FAULT_ERROR"));
  return true;
}

bool on_last_rank() {
  const char* const rank = std::getenv("OMPI_COMM_WORLD_RANK");
  const char* const size = std::getenv("OMPI_COMM_WORLD_SIZE");
  return rank == nullptr || size == nullptr || std::atoi(rank) + 1 == std::atoi(size);
}

/// Whether there is no memory for that many bytes.
bool is_short(size_t size) {
  static const char* const after = on_last_rank() ? std::getenv("FAULT_MEMORY_AFTER") : nullptr;
  constexpr size_t kRoom = 1024;
  return after != nullptr && size >= kRoom && access(after, F_OK) == 0;
}

template <class Function>
Function next(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

/// Seconds by which the time of day is off, another at each call.
long jump() {
  static const bool jumps = std::getenv("FAULT_CLOCK") != nullptr;
  static long calls = 0;
  constexpr long kDay = 86400;
  return jumps ? (++calls % 2 == 0 ? kDay : -kDay) : 0;
}

}  // namespace

// NOLINTBEGIN(cppcoreguidelines-no-malloc): what `operator new` is made of
void* operator new(size_t size) {
  void* const memory = is_short(size) ? nullptr : std::malloc(size);
  if (memory == nullptr) {
    throw std::bad_alloc{};
  }
  return memory;
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, size_t /*size*/) noexcept { std::free(memory); }
// NOLINTEND(cppcoreguidelines-no-malloc)

// NOLINTBEGIN(readability-inconsistent-declaration-parameter-name)
extern "C" {

ssize_t write(int descriptor, const void* data, size_t size) {
  return fails(descriptor) ? -1 : next<decltype(&write)>("write")(descriptor, data, size);
}
ssize_t pwrite(int descriptor, const void* data, size_t size, off_t offset) {
  return fails(descriptor) ? -1 : next<decltype(&pwrite)>("pwrite")(descriptor, data, size, offset);
}
ssize_t pwrite64(int descriptor, const void* data, size_t size, off64_t offset) {
  return fails(descriptor) ? -1 : next<decltype(&pwrite64)>("pwrite64")(descriptor, data, size, offset);
}
ssize_t writev(int descriptor, const iovec* data, int count) {
  return fails(descriptor) ? -1 : next<decltype(&writev)>("writev")(descriptor, data, count);
}
ssize_t pwritev(int descriptor, const iovec* data, int count, off_t offset) {
  return fails(descriptor) ? -1 : next<decltype(&pwritev)>("pwritev")(descriptor, data, count, offset);
}
int fsync(int descriptor) { return fails(descriptor) ? -1 : next<decltype(&fsync)>("fsync")(descriptor); }

int clock_gettime(clockid_t clock, timespec* now) noexcept {
  const int result = next<decltype(&clock_gettime)>("clock_gettime")(clock, now);
  if (clock == CLOCK_REALTIME && result == 0) {
    now->tv_sec += jump();
  }
  return result;
}
int gettimeofday(timeval* now, void* zone) noexcept {
  const int result = next<decltype(&gettimeofday)>("gettimeofday")(now, zone);
  if (result == 0) {
    now->tv_sec += jump();
  }
  return result;
}
time_t time(time_t* now) noexcept {
  timespec value{};
  next<decltype(&clock_gettime)>("clock_gettime")(CLOCK_REALTIME, &value);
  value.tv_sec += jump();
  if (now != nullptr) {
    *now = value.tv_sec;
  }
  return value.tv_sec;
}
}
// NOLINTEND(readability-inconsistent-declaration-parameter-name)
