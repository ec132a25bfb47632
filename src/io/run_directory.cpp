#include "udar/io/run_directory.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <filesystem>
#include <span>
#include <system_error>
#include <thread>
#include <tuple>

#include "io/text_file.hpp"
#include "udar/petsc/error.hpp"

namespace udar::io {
namespace {

namespace fs = std::filesystem;

/// Any of these means that the folder holds a run.
constexpr std::array kSignsOfARun{"summary.json", "results.h5", "gauges.csv"};
/// What a run writes into from its start to its end.
constexpr std::array kOpenFiles{"gauges.csv",  "energy.csv", "impacts.csv", "rests.csv",
                                "contact.csv", "results.h5", "results.xdmf"};
/// What it writes at once, and the unfinished files a killed run may leave.
constexpr std::array kOtherFiles{"summary.json", "summary.json.tmp", "results.vtkhdf", "results.vtkhdf.tmp",
                                 "envelope.csv", "restart.h5",       "restart.h5.tmp", "restart.previous.h5"};
/// Of these, what it writes at its end, and what is unfinished.
constexpr std::array kAtTheEnd{"summary.json",       "summary.json.tmp", "results.vtkhdf",
                               "results.vtkhdf.tmp", "envelope.csv",     "restart.h5.tmp"};

std::string reason(int error) { return std::generic_category().message(error); }

/// Creates and removes a file, the only sure test; returns what went wrong.
std::string probe(const fs::path& folder) {
  const fs::path file = folder / ".udar-probe";
  const int descriptor = open(file.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600);
  if (descriptor < 0) {
    return "takes no files: " + reason(errno);
  }
  close(descriptor);
  return unlink(file.c_str()) == 0 ? "" : "does not let files go: " + reason(errno);
}

/// Removes these files but one; returns what went wrong.
std::string remove_files(const fs::path& folder, std::span<const char* const> names, const std::string& keep = {}) {
  for (const char* name : names) {
    const fs::path file = folder / name;
    std::error_code error;
    if (!keep.empty() && fs::equivalent(file, keep, error)) {
      continue;
    }
    fs::remove(file, error);
    if (error) {
      return std::string{"does not let the old "} + name + " go: " + error.message();
    }
  }
  return "";
}

/// What keeps a run from being written into `folder`, empty if nothing does.
std::string prepare(const fs::path& folder, bool overwrite, const std::string& keep) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    return "cannot be made a folder: " + error.message();
  }
  if (!fs::is_directory(folder, error)) {
    return "cannot be made a folder: " + reason(ENOTDIR);
  }
  if (std::string failure = probe(folder); !failure.empty()) {
    return failure;
  }
  if (!overwrite) {
    for (const char* name : kSignsOfARun) {
      if (fs::exists(folder / name, error)) {
        return std::string{"already holds a run ("} + name +
               "); give `output overwrite` to replace it, or another folder";
      }
    }
    return "";
  }
  std::string failure = remove_files(folder, kOpenFiles, keep);
  return failure.empty() ? remove_files(folder, kOtherFiles, keep) : failure;
}

}  // namespace

FolderLock::FolderLock(MPI_Comm comm, const std::string& path) {
  using namespace std::chrono_literals;
  constexpr int kPatience = 50;  // tenths of a second: the ranks of a killed run may outlive its rank 0
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  descriptor_ = open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  bool held = false;
  if (rank == 0 && descriptor_ >= 0) {
    held = flock(descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
    for (int wait = 0; held && wait < kPatience; ++wait) {
      std::this_thread::sleep_for(100ms);
      held = flock(descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
    }
  }
  throw_together<FileError>(comm,
                            held ? "output directory: '" + path + "' is in use: another udar writes into it" : "");
  if (descriptor_ >= 0) {  // a rank alone keeps it
    std::ignore = flock(descriptor_, LOCK_SH | LOCK_NB);
  }
}

FolderLock::~FolderLock() {
  if (descriptor_ >= 0) {
    close(descriptor_);
  }
}

void reopen_run_directory(MPI_Comm comm, const std::string& path) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  std::string failure;
  if (rank == 0) {
    failure = probe(path);
    failure = failure.empty() ? remove_files(path, kAtTheEnd) : failure;
  }
  throw_together<FileError>(comm, failure.empty() ? "" : "output directory: '" + path + "' " + failure);
}

RunFiles::RunFiles(MPI_Comm comm, const std::string& path) : comm_{comm} {
  int rank = 0;
  MPI_Comm_rank(comm_, &rank);
  for (const char* name : kOpenFiles) {
    const std::string file = (fs::path{path} / name).string();
    struct stat status{};
    if (rank == 0 && stat(file.c_str(), &status) == 0) {
      files_.push_back({.path = file, .device = status.st_dev, .number = status.st_ino});
    }
  }
}

void RunFiles::require_present() const {
  std::string failure;
  for (const File& file : files_) {
    struct stat status{};
    if (failure.empty() &&
        (stat(file.path.c_str(), &status) != 0 || status.st_dev != file.device || status.st_ino != file.number)) {
      failure = cannot_write(file.path, "it was removed or replaced while the run wrote into it");
    }
  }
  throw_together<FileError>(comm_, failure);
}

void prepare_run_directory(MPI_Comm comm, const std::string& path, bool overwrite, const std::string& keep) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  std::string failure;
  if (rank == 0) {
    failure = prepare(path, overwrite, keep);
  }
  throw_together<FileError>(comm, failure.empty() ? "" : "output directory: '" + path + "' " + failure);
}

}  // namespace udar::io
