#include "io/text_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <system_error>
#include <utility>

#include "udar/motion/motion_state.hpp"
#include "udar/petsc/error.hpp"

namespace udar::io {
namespace {

/// Longest shortest form of a double is 24 characters, of an int64 20.
constexpr std::size_t kLongestNumber = 32;

template <class Number>
void append_shortest(std::string& text, Number value) {
  std::array<char, kLongestNumber> digits{};
  const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  text.append(digits.data(), end);
}

using Scalars = decltype(MotionState::scalars);

std::string name_of_size(const std::string& path) {
  return "bytes of " + std::filesystem::path{path}.filename().string();
}

}  // namespace

std::string cannot_write(const std::string& path, const std::string& reason) {
  return "output directory: cannot write '" + path + "': " + reason;
}

int write_fully(int descriptor, std::string_view text, std::int64_t offset) {
  while (!text.empty()) {
    const ssize_t written = pwrite(descriptor, text.data(), text.size(), offset);
    if (written < 0) {
      if (errno == EINTR) {
        continue;
      }
      return errno;
    }
    text.remove_prefix(static_cast<std::size_t>(written));
    offset += written;
  }
  return 0;
}

int read_fully(int descriptor, char* to, std::size_t bytes, std::uint64_t offset) {
  while (bytes > 0) {
    const ssize_t got = pread(descriptor, to, bytes, static_cast<off_t>(offset));
    if (got <= 0) {
      if (got < 0 && errno == EINTR) {
        continue;
      }
      return got < 0 ? errno : EIO;
    }
    to += got;
    bytes -= static_cast<std::size_t>(got);
    offset += static_cast<std::uint64_t>(got);
  }
  return 0;
}

std::uint64_t size_of_file(int descriptor) {
  struct stat status{};
  return fstat(descriptor, &status) == 0 ? static_cast<std::uint64_t>(status.st_size) : 0;
}

void append_number(std::string& text, double value) { append_shortest(text, value); }
void append_number(std::string& text, std::int64_t value) { append_shortest(text, value); }

TextFile::TextFile(MPI_Comm comm, std::string path, TextFrame frame, const MotionState* earlier)
    : comm_{comm}, path_{std::move(path)}, footer_{std::move(frame.footer)} {
  int rank = 0;
  MPI_Comm_rank(comm_, &rank);
  if (rank == 0) {
    const auto stood = earlier != nullptr ? earlier->scalars.find(name_of_size(path_)) : Scalars::const_iterator{};
    if (earlier != nullptr && stood != earlier->scalars.end()) {
      open_at(static_cast<std::int64_t>(stood->second), frame.header);
    } else {
      open_anew(frame.header);
    }
  }
  throw_together<FileError>(comm_, failure_);
}

void TextFile::open_anew(const std::string& header) {
  descriptor_ = open(path_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (descriptor_ < 0) {
    fail(errno);
  } else {
    put(header);
  }
}

void TextFile::open_at(std::int64_t size, const std::string& header) {
  descriptor_ = open(path_.c_str(), O_RDWR | O_CLOEXEC);
  std::string there(header.size(), '\0');
  struct stat status{};
  if (descriptor_ < 0 || fstat(descriptor_, &status) != 0) {
    fail(errno);
    return;
  }
  if (status.st_size < size) {
    failure_ = cannot_write(path_, "it is shorter than when the restart file was written: has it been changed?");
  } else if (pread(descriptor_, there.data(), there.size(), 0) != static_cast<ssize_t>(there.size()) ||
             there != header) {
    failure_ = cannot_write(path_, "it has other columns than this run; keep the gauges and supports of the run");
  } else if (ftruncate(descriptor_, size) == 0) {
    size_ = size;
    put("");
  } else {
    fail(errno);
  }
}

TextFile::~TextFile() {
  if (descriptor_ >= 0) {
    close(descriptor_);
  }
}

void TextFile::fail(int error) { failure_ = cannot_write(path_, std::generic_category().message(error)); }

void TextFile::put(std::string_view text) {
  const std::string both = std::string{text} + footer_;
  // One call for text and footer, so that a reader, or a kill, finds the file with both or with neither.
  if (const int error = write_fully(descriptor_, both, size_); error == 0) {
    size_ += static_cast<std::int64_t>(text.size());
  } else {
    fail(error);
    // Back to the last whole state, in space the file already has.
    if (ftruncate(descriptor_, size_ + static_cast<std::int64_t>(footer_.size())) == 0) {
      write_fully(descriptor_, footer_, size_);
    }
  }
}

void TextFile::append(std::string_view text) {
  if (descriptor_ >= 0 && failure_.empty()) {
    put(text);
  }
  throw_together<FileError>(comm_, failure_);
}

void TextFile::save(MotionState& state) const {
  std::int64_t size = size_;
  MPI_Bcast(&size, 1, MPI_INT64_T, 0, comm_);
  state.scalars[name_of_size(path_)] = static_cast<double>(size);
}

void TextFile::sync() {
  if (descriptor_ >= 0 && failure_.empty() && fsync(descriptor_) != 0 && errno != EINVAL) {
    fail(errno);  // EINVAL: a pipe or a device, nothing to wait for
  }
  throw_together<FileError>(comm_, failure_);
}

void replace_text(MPI_Comm comm, const std::string& path, const std::string& text, bool sync) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  const std::string unfinished = path + ".tmp";
  {
    TextFile file{comm, unfinished};
    file.append(rank == 0 ? text : "");
    if (sync) {
      file.sync();
    }
  }
  std::string failure;
  if (rank == 0 && std::rename(unfinished.c_str(), path.c_str()) != 0) {
    failure = cannot_write(path, std::generic_category().message(errno));
  }
  throw_together<FileError>(comm, failure);
}

}  // namespace udar::io
