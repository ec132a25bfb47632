#pragma once
/// @file
/// The folder a run writes into.

#include <mpi.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace udar::io {

/// @brief Keeps other programs of udar from writing into a folder as long as any rank of this one lives, where the file
/// system knows of locks; those of network file systems may hold on one node alone.
class FolderLock {
 public:
  /// Of no folder.
  FolderLock() = default;
  /// @note Collective. @throws FileError on all ranks if another program holds it, and goes on to for some seconds
  FolderLock(MPI_Comm comm, const std::string& path);
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;
  FolderLock(FolderLock&& other) noexcept : descriptor_{std::exchange(other.descriptor_, -1)} {}
  FolderLock& operator=(FolderLock&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    return *this;
  }
  ~FolderLock();

  [[nodiscard]] bool held() const noexcept { return descriptor_ >= 0; }

 private:
  int descriptor_ = -1;
};

/// @brief Makes `path` ready for the files of one run: creates it, with its parents, and checks that it takes files.
/// @param[in] path      option `-output_directory`
/// @param[in] overwrite option `-output_overwrite`: a run already in the folder is removed, our own files only
/// @param[in] keep      a file that stays even then: the `-restart_file` this run starts from; empty for none
/// @param[in] lock      of the folder, if this program has it already
/// @return the lock
/// @note Collective; only rank 0 changes the disk. A refusal changes nothing.
/// @throws FileError on all ranks if the folder cannot be made or written, or holds a run and `overwrite` is false
/// @see docs/output.md
FolderLock prepare_run_directory(MPI_Comm comm, const std::string& path, bool overwrite, const std::string& keep = {},
                                 FolderLock lock = {});

/// @brief Whether `path` holds files of a run, or what is left of one. @note Not collective.
[[nodiscard]] bool holds_a_run(const std::string& path);

/// @brief Takes away what a run that goes on in `path` writes anew at its end: nobody shall take it for ended.
/// @note Collective; only rank 0 touches the disk. @throws FileError on all ranks if the folder takes no files
void reopen_run_directory(MPI_Comm comm, const std::string& path);

/// @brief The files of a run as they were when it began to write them, to notice at its end that somebody removed them
/// or put others in their place.
class RunFiles {
 public:
  /// @param[in] path the run's folder, with all files that stay open while it goes on
  /// @note Collective; only rank 0 touches the disk.
  RunFiles(MPI_Comm comm, const std::string& path);
  /// @note Collective. @throws FileError on all ranks, naming the first that is missing or another
  void require_present() const;

 private:
  struct File {
    std::string path;
    std::uint64_t device;
    std::uint64_t number;
  };
  MPI_Comm comm_;
  std::vector<File> files_;  ///< on rank 0
};

}  // namespace udar::io
