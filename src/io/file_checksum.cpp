#include "io/file_checksum.hpp"

#include <fcntl.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cinttypes>
#include <cstdint>
#include <cstdio>
#include <string_view>
#include <system_error>
#include <vector>

#include "io/text_file.hpp"

namespace udar::io {
namespace {

constexpr std::size_t kBlock = std::size_t{1} << 20;
constexpr const char* kForm = "\nudar: CRC-32 %08" PRIx32 " of the %20" PRIu64 " bytes above\n";
constexpr std::size_t kLine =
    std::string_view{"\nudar: CRC-32 01234567 of the 01234567890123456789 bytes above\n"}.size();

/// Length of a file and what its checksum comes to; `error` is errno.
struct Content {
  std::uint64_t bytes = 0;
  std::uint32_t crc = 0;
  int error = 0;
};

std::string line_of(const Content& content) {
  std::array<char, kLine + 1> text{};
  std::snprintf(text.data(), text.size(), kForm, content.crc, content.bytes);
  return text.data();
}

class OpenFile {
 public:
  explicit OpenFile(const std::string& path) : descriptor_{open(path.c_str(), O_RDONLY | O_CLOEXEC)} {}
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  ~OpenFile() {
    if (descriptor_ >= 0) {
      close(descriptor_);
    }
  }

  [[nodiscard]] int error() const noexcept { return descriptor_ < 0 ? errno : 0; }
  [[nodiscard]] std::uint64_t size() const { return descriptor_ >= 0 ? size_of_file(descriptor_) : 0; }
  [[nodiscard]] int read(char* to, std::size_t bytes, std::uint64_t offset) const {
    return read_fully(descriptor_, to, bytes, offset);
  }

 private:
  int descriptor_;
};

/// Checksum of `[begin, end)`.
Content read_share(const OpenFile& file, std::uint64_t begin, std::uint64_t end) {
  Content share{.bytes = end - begin, .crc = static_cast<std::uint32_t>(crc32_z(0, nullptr, 0)), .error = file.error()};
  std::vector<char> block(std::min<std::uint64_t>(kBlock, share.bytes));
  while (begin < end && share.error == 0) {
    const auto now = static_cast<std::size_t>(std::min<std::uint64_t>(block.size(), end - begin));
    share.error = file.read(block.data(), now, begin);
    share.crc = static_cast<std::uint32_t>(crc32_z(share.crc, reinterpret_cast<const Bytef*>(block.data()), now));
    begin += now;
  }
  return share;
}

/// The first `bytes` of the file, each rank reading its part; the same on every rank.
Content content_of(MPI_Comm comm, const OpenFile& file, std::uint64_t bytes) {
  int rank = 0;
  int size = 1;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &size);
  const std::uint64_t part = (bytes + static_cast<std::uint64_t>(size) - 1) / static_cast<std::uint64_t>(size);
  const auto begin = [&](int of) { return std::min(bytes, part * static_cast<std::uint64_t>(of)); };
  const Content own = read_share(file, begin(rank), begin(rank + 1));
  std::vector<Content> shares(static_cast<std::size_t>(size));
  MPI_Allgather(&own, sizeof(Content), MPI_BYTE, shares.data(), sizeof(Content), MPI_BYTE, comm);
  Content all = shares.front();
  for (std::size_t i = 1; i < shares.size(); ++i) {
    all.crc = static_cast<std::uint32_t>(crc32_combine(all.crc, shares[i].crc, static_cast<z_off_t>(shares[i].bytes)));
    all.bytes += shares[i].bytes;
    all.error = all.error != 0 ? all.error : shares[i].error;
  }
  return all;
}

/// Rank 0's number on every rank.
template <class Number>
Number of_first_rank(MPI_Comm comm, Number value) {
  MPI_Bcast(&value, sizeof(Number), MPI_BYTE, 0, comm);
  return value;
}

}  // namespace

std::string system_reason(int error) { return std::generic_category().message(error); }

std::string append_checksum(MPI_Comm comm, const std::string& path) {
  const OpenFile file{path};
  const Content content = content_of(comm, file, of_first_rank(comm, file.size()));
  int error = content.error;
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  if (rank == 0 && error == 0) {
    const int descriptor = open(path.c_str(), O_WRONLY | O_CLOEXEC);
    error =
        descriptor < 0 ? errno : write_fully(descriptor, line_of(content), static_cast<std::int64_t>(content.bytes));
    if (descriptor >= 0) {
      close(descriptor);
    }
  }
  error = of_first_rank(comm, error);
  return error != 0 ? system_reason(error) : "";
}

ChecksumFailure checksum_failure(MPI_Comm comm, const std::string& path) {
  const auto by_system = [](int error) { return ChecksumFailure{.text = system_reason(error), .unreadable = true}; };
  const OpenFile file{path};
  if (const int error = of_first_rank(comm, file.error()); error != 0) {
    return by_system(error);
  }
  const std::uint64_t size = of_first_rank(comm, file.size());
  std::array<char, kLine> line{};
  const std::uint64_t bytes = size - std::min<std::uint64_t>(size, kLine);
  int error = size < kLine ? 0 : file.read(line.data(), kLine, bytes);
  if (error = of_first_rank(comm, error); error != 0) {
    return by_system(error);  // a folder, a disk that is going
  }
  const std::string_view found{line.data(), line.size()};
  if (!of_first_rank(comm, found.starts_with("\nudar: CRC-32 "))) {
    return {.text = "not a checkpoint of this version of udar, or cut short: no checksum at its end"};
  }
  const Content content = content_of(comm, file, bytes);
  if (content.error != 0) {
    return by_system(content.error);
  }
  return {.text = of_first_rank(comm, found == line_of(content)) ? "" : "damaged: its bytes do not have its checksum"};
}

}  // namespace udar::io
