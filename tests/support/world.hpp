#pragma once
/// @file
/// Ranks, and a folder that all of them share.

#include <gtest/gtest.h>
#include <petscsys.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <system_error>

#include "udar/petsc/error.hpp"

namespace udar::test {

inline int world_rank() {
  int rank = 0;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  return rank;
}

inline int world_size() {
  int size = 1;
  MPI_Comm_size(PETSC_COMM_WORLD, &size);
  return size;
}

/// A folder made by rank 0 for all and removed at the end.
class TemporaryFolder {
 public:
  TemporaryFolder() : path_{std::filesystem::temp_directory_path() / "udar-test-XXXXXX"} {
    if (world_rank() == 0 && mkdtemp(path_.data()) == nullptr) {
      MPI_Abort(PETSC_COMM_WORLD, 1);
    }
    MPI_Bcast(path_.data(), static_cast<int>(path_.size()), MPI_CHAR, 0, PETSC_COMM_WORLD);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    MPI_Barrier(PETSC_COMM_WORLD);
    if (world_rank() == 0) {
      std::error_code ignored;
      std::filesystem::remove_all(path_, ignored);
    }
    MPI_Barrier(PETSC_COMM_WORLD);
  }
  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] std::string operator/(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

/// Runs `action` on all ranks and returns the message of its failure, which must be one line and the same on all.
template <class Failure = FileError, class Action>
std::string failure_of(Action&& action) {
  std::string message;
  try {
    action();
  } catch (const Failure& error) {
    message = error.what();
  }
  std::array<char, 512> of_rank_0{};
  std::copy_n(message.data(), std::min(message.size(), of_rank_0.size() - 1), of_rank_0.data());
  MPI_Bcast(of_rank_0.data(), static_cast<int>(of_rank_0.size()), MPI_CHAR, 0, PETSC_COMM_WORLD);
  EXPECT_EQ(message, of_rank_0.data());
  EXPECT_EQ(message.find('\n'), std::string::npos);
  return message;
}

}  // namespace udar::test
