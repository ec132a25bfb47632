// ranks: 1 2; size: short
/// @file
/// Heights over a grid: the surface between the points, and the files they come from.

#include <gtest/gtest.h>
#include <petscsys.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "udar/io/height_field_file.hpp"
#include "udar/numerics/height_grid.hpp"
#include "udar/petsc/error.hpp"

namespace udar {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

template <class Height>
HeightGrid grid_with(const std::vector<double>& x, const std::vector<double>& z, const Height& height) {
  std::vector<double> values;
  for (const double b : z) {
    for (const double a : x) {
      values.push_back(height(a, b));
    }
  }
  return {x, z, values};
}

const std::vector<double> kX{-1.0, 0.2, 0.7, 2.0, 3.5};
const std::vector<double> kZ{0.0, 1.0, 1.3, 2.0};

TEST(HeightGrid, IsTheParabolaThatItsHeightsAreOf) {
  const auto height = [](double x, double z) { return 1.0 + (0.3 - 0.2 * x) * x + (0.5 * z - 0.1 + 0.07 * x) * z; };
  const HeightGrid grid = grid_with(kX, kZ, height);
  for (const double x : {-1.0, -0.4, 0.2, 0.45, 1.9, 3.5}) {
    for (const double z : {0.0, 0.8, 1.0, 1.1, 1.99, 2.0}) {
      const auto at = grid.at(x, z);
      ASSERT_TRUE(at);
      EXPECT_NEAR(at->height, height(x, z), 1e-14);
      EXPECT_NEAR(at->along_x, 0.3 - 0.4 * x + 0.07 * z, 1e-13);
      EXPECT_NEAR(at->along_z, z - 0.1 + 0.07 * x, 1e-13);
    }
  }
}

TEST(HeightGrid, HasSlopesWithoutJumps) {
  const HeightGrid grid = grid_with(kX, kZ, [](double x, double z) { return std::sin(3.0 * x) * std::cos(2.0 * z); });
  constexpr double kStep = 1e-7;
  for (const double x : {0.2, 0.7, 2.0}) {
    const auto before = grid.at(x - kStep, 0.4);
    const auto after = grid.at(x + kStep, 0.4);
    EXPECT_NEAR(before->along_x, after->along_x, 1e-5);  // 2e-7 times a curvature of some tens
    EXPECT_NEAR(before->along_z, after->along_z, 1e-5);
    EXPECT_NEAR((after->height - before->height) / (2.0 * kStep), grid.at(x, 0.4)->along_x, 1e-5);
  }
}

TEST(HeightGrid, IsBilinearOnFourPoints) {
  const HeightGrid grid{{0.0, 2.0}, {0.0, 1.0}, {1.0, 3.0, 5.0, 11.0}};
  const auto at = grid.at(0.5, 0.25);
  EXPECT_NEAR(at->height, 0.75 * 1.5 + 0.25 * 6.5, 1e-15);
  EXPECT_NEAR(at->along_x, 0.75 * 1.0 + 0.25 * 3.0, 1e-15);
  EXPECT_NEAR(at->along_z, 5.0, 1e-14);
}

TEST(HeightGrid, KnowsNothingBesideItOrNextToAGap) {
  std::vector<double> height(25, 1.0);
  height[24] = kNaN;  // at x = z = 4
  const std::vector<double> axis{0.0, 1.0, 2.0, 3.0, 4.0};
  const HeightGrid grid{axis, axis, height};
  EXPECT_TRUE(grid.at(4.0 + 1e-9, 0.0));
  EXPECT_FALSE(grid.at(4.0 + 1e-6, 0.0));
  EXPECT_FALSE(grid.at(0.0, -0.1));
  EXPECT_FALSE(grid.at(kNaN, 0.0));
  EXPECT_FALSE(grid.at(3.5, 3.5));
  EXPECT_FALSE(grid.at(2.5, 2.5));  // whose slopes it takes part in
  EXPECT_TRUE(grid.at(1.5, 3.5));
  EXPECT_EQ(grid.highest(), 1.0);
  EXPECT_THROW((HeightGrid{{0.0, 0.0}, {0.0, 1.0}, {1.0, 1.0, 1.0, 1.0}}), InputError);
  EXPECT_THROW((HeightGrid{{0.0, 1.0}, {0.0, 1.0}, {1.0, 1.0, 1.0}}), InputError);
}

/// What is read of a file with this text, on all ranks; else what the user is told, without the path.
struct Read {
  std::shared_ptr<const HeightGrid> grid;
  std::string complaint;
};
Read read(const std::string& text) {
  std::string path = std::filesystem::temp_directory_path() / "udar-heights-XXXXXX";
  int rank = 0;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  if (rank == 0) {
    close(mkstemp(path.data()));
    std::ofstream{path, std::ios::binary} << text;
  }
  MPI_Bcast(path.data(), static_cast<int>(path.size()), MPI_CHAR, 0, PETSC_COMM_WORLD);
  Read found;
  try {
    found.grid = io::read_height_field(PETSC_COMM_WORLD, "support height field", path);
  } catch (const FileError& error) {
    found.complaint = error.what();
    if (const std::size_t at = found.complaint.find(path); at != std::string::npos) {
      found.complaint.erase(at, path.size());
    }
  }
  MPI_Barrier(PETSC_COMM_WORLD);
  if (rank == 0) {
    std::filesystem::remove(path);
  }
  return found;
}

TEST(HeightFieldFile, IsATableInAnyOrder) {
  const Read found = read("x,z,height\n1,0,12\n0,0,11\n4,2.5,23\n0,2.5,21\n1,2.5,22\n4,0,13\n");
  ASSERT_TRUE(found.grid) << found.complaint;
  EXPECT_EQ(found.grid->x()[2], 4.0);
  EXPECT_EQ(found.grid->z()[1], 2.5);
  const std::array<double, 6> height{11, 12, 13, 21, 22, 23};
  EXPECT_TRUE(std::ranges::equal(found.grid->height(), height));
}

TEST(HeightFieldFile, IsAnEsriGridWithNorthFirst) {
  const std::string rows = "NODATA_value -1\n1 2 3\n\n4 5 6\n  7 8 -1\r\n";
  for (const std::string corner : {"xllcorner 9.5\nYLLCORNER 19.5\n", "xllcenter 10\nyllcenter 20\n"}) {
    const Read found = read("NCOLS 3\nnrows 3\n" + corner + "cellsize 1\n" + rows);
    ASSERT_TRUE(found.grid) << found.complaint;
    EXPECT_EQ(found.grid->x()[0], 10.0);
    EXPECT_EQ(found.grid->x()[2], 12.0);
    EXPECT_EQ(found.grid->z()[0], -22.0);
    EXPECT_EQ(found.grid->z()[2], -20.0);
    EXPECT_EQ(found.grid->height()[0], 1.0);
    EXPECT_EQ(found.grid->height()[7], 8.0);
    EXPECT_TRUE(std::isnan(found.grid->height()[8]));
  }
}

TEST(HeightFieldFile, SaysWhatIsWrong) {
  const std::string head = "ncols 3\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n";
  const auto expect = [](const std::string& text, const std::string& words) {
    const std::string complaint = read(text).complaint;
    EXPECT_NE(complaint.find(words), std::string::npos) << complaint;
    EXPECT_EQ(complaint.find("support height field: ''"), 0U) << complaint;
  };
  expect("0 0 1\n1 0 1\n0 1 1\n", "3 rows of 2 different x and 2 different z");
  expect("0 0 1\n1 0 1\n0 1 1\n1 1 1\n1 1 1\n", "5 rows of 2");
  expect("0 0 1\n1 0 1\n0 1 1\n0 1 1\n", "two rows for x = 0, z = 1");
  expect("0 0 1\n1 0 1\n2 0 1\n", "two or more of each");
  expect("0 0 nan\n", "line 1, column 3: 'nan' is not a finite number");
  expect("0 0\n", "2 column(s), expected 3");
  expect(head + "1 2 3\n4 5\n", "line 7 has 2 height(s), expected ncols = 3");
  expect(head + "1 2 3\n", "has 1 rows of heights, expected nrows = 2");
  expect(head + "1 2 3\n4 5 6\n7 8 9\n", "has 3 rows of heights");
  expect(head + "1 2 3\n4 nan 6\n", "line 7: 'nan' is not a finite number");
  expect(head + "1 2 3\n4 x 6\n", "line 7: 'x' is not a number");
  expect("ncols 3\nnrows 2\nxllcorner 0\nyllcorner 0\ndx 1\n", "line 5: 'dx' is not allowed");
  expect("ncols 3\nncols 3\n", "line 2: 'ncols' is not allowed, expected each once");
  expect("ncols 3\nnrows 2.5\n", "has nrows 2.5, expected a whole number");
  expect("ncols 1\nnrows 2\n", "has ncols 1");
  expect("ncols 2\nnrows 2\nyllcorner 0\ncellsize 1\n1 2\n3 4\n", "has no number xllcorner");
  expect("ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 0\n1 2\n3 4\n", "has cellsize 0");
  expect("ncols 2\n1 2\n", "has no number nrows");
}

}  // namespace
}  // namespace udar
