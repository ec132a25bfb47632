#include "io/text_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cstdint>
#include <system_error>
#include <utility>

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

void append_number(std::string& text, double value) { append_shortest(text, value); }
void append_number(std::string& text, std::int64_t value) { append_shortest(text, value); }

TextFile::TextFile(MPI_Comm comm, std::string path) : comm_{comm}, path_{std::move(path)} {
  int rank = 0;
  MPI_Comm_rank(comm_, &rank);
  if (rank == 0) {
    descriptor_ = open(path_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (descriptor_ < 0) {
      failure_ = cannot_write(path_, std::generic_category().message(errno));
    }
  }
  throw_together<FileError>(comm_, failure_);
}

TextFile::~TextFile() {
  if (descriptor_ >= 0) {
    close(descriptor_);
  }
}

void TextFile::fail(int error) { failure_ = cannot_write(path_, std::generic_category().message(error)); }

void TextFile::append(std::string_view text, std::string_view footer) {
  if (descriptor_ >= 0 && failure_.empty()) {
    std::string both{text};
    both += footer;
    // One call for text and footer, so that a reader, or a kill, finds the file with both or with neither.
    if (const int error = write_fully(descriptor_, both, size_); error == 0) {
      size_ += static_cast<std::int64_t>(text.size());
      footer_ = footer;
    } else {
      fail(error);
      // Back to the last whole state, in space the file already has.
      if (ftruncate(descriptor_, size_ + static_cast<std::int64_t>(footer_.size())) == 0) {
        write_fully(descriptor_, footer_, size_);
      }
    }
  }
  throw_together<FileError>(comm_, failure_);
}

void TextFile::sync() {
  if (descriptor_ >= 0 && failure_.empty() && fsync(descriptor_) != 0 && errno != EINVAL) {
    fail(errno);  // EINVAL: a pipe or a device, nothing to wait for
  }
  throw_together<FileError>(comm_, failure_);
}

}  // namespace udar::io
