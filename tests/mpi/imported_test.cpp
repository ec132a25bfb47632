// ranks: 1 2 3; size: short
/// @file
/// Stiffness and mass from files: what a beam wrote is the same beam, and bad matrices are refused by name.

#include "udar/structure/imported.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "support/steel_beam.hpp"
#include "support/world.hpp"
#include "udar/filter/filtered_structure.hpp"
#include "udar/petsc/error.hpp"
#include "udar/structure/beam_matrices.hpp"
#include "udar/structure/matrix_file.hpp"

namespace udar {
namespace {

using test::steel_beam;
using test::world_rank;

std::string scratch(const std::string& name) {
  int size = 1;
  MPI_Comm_size(PETSC_COMM_WORLD, &size);
  const std::string directory = testing::TempDir() + "udar-imported-np" + std::to_string(size);
  std::filesystem::create_directories(directory);
  MPI_Barrier(PETSC_COMM_WORLD);
  return directory + "/" + name;
}

/// Each point's value on every rank, by its number.
std::vector<double> all_values(std::span<const double> local, PetscInt begin, PetscInt total) {
  std::vector<double> all(static_cast<std::size_t>(total), 0.0);
  std::ranges::copy(local, all.begin() + begin);
  MPI_Allreduce(MPI_IN_PLACE, all.data(), static_cast<int>(total), MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
  return all;
}

/// A free beam far from where it is unstressed, bent, under a load: stretch and energy are those of its own line.
TEST(ImportedStructure, IsTheBeamThatWroteIt) {
  const double wf = 100.0;
  BeamParameters parameters = steel_beam(40);
  parameters.segments.front().foundation_stiffness = 50.0;
  const BeamChain beam{PETSC_COMM_WORLD, parameters};
  const std::string prefix = scratch("beam");
  write_beam_matrices(beam, prefix);
  const ImportedStructure imported{
      PETSC_COMM_WORLD, {.stiffness = prefix + "-stiffness.mtx", .mass = prefix + "-mass.mtx", .places = {}}};
  ASSERT_EQ(imported.points().total(), beam.nodes());
  EXPECT_EQ(imported.unknowns(), 2 * beam.nodes());
  EXPECT_NEAR(imported.total_mass(), beam.total_mass(), 1e-12 * beam.total_mass());

  FilteredStructure line{beam, {.filter_frequency = wf, .check_interval = 1}};
  FilteredStructure other{imported, {.filter_frequency = wf, .check_interval = 1}};
  const auto displacement = [&](PetscInt node) {
    const double x = static_cast<double>(node) / static_cast<double>(beam.nodes());
    return 3.0 + 0.2 * x + 0.01 * std::sin(7.0 * x);
  };
  const auto force = [](PetscInt node) { return node % 7 == 0 ? 50.0 : -3.0; };
  const auto solve = [&](FilteredStructure& structure, PetscInt begin, PetscInt end, double& energy) {
    const auto count = static_cast<std::size_t>(end - begin);
    std::vector<double> given;
    std::vector<double> loads;
    for (PetscInt node = begin; node < end; ++node) {
      given.push_back(displacement(node));
      loads.push_back(force(node));
    }
    std::vector<double> stretch(count);
    std::vector<double> internal(count);
    structure.solve(given, loads, stretch, internal);
    for (std::size_t i = 0; i < count; ++i) {
      given[i] += stretch[i];
    }
    energy = structure.filter_operator().strain_energy(given, internal);
    MPI_Allreduce(MPI_IN_PLACE, &energy, 1, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
    return all_values(stretch, begin, beam.nodes());
  };
  double energy = 0.0;
  double other_energy = 0.0;
  const auto expected = solve(line, beam.begin(), beam.end(), energy);
  const auto found = solve(other, imported.points().begin(), imported.points().end(), other_energy);
  double largest = 0.0;
  for (const double value : expected) {
    largest = std::max(largest, std::abs(value));
  }
  for (std::size_t i = 0; i < found.size(); ++i) {
    // Entries of 17 digits: rounding of C times a displacement that is no translation, (w_max / wf)^2 eps of it.
    EXPECT_NEAR(found[i], expected[i], 1e-9 * largest) << "node " << i;
  }
  EXPECT_NEAR(other_energy, energy, 1e-8 * energy);
}

TEST(ImportedStructure, SolvesColumnsTogetherAsAlone) {
  const BeamChain beam{PETSC_COMM_WORLD, steel_beam(24)};
  const std::string prefix = scratch("columns");
  write_beam_matrices(beam, prefix);
  const ImportedStructure imported{
      PETSC_COMM_WORLD, {.stiffness = prefix + "-stiffness.mtx", .mass = prefix + "-mass.mtx", .places = {}}};
  FilteredStructure structure{imported, {.filter_frequency = 50.0, .check_interval = 1}};
  const std::size_t count = imported.points().mass().size();
  std::vector<std::vector<double>> given(3, std::vector<double>(count));
  std::vector<std::vector<double>> together(3, std::vector<double>(count));
  std::vector<FilterColumn> columns;
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t i = 0; i < count; ++i) {
      given[c][i] = std::cos(static_cast<double>(c + 1) * static_cast<double>(imported.points().number(i)));
    }
    columns.push_back({.displacement = given[c].data(), .stretch = together[c].data()});
  }
  structure.solve(columns);
  EXPECT_EQ(structure.solves(), 3);
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<double> alone(count);
    structure.solve(given[c], {}, alone, {});
    for (std::size_t i = 0; i < count; ++i) {
      EXPECT_NEAR(together[c][i], alone[i], 1e-12) << "column " << c;  // of order one: rounding of another order
    }
  }
}

TEST(ImportedStructure, ReadsBothFormsAndBothStorages) {
  const std::string binary = scratch("both.bin");
  const std::string text = scratch("both.mtx");
  const petsc::Matrix matrix = matrix_of(
      PETSC_COMM_WORLD, 3, 3,
      world_rank() == 0 ? std::vector<MatrixEntry>{{0, 0, 2.0}, {0, 1, -1.0}, {1, 0, -1.0}, {1, 1, 1.0}, {2, 2, 0.1}}
                        : std::vector<MatrixEntry>{});
  write_matrix(matrix, binary);
  write_matrix(matrix, text);  // the lower triangle
  for (const std::string& path : {binary, text}) {
    const petsc::Matrix read = read_matrix(PETSC_COMM_WORLD, "structure stiffness", path);
    PetscBool same = PETSC_FALSE;
    UDAR_CALL(MatEqual(matrix, read, &same));
    EXPECT_TRUE(same) << path;
  }
}

struct Files {
  std::string stiffness = "%%MatrixMarket matrix coordinate real symmetric\n2 2 3\n1 1 2\n2 1 -1\n2 2 1\n";
  std::string mass = "%%MatrixMarket matrix coordinate real general\n2 2 2\n1 1 1\n2 2 1\n";
  std::size_t places = 0;
  std::string message;
};

void expect_refused(const Files& files, Lumping lumping = Lumping::row) {
  const std::string stiffness = scratch("bad-stiffness.mtx");
  const std::string mass = scratch("bad-mass.mtx");
  if (world_rank() == 0) {
    std::ofstream{stiffness} << files.stiffness;
    std::ofstream{mass} << files.mass;
  }
  MPI_Barrier(PETSC_COMM_WORLD);
  std::string message = "nothing";
  try {
    const ImportedStructure structure{
        PETSC_COMM_WORLD,
        {.stiffness = stiffness, .mass = mass, .lumping = lumping, .places = std::vector<Place>(files.places)}};
  } catch (const std::runtime_error& error) {
    message = error.what();
  }
  EXPECT_NE(message.find(files.message), std::string::npos) << message << "\nexpected: " << files.message;
  MPI_Barrier(PETSC_COMM_WORLD);
}

const std::string kGeneral = "%%MatrixMarket matrix coordinate real general\n";

TEST(ImportedStructure, RefusesBadMatricesByName) {
  const std::vector<Files> bad{
      {.stiffness = kGeneral + "2 3 2\n1 1 1\n2 2 1\n",
       .message = "structure stiffness: a matrix of 2 rows and 3 columns is not allowed"},
      {.mass = kGeneral + "3 3 3\n1 1 1\n2 2 1\n3 3 1\n",
       .message = "structure mass: 3 unknowns are not allowed, expected 2 as in `structure stiffness`"},
      {.stiffness = kGeneral + "2 2 4\n1 1 2\n2 2 2\n1 2 -1\n2 1 -1.5\n",
       .message = "structure stiffness: the matrix is not symmetric: entries (0, 1) and (1, 0), counted from 0, differ "
                  "by 0.5"},
      {.mass = kGeneral + "2 2 2\n1 1 1\n2 2 -3\n",
       .message = "structure mass: unknown 1 (counted from 0) has a lumped mass of -3 kg"},
      {.stiffness = kGeneral + "2 2 2\n1 1 nan\n2 2 1\n",
       .message = "has something else than a finite number in row 0, column 0"},
      {.stiffness = kGeneral + "2 2 4\n1 1 1\n2 2 1\n1 2 -2\n2 1 -2\n",
       .message = "is not positive: the stiffness is indefinite"},
      {.stiffness = kGeneral + "2 2 1\n1 1 1\n",
       .mass = kGeneral + "2 2 1\n1 1 1\n",
       .message = "structure stiffness: unknown 1 (counted from 0) has neither mass nor stiffness"},
      {.stiffness = kGeneral + "3 3 5\n1 1 1\n2 2 1\n3 3 1\n2 3 -1\n3 2 -1\n",
       .mass = kGeneral + "3 3 1\n1 1 1\n",
       .message = "it has no mass and is loose"},
      {.places = 1, .message = "structure points: 1 places are not allowed, expected one for each of the 2 unknowns"},
      {.stiffness = kGeneral + "2 2 3\n1 1 1\n", .message = "ends early or is damaged"},
      {.stiffness = "nonsense\n", .message = "is not a Matrix Market file"}};
  for (const Files& files : bad) {
    expect_refused(files);
  }
}

TEST(ImportedStructure, RefusesATruncatedBinaryFile) {
  const std::string path = scratch("short.bin");
  const petsc::Matrix matrix =
      matrix_of(PETSC_COMM_WORLD, 2, 2,
                world_rank() == 0 ? std::vector<MatrixEntry>{{0, 0, 1.0}, {1, 1, 1.0}} : std::vector<MatrixEntry>{});
  write_matrix(matrix, path);
  MPI_Barrier(PETSC_COMM_WORLD);
  if (world_rank() == 0) {
    std::filesystem::resize_file(path, std::filesystem::file_size(path) - 1);
  }
  MPI_Barrier(PETSC_COMM_WORLD);
  const std::string message =
      test::failure_of<FileError>([&] { const auto read = read_matrix(PETSC_COMM_WORLD, "structure mass", path); });
  EXPECT_NE(message.find("structure mass: '"), std::string::npos) << message;
  EXPECT_NE(message.find("ends early"), std::string::npos) << message;
}

/// A quadratic bar element's corners get a third of what its middle gets by rows, and by HRZ the like.
TEST(ImportedStructure, LumpsByRowsOrByScaledDiagonal) {
  const std::string stiffness = scratch("lumping-stiffness.mtx");
  const std::string mass = scratch("lumping-mass.mtx");
  if (world_rank() == 0) {
    std::ofstream{stiffness} << kGeneral + "3 3 3\n1 1 1\n2 2 1\n3 3 1\n";
    // 30 m = 4 2 -1; 2 16 2; -1 2 4 with m = 30 kg
    std::ofstream{mass} << kGeneral + "3 3 9\n1 1 4\n1 2 2\n1 3 -1\n2 1 2\n2 2 16\n2 3 2\n3 1 -1\n3 2 2\n3 3 4\n";
  }
  MPI_Barrier(PETSC_COMM_WORLD);
  const auto masses = [&](Lumping lumping) {
    const ImportedStructure structure{PETSC_COMM_WORLD,
                                      {.stiffness = stiffness, .mass = mass, .lumping = lumping, .places = {}}};
    EXPECT_DOUBLE_EQ(structure.total_mass(), 30.0);
    return all_values(structure.points().mass(), structure.points().begin(), 3);
  };
  const auto rows = masses(Lumping::row);
  EXPECT_DOUBLE_EQ(rows[0], 5.0);
  EXPECT_DOUBLE_EQ(rows[1], 20.0);
  const auto scaled = masses(Lumping::hrz);
  EXPECT_DOUBLE_EQ(scaled[0], 4.0 * 30.0 / 24.0);
  EXPECT_DOUBLE_EQ(scaled[1], 16.0 * 30.0 / 24.0);
}

}  // namespace
}  // namespace udar
