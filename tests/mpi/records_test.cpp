// ranks: 1 2 3; size: short
/// @file
/// Tables of records that grow by any number on any rank, compressed or not.

#include <gtest/gtest.h>
#include <hdf5.h>
#include <petscsys.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "support/world.hpp"
#include "udar/io/hdf5_file.hpp"

namespace udar::io {
namespace {

using test::world_rank;
using test::world_size;

constexpr const char* kTable = "/numbers";

/// How many records a rank gives in a round: none, a few, some chunks, more than are written at a time.
std::size_t count_of(int round, int rank) {
  constexpr std::array<std::size_t, 9> kCounts{0, 1, 700, 1024, 3, 2500, 0, 40'000, 5};
  return kCounts.at(static_cast<std::size_t>(round + 4 * rank) % kCounts.size());
}

std::int64_t number(int round, int rank, std::size_t i) {
  return std::int64_t{1'000'000} * round + std::int64_t{100'000} * rank + static_cast<std::int64_t>(i);
}

/// One rank's behind the other's, round after round.
std::vector<std::int64_t> expected(int rounds) {
  std::vector<std::int64_t> all;
  for (int round = 0; round < rounds; ++round) {
    for (int rank = 0; rank < world_size(); ++rank) {
      for (std::size_t i = 0; i < count_of(round, rank); ++i) {
        all.push_back(number(round, rank, i));
      }
    }
  }
  return all;
}

void append(Hdf5File& file, int round) {
  std::vector<std::int64_t> own(count_of(round, world_rank()));
  for (std::size_t i = 0; i < own.size(); ++i) {
    own[i] = number(round, world_rank(), i);
  }
  file.append_records(kTable, own.data(), own.size());
}

std::vector<std::int64_t> read_back(const std::string& path) {
  const Hdf5Id file{H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose};
  const Hdf5Id data{H5Dopen2(file, kTable, H5P_DEFAULT), H5Dclose};
  const Hdf5Id space{H5Dget_space(data), H5Sclose};
  std::vector<std::int64_t> all(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)));
  EXPECT_GE(H5Dread(data, H5T_NATIVE_INT64, H5S_ALL, H5S_ALL, H5P_DEFAULT, all.data()), 0);
  return all;
}

constexpr int kRounds = 12;

TEST(Records, StandOneRankBehindTheOtherCompressedOrNot) {
  for (const int compression : {0, 1}) {
    const test::TemporaryFolder folder;
    {
      Hdf5File file{PETSC_COMM_WORLD, folder / "file.h5", Hdf5File::Access::create};
      file.add_records(kTable, H5T_NATIVE_INT64, compression);
      for (int round = 0; round < kRounds; ++round) {
        append(file, round);
      }
      file.close();
    }
    if (world_rank() == 0) {
      EXPECT_EQ(read_back(folder / "file.h5"), expected(kRounds)) << compression;
    }
    MPI_Barrier(PETSC_COMM_WORLD);
  }
}

TEST(Records, GoOnWhereTheyWaitedAtAMark) {
  const test::TemporaryFolder folder;
  Hdf5File::Mark mark;
  std::string waited;
  {
    Hdf5File file{PETSC_COMM_WORLD, folder / "file.h5", Hdf5File::Access::create};
    file.add_records(kTable, H5T_NATIVE_INT64, 1);
    for (int round = 0; round < kRounds; ++round) {
      append(file, round);
      if (round == kRounds / 2) {
        mark = file.mark();
        waited = file.waiting().at(kTable);
      }
    }
  }
  const std::size_t before = expected(kRounds / 2 + 1).size();
  if (world_rank() == 0) {
    EXPECT_EQ(waited.size(), before % 1024 * sizeof(std::int64_t)) << "a chunk that is not full";
  }
  {
    Hdf5File file{PETSC_COMM_WORLD, folder / "file.h5", mark};
    file.add_records(kTable, H5T_NATIVE_INT64, 0);
    file.set_waiting(kTable, waited);
    for (int round = kRounds / 2 + 1; round < kRounds; ++round) {
      append(file, round);
    }
    file.close();
  }
  if (world_rank() == 0) {
    EXPECT_EQ(read_back(folder / "file.h5"), expected(kRounds));
  }
}

}  // namespace
}  // namespace udar::io
