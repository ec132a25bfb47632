// ranks: 1 2 3; size: medium
/// @file
/// Checkpoints: every bit comes back, on any number of ranks, and nothing but a whole checkpoint is taken for one.

#include "udar/io/checkpoint.hpp"

#include <gtest/gtest.h>
#include <hdf5.h>
#include <petscsys.h>
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <bit>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "support/world.hpp"
#include "udar/petsc/error.hpp"

namespace udar::io {
namespace {

namespace fs = std::filesystem;

using test::failure_of;
using test::TemporaryFolder;
using test::world_rank;
using test::world_size;

NodeRange part_of_this_rank(PetscInt total) {
  return {total * world_rank() / world_size(), total * (world_rank() + 1) / world_size(), total};
}

/// Values that formats like to lose.
constexpr std::array<std::uint64_t, 6> kHardBits{
    0x8000000000000000,  // -0.0
    0x0000000000000001,  // the smallest denormal number
    0x7FF8000000000123,  // a NaN with a payload
    0xFFF0000000000000,  // minus infinity
    0x3FB999999999999A,  // 0.1
    0x7FEFFFFFFFFFFFFF,  // the largest number
};

double position_of(PetscInt node) {
  return std::bit_cast<double>(kHardBits[static_cast<std::size_t>(node) % kHardBits.size()]);
}

MotionState checkpoint_of(const NodeRange& nodes) {
  std::vector<double> position;
  std::vector<double> resting;
  for (PetscInt node = nodes.begin; node < nodes.end; ++node) {
    position.push_back(position_of(node));
    resting.push_back(node % 2 == 0 ? 1.0 : 0.0);
  }
  MotionState checkpoint;
  checkpoint.fields = {{"resting", resting}, {"mass_position", position}};
  checkpoint.scalars = {{"time", 0.1}, {"first_contact_time", std::numeric_limits<double>::infinity()}};
  checkpoint.tables = {{"support_impulse", {1.0, -0.0, 1.0 / 3.0}}, {"empty", {}}};
  checkpoint.parameters = {{"beam elements", "7"}, {"filter frequency [rad/s]", "1000"}};
  return checkpoint;
}

std::vector<std::uint64_t> bits(const std::vector<double>& values) {
  std::vector<std::uint64_t> result;
  result.reserve(values.size());
  for (const double value : values) {
    result.push_back(std::bit_cast<std::uint64_t>(value));
  }
  return result;
}

void expect_same(const MotionState& read, const MotionState& written) {
  ASSERT_EQ(read.fields.size(), written.fields.size());
  for (const auto& [name, values] : written.fields) {
    EXPECT_EQ(bits(read.fields.at(name)), bits(values)) << name;
  }
  EXPECT_EQ(read.scalars, written.scalars);
  ASSERT_EQ(read.tables.size(), written.tables.size());
  for (const auto& [name, values] : written.tables) {
    EXPECT_EQ(bits(read.tables.at(name)), bits(values)) << name;
  }
  EXPECT_EQ(read.parameters, written.parameters);
}

/// What a restart from `path` says to the user.
std::string refusal(const std::string& path, PetscInt nodes) {
  return failure_of([&] {
    [[maybe_unused]] const MotionState read = read_checkpoint({PETSC_COMM_WORLD, part_of_this_rank(nodes)}, path);
  });
}

std::string restart_error(const std::string& path, const std::string& reason) {
  return "restart file: cannot read '" + path + "': " + reason;
}

constexpr const char* kNoChecksum = "not a checkpoint of this version of udar, or cut short: no checksum at its end";
constexpr const char* kWrongChecksum = "damaged: its bytes do not have its checksum";

TEST(Checkpoint, ComesBackBitByBit) {
  const TemporaryFolder folder;
  for (const PetscInt total : {2, 1000}) {  // with 2, the third rank has none
    const NodeRange nodes = part_of_this_rank(total);
    const MotionState written = checkpoint_of(nodes);
    write_checkpoint({PETSC_COMM_WORLD, nodes}, folder / "restart.h5", written);
    expect_same(read_checkpoint({PETSC_COMM_WORLD, nodes}, folder / "restart.h5"), written);
    if (world_rank() == 0) {
      EXPECT_FALSE(fs::exists(folder / "restart.h5.tmp"));
    }
  }
}

// A partitioner may deal the points out as it likes: the file has them in the user's order.
TEST(Checkpoint, KeepsPointsInTheUsersOrder) {
  const TemporaryFolder folder;
  constexpr PetscInt kNodes = 37;
  const NodeRange held = part_of_this_rank(kNodes);
  std::vector<std::int64_t> number;
  MotionState written = checkpoint_of(held);
  for (PetscInt i = held.begin; i < held.end; ++i) {
    number.push_back(10 * i % kNodes);
    written.fields["mass_position"][static_cast<std::size_t>(i - held.begin)] = static_cast<double>(number.back());
  }
  const PointOrder order{PETSC_COMM_WORLD, held, number};
  write_checkpoint(order, folder / "restart.h5", written);
  expect_same(read_checkpoint(order, folder / "restart.h5"), written);
  const MotionState plain = read_checkpoint({PETSC_COMM_WORLD, held}, folder / "restart.h5");
  for (PetscInt i = held.begin; i < held.end; ++i) {
    EXPECT_EQ(plain.fields.at("mass_position")[static_cast<std::size_t>(i - held.begin)], static_cast<double>(i));
  }
}

/// Cells are dealt out otherwise than points.
TEST(Checkpoint, KeepsCellsInTheUsersOrder) {
  const TemporaryFolder folder;
  constexpr PetscInt kCells = 23;
  const NodeRange held = part_of_this_rank(kCells);
  std::vector<std::int64_t> number;
  MotionState written = checkpoint_of(part_of_this_rank(7));
  for (PetscInt i = held.begin; i < held.end; ++i) {
    number.push_back(10 * i % kCells);
    written.cells["force_max"].push_back(static_cast<double>(number.back()));
  }
  const PointOrder points{PETSC_COMM_WORLD, part_of_this_rank(7)};
  const PointOrder cells{PETSC_COMM_WORLD, held, number};
  write_checkpoint(points, folder / "restart.h5", written, &cells);
  EXPECT_EQ(read_checkpoint(points, folder / "restart.h5", {}, &cells).cells, written.cells);
  const PointOrder as_they_stand{PETSC_COMM_WORLD, held};
  const MotionState plain = read_checkpoint(points, folder / "restart.h5", {}, &as_they_stand);
  expect_same(plain, written);
  for (PetscInt i = held.begin; i < held.end; ++i) {
    EXPECT_EQ(plain.cells.at("force_max")[static_cast<std::size_t>(i - held.begin)], static_cast<double>(i));
  }
}

TEST(Checkpoint, OfAnotherCaseIsRefusedBeforeItsNodesAreCounted) {
  const TemporaryFolder folder;
  write_checkpoint({PETSC_COMM_WORLD, part_of_this_rank(10)}, folder / "restart.h5",
                   checkpoint_of(part_of_this_rank(10)));
  const std::vector<Parameter> here{{"beam elements", "8"}, {"filter frequency [rad/s]", "1000"}};
  EXPECT_EQ(failure_of([&] {
              [[maybe_unused]] const MotionState read =
                  read_checkpoint({PETSC_COMM_WORLD, part_of_this_rank(11)}, folder / "restart.h5",
                                  [&](std::span<const Parameter> there) { throw FileError{differences(there, here)}; });
            }),
            "beam elements: 7 there, 8 here");
}

TEST(Checkpoint, OfOneRankIsReadByAll) {
  const TemporaryFolder folder;
  constexpr PetscInt kNodes = 37;
  if (world_rank() == 0) {
    const NodeRange all{0, kNodes, kNodes};
    write_checkpoint({PETSC_COMM_SELF, all}, folder / "restart.h5", checkpoint_of(all));
  }
  MPI_Barrier(PETSC_COMM_WORLD);
  expect_same(read_checkpoint({PETSC_COMM_WORLD, part_of_this_rank(kNodes)}, folder / "restart.h5"),
              checkpoint_of(part_of_this_rank(kNodes)));
}

TEST(Checkpoint, OfAllRanksIsReadByOne) {
  const TemporaryFolder folder;
  constexpr PetscInt kNodes = 37;
  write_checkpoint({PETSC_COMM_WORLD, part_of_this_rank(kNodes)}, folder / "restart.h5",
                   checkpoint_of(part_of_this_rank(kNodes)));
  if (world_rank() == 0) {
    const NodeRange all{0, kNodes, kNodes};
    expect_same(read_checkpoint({PETSC_COMM_SELF, all}, folder / "restart.h5"), checkpoint_of(all));
  }
}

TEST(Checkpoint, TakesThePlaceOfTheOlderOne) {
  const TemporaryFolder folder;
  const NodeRange nodes = part_of_this_rank(20);
  MotionState checkpoint = checkpoint_of(nodes);
  write_checkpoint({PETSC_COMM_WORLD, nodes}, folder / "restart.h5", checkpoint);
  checkpoint.scalars["time"] = 0.2;
  write_checkpoint({PETSC_COMM_WORLD, nodes}, folder / "restart.h5", checkpoint);
  EXPECT_EQ(read_checkpoint({PETSC_COMM_WORLD, nodes}, folder / "restart.h5").scalars.at("time"), 0.2);
}

TEST(Checkpoint, ThatDoesNotFitOnTheDiskLeavesTheOlderOne) {
  const TemporaryFolder folder;
  const NodeRange small = part_of_this_rank(20);
  write_checkpoint({PETSC_COMM_WORLD, small}, folder / "restart.h5", checkpoint_of(small));
  const NodeRange large = part_of_this_rank(200000);

  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  rlimit limit = before;
  limit.rlim_cur = 1 << 20;
  setrlimit(RLIMIT_FSIZE, &limit);
  const std::string message =
      failure_of([&] { write_checkpoint({PETSC_COMM_WORLD, large}, folder / "restart.h5", checkpoint_of(large)); });
  setrlimit(RLIMIT_FSIZE, &before);

  EXPECT_EQ(message, "output directory: cannot write '" + folder / "restart.h5.tmp" + "': File too large");
  if (world_rank() == 0) {
    EXPECT_FALSE(fs::exists(folder / "restart.h5.tmp"));
  }
  expect_same(read_checkpoint({PETSC_COMM_WORLD, small}, folder / "restart.h5"), checkpoint_of(small));
}

TEST(Checkpoint, ThatIsMissingIsReported) {
  const TemporaryFolder folder;
  EXPECT_EQ(refusal(folder / "restart.h5", 10), restart_error(folder / "restart.h5", "No such file or directory"));
}

TEST(Checkpoint, IsNotAnyFile) {
  const TemporaryFolder folder;
  if (world_rank() == 0) {
    std::ofstream{folder / "notes.txt"} << "not a checkpoint";
    H5Fclose(H5Fcreate((folder / "other.h5").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT));
  }
  MPI_Barrier(PETSC_COMM_WORLD);
  for (const char* name : {"notes.txt", "other.h5"}) {
    EXPECT_EQ(refusal(folder / name, 10), restart_error(folder / name, kNoChecksum));
  }
  EXPECT_EQ(refusal(folder.path(), 10), restart_error(folder.path(), "Is a directory"));
}

TEST(Checkpoint, OfAnotherBeamIsRefused) {
  const TemporaryFolder folder;
  write_checkpoint({PETSC_COMM_WORLD, part_of_this_rank(10)}, folder / "restart.h5",
                   checkpoint_of(part_of_this_rank(10)));
  EXPECT_EQ(refusal(folder / "restart.h5", 11),
            restart_error(folder / "restart.h5", "a checkpoint of 10 nodes, this run has 11"));
}

TEST(Checkpoint, ThatIsCutShortIsRefused) {
  const TemporaryFolder folder;
  write_checkpoint({PETSC_COMM_WORLD, part_of_this_rank(1000)}, folder / "restart.h5",
                   checkpoint_of(part_of_this_rank(1000)));
  const auto size = fs::file_size(folder / "restart.h5");
  MPI_Barrier(PETSC_COMM_WORLD);
  if (world_rank() == 0) {
    fs::resize_file(folder / "restart.h5", size - 1000);
  }
  MPI_Barrier(PETSC_COMM_WORLD);
  EXPECT_EQ(refusal(folder / "restart.h5", 1000), restart_error(folder / "restart.h5", kNoChecksum));
}

// Each of these would reach HDF5, which hangs, crashes or gives other numbers for some of them.
TEST(Checkpoint, WithAnyDamagedByteIsRefused) {
  const TemporaryFolder folder;
  const std::string path = folder / "restart.h5";
  write_checkpoint({PETSC_COMM_WORLD, part_of_this_rank(20)}, path, checkpoint_of(part_of_this_rank(20)));
  const auto size = fs::file_size(path);
  ASSERT_GT(size, 4096U);
  const auto edit = [&](std::uintmax_t offset, auto change) {
    if (world_rank() == 0) {
      std::fstream file{path, std::ios::in | std::ios::out | std::ios::binary};
      file.seekg(static_cast<std::streamoff>(offset));
      const auto byte = static_cast<char>(change(file.get()));
      file.seekp(static_cast<std::streamoff>(offset));
      file.put(byte);
    }
    MPI_Barrier(PETSC_COMM_WORLD);
  };
  std::mt19937_64 random{20230721};  // the same on every rank
  for (int i = 0; i < 400; ++i) {
    // Half of them where HDF5 keeps what it needs to find the rest, or in the checksum itself.
    const std::uintmax_t offset = i % 4 == 0   ? random() % 2048
                                  : i % 4 == 1 ? size - 1 - random() % 64
                                               : random() % size;
    const int bit = 1 << (random() % 8);
    edit(offset, [bit](int byte) { return byte ^ bit; });
    const std::string message = refusal(path, 20);
    EXPECT_TRUE(message == restart_error(path, kNoChecksum) || message == restart_error(path, kWrongChecksum))
        << "byte " << offset << " of " << size << ", bit " << bit << ": " << message;
    edit(offset, [bit](int byte) { return byte ^ bit; });
  }
  expect_same(read_checkpoint({PETSC_COMM_WORLD, part_of_this_rank(20)}, path), checkpoint_of(part_of_this_rank(20)));
  for (const std::uintmax_t left : {size - 1, size - 64, size - 65, size / 2, std::uintmax_t{63}, std::uintmax_t{0}}) {
    if (world_rank() == 0) {
      fs::resize_file(path, left);
    }
    MPI_Barrier(PETSC_COMM_WORLD);
    EXPECT_EQ(refusal(path, 20), restart_error(path, kNoChecksum)) << left << " bytes";
  }
}

TEST(Checkpoint, ChangedByAnotherProgramIsRefused) {
  const TemporaryFolder folder;
  write_checkpoint({PETSC_COMM_WORLD, part_of_this_rank(1000)}, folder / "restart.h5",
                   checkpoint_of(part_of_this_rank(1000)));
  if (world_rank() == 0) {
    const hid_t file = H5Fopen((folder / "restart.h5").c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    const hid_t data = H5Dopen2(file, "/node_fields/resting", H5P_DEFAULT);
    std::vector<double> values(1000);
    H5Dread(data, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    values[400] = 0.0;
    H5Dwrite(data, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    H5Dclose(data);
    H5Fclose(file);
  }
  MPI_Barrier(PETSC_COMM_WORLD);
  EXPECT_NE(refusal(folder / "restart.h5", 1000), "");
}

}  // namespace
}  // namespace udar::io
