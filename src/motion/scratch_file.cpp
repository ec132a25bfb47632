#include "udar/motion/scratch_file.hpp"

#include <sys/types.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <system_error>

#include "udar/petsc/error.hpp"

namespace udar {

bool ScratchFile::open() {
  std::error_code unknown;
  std::string path =
      (folder_.empty() ? std::filesystem::temp_directory_path(unknown) : std::filesystem::path{folder_}) /
      ".udar-XXXXXX";
  const int descriptor = mkstemp(path.data());
  if (descriptor < 0) {
    return false;
  }
  unlink(path.c_str());
  file_.reset(fdopen(descriptor, "w+"));
  if (!file_) {
    close(descriptor);
    return false;
  }
  std::setvbuf(file_.get(), nullptr, _IONBF, 0);  // blocks are long, and are all there is to hold
  return true;
}

bool ScratchFile::append(std::span<const std::byte> bytes) {
  if ((!file_ && !open()) || fseeko(file_.get(), static_cast<off_t>(size_), SEEK_SET) != 0 ||
      std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) != bytes.size()) {
    return false;
  }
  size_ += bytes.size();
  return true;
}

void ScratchFile::read(std::uint64_t offset, std::span<std::byte> to) const {
  if (fseeko(file_.get(), static_cast<off_t>(offset), SEEK_SET) != 0 ||
      std::fread(to.data(), 1, to.size(), file_.get()) != to.size()) {
    throw FileError{"output directory: cannot read back what waits in '" + folder_ +
                    "': " + std::generic_category().message(errno)};
  }
}

void ScratchFile::clear() {
  if (size_ > 0) {
    size_ = 0;
    std::clearerr(file_.get());
    // Where it cannot be cut it is written over, and no longer than before.
    if (ftruncate(fileno(file_.get()), 0) != 0) {
      return;
    }
  }
}

}  // namespace udar
