#include "udar/io/run_directory.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
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
constexpr std::array kOpenFiles{"gauges.csv",  "strikers.csv", "places.csv",         "axles.csv",
                                "energy.csv",  "impacts.csv",  "impacts_merged.csv", "rests.csv",
                                "contact.csv", "results.h5",   "results.xdmf"};
/// What it writes at once, and the unfinished files a killed run may leave.
constexpr std::array kOtherFiles{"summary.json",       "summary.json.tmp",  "results.vtkhdf",
                                 "results.vtkhdf.tmp", "paraview-state.py", "paraview-state.py.tmp",
                                 "supports.vtp",       "supports.vtp.tmp",  "envelope.csv",
                                 "restart.h5",         "restart.h5.tmp",    "restart.previous.h5"};
/// Of these, what it writes at its end, and what is unfinished.
constexpr std::array kAtTheEnd{"summary.json",      "summary.json.tmp",      "results.vtkhdf", "results.vtkhdf.tmp",
                               "paraview-state.py", "paraview-state.py.tmp", "supports.vtp",   "supports.vtp.tmp",
                               "envelope.csv",      "restart.h5.tmp"};

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

/// Makes the folder; returns what went wrong.
std::string make(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    return "cannot be made a folder: " + error.message();
  }
  if (!fs::is_directory(folder, error)) {
    return "cannot be made a folder: " + reason(ENOTDIR);
  }
  return probe(folder);
}

/// The first file that is a sign of a run; empty: none.
std::string sign_of_a_run(const fs::path& folder) {
  const auto* const sign = std::ranges::find_if(kSignsOfARun, [&](const char* name) {
    std::error_code error;
    return fs::exists(folder / name, error);
  });
  return sign != kSignsOfARun.end() ? *sign : "";
}

/// Takes away the run that is there; returns what keeps it from that.
std::string clear(const fs::path& folder, bool overwrite, const std::string& keep) {
  if (!overwrite) {
    const std::string sign = sign_of_a_run(folder);
    return sign.empty()
               ? ""
               : "already holds a run (" + sign + "); give `output overwrite` to replace it, or another folder";
  }
  std::string failure = remove_files(folder, kOpenFiles, keep);
  return failure.empty() ? remove_files(folder, kOtherFiles, keep) : failure;
}

/// What rank 0 alone does and finds, told to all. @note Collective.
template <class Action>
void on_first_rank(MPI_Comm comm, const std::string& path, const Action& action) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  const std::string failure = rank == 0 ? action(fs::path{path}) : "";
  throw_together<FileError>(comm, failure.empty() ? "" : "output directory: '" + path + "' " + failure);
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
  // Any rank alone keeps it, all in the same way: rank 0 gives up that none other may have it first.
  if (rank == 0 && descriptor_ >= 0) {
    std::ignore = flock(descriptor_, LOCK_SH | LOCK_NB);
  }
  MPI_Barrier(comm);
  if (rank != 0 && descriptor_ >= 0) {
    std::ignore = flock(descriptor_, LOCK_SH | LOCK_NB);
  }
}

FolderLock::~FolderLock() {
  if (descriptor_ >= 0) {
    close(descriptor_);
  }
}

bool holds_a_run(const std::string& path) { return !sign_of_a_run(path).empty(); }

void reopen_run_directory(MPI_Comm comm, const std::string& path) {
  on_first_rank(comm, path, [](const fs::path& folder) {
    const std::string failure = probe(folder);
    return failure.empty() ? remove_files(folder, kAtTheEnd) : failure;
  });
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

FolderLock prepare_run_directory(MPI_Comm comm, const std::string& path, bool overwrite, const std::string& keep,
                                 FolderLock lock) {
  on_first_rank(comm, path, make);
  if (!lock.held()) {
    lock = FolderLock{comm, path};
  }
  on_first_rank(comm, path, [&](const fs::path& folder) { return clear(folder, overwrite, keep); });
  return lock;
}

}  // namespace udar::io
