#include "io/input_file.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <system_error>
#include <vector>

#include "udar/petsc/error.hpp"
#include "udar/petsc/session.hpp"

namespace udar::io {
namespace {

std::vector<std::string> places_of(const std::string& path, const std::string& beside) {
  std::vector<std::string> files = petsc::Session::options_files();
  if (!beside.empty()) {
    files.push_back(beside);
  }
  std::vector<std::string> places{path};
  for (auto file = files.rbegin(); file != files.rend() && std::filesystem::path{path}.is_relative(); ++file) {
    const std::string place = std::filesystem::path{*file}.replace_filename(path).string();
    if (std::ranges::find(places, place) == places.end()) {
      places.push_back(place);
    }
  }
  return places;
}

using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;

/// Of a file that anybody has made for udar; a device has no end.
constexpr std::size_t kLongest = std::size_t{1} << 30U;

struct Found {
  File file{nullptr, &std::fclose};
  std::string path;
};

Found open_file(const std::string& path, const std::string& beside) {
  const std::vector<std::string> places = places_of(path, beside);
  Found found;
  int error = ENOENT;
  for (auto place = places.begin(); place != places.end() && error == ENOENT; ++place) {
    found.file.reset(std::fopen(place->c_str(), "rb"));
    found.path = *place;
    error = found.file ? 0 : errno;
  }
  if (error != 0) {
    std::string complaint = " cannot be read: " + std::generic_category().message(error);
    for (std::size_t i = 1; i < places.size() && error == ENOENT; ++i) {
      complaint += (i == 1 ? ", neither from the working directory nor as '" : " nor as '") + places[i] + "'";
    }
    throw Complaint{complaint};
  }
  return found;
}

}  // namespace

std::string find_file(const std::string& path, const std::string& beside) { return open_file(path, beside).path; }

std::string read_file(const std::string& path) {
  const Found found = open_file(path, {});
  std::string text;
  std::array<char, 1 << 16> block{};
  std::size_t count = 0;
  while ((count = std::fread(block.data(), 1, block.size(), found.file.get())) > 0) {
    text.append(block.data(), count);
    if (text.size() > kLongest) {
      throw Complaint{" cannot be read: it is longer than 1 GiB"};
    }
  }
  if (std::ferror(found.file.get()) != 0) {
    throw Complaint{" cannot be read: " + std::generic_category().message(errno)};
  }
  return text;
}

std::string share_file(MPI_Comm comm, const std::string& quantity, const std::string& path) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  std::string text;
  std::string failure;
  if (rank == 0) {
    try {
      text = read_file(path);
    } catch (const Complaint& complaint) {
      failure = quantity + ": '" + path + "'" + complaint.text;
    }
  }
  throw_together<FileError>(comm, failure);
  std::uint64_t size = text.size();
  MPI_Bcast(&size, 1, MPI_UINT64_T, 0, comm);
  text.resize(size);
  broadcast(comm, text.data(), text.size());
  return text;
}

void broadcast(MPI_Comm comm, void* bytes, std::size_t count) {
  auto* next = static_cast<char*>(bytes);
  while (count > 0) {
    const auto part = std::min<std::size_t>(count, std::numeric_limits<int>::max());
    MPI_Bcast(next, static_cast<int>(part), MPI_CHAR, 0, comm);
    next += part;
    count -= part;
  }
}

}  // namespace udar::io
