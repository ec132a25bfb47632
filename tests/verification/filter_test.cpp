// ranks: 1 2; size: medium
/// @file
/// The filter against the exact spectrum of the lumped beam.

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "support/dense.hpp"
#include "support/steel_beam.hpp"
#include "udar/filter/modes.hpp"

namespace udar {
namespace {

struct Ends {
  const char* name;
  BeamEnd left;
  BeamEnd right;
};

class FilterSpectrum : public testing::TestWithParam<Ends> {};

BeamParameters with_ends(BeamParameters beam, const Ends& ends) {
  beam.left = ends.left;
  beam.right = ends.right;
  return beam;
}

/// Every mode shape of the lumped beam must be an eigenvector of the filtered operator with
/// lambda^2 = wf^2 w^2 / (wf^2 + w^2): both claims at once.
void expect_filtered_modes(const BeamParameters& parameters, double wf, Formulation formulation, double tolerance) {
  const BeamChain beam{PETSC_COMM_WORLD, parameters};
  FilteredStructure line{beam, {.filter_frequency = wf, .formulation = formulation}};
  const test::Eigen modes = test::lumped_modes(beam);
  const auto count = static_cast<std::size_t>(beam.local_nodes());
  const std::vector<double> no_force(count, 0.0);
  for (std::size_t mode = 0; mode < modes.values.size(); ++mode) {
    const double w2 = modes.values[mode];
    if (w2 < 1.0) {
      continue;  // rigid motion
    }
    std::vector<double> shape(count);
    std::vector<double> stretch(count);
    std::vector<double> moment(count);
    for (std::size_t i = 0; i < count; ++i) {
      shape[i] = modes.vectors(static_cast<std::size_t>(beam.begin()) + i, mode);
    }
    line.solve(shape, no_force, stretch, moment);
    const double lambda2 = wf * wf * w2 / (wf * wf + w2);
    std::array<double, 2> largest{};
    for (std::size_t i = 0; i < count; ++i) {
      largest[0] = std::max(largest[0], std::abs(-wf * wf * stretch[i] - lambda2 * shape[i]));
      largest[1] = std::max(largest[1], std::abs(lambda2 * shape[i]));
    }
    MPI_Allreduce(MPI_IN_PLACE, largest.data(), 2, MPI_DOUBLE, MPI_MAX, beam.comm());
    EXPECT_LT(largest[0] / largest[1], tolerance) << "mode " << mode << ", w = " << std::sqrt(w2);
  }
}

// 1e-10: what the reference eigenvectors of LAPACK carry for the lowest of 21 modes (w_max^2 / w_1^2 times round-off).
constexpr double kSpectrumTolerance = 1e-10;

TEST_P(FilterSpectrum, HasTheModesOfTheLumpedBeamAtFilteredFrequencies) {
  for (const double wf : {50.0, 400.0}) {
    expect_filtered_modes(with_ends(test::steel_beam(20), GetParam()), wf, Formulation::mixed, kSpectrumTolerance);
  }
}

TEST_P(FilterSpectrum, IsTheSameInTheHermiteForm) {
  expect_filtered_modes(with_ends(test::steel_beam(20), GetParam()), 100.0, Formulation::hermite, kSpectrumTolerance);
}

INSTANTIATE_TEST_SUITE_P(Ends, FilterSpectrum,
                         testing::Values(Ends{"free", {}, {}}, Ends{"pinned", test::kPinned, test::kPinned},
                                         Ends{"clamped", test::kClamped, test::kClamped},
                                         Ends{"cantilever", test::kClamped, {}},
                                         Ends{"springs",
                                              {.translational_stiffness = 1e6, .rotational_stiffness = 1e6},
                                              {.translational_stiffness = 5e5}}),
                         [](const auto& instance) { return std::string{instance.param.name}; });

TEST(FilterSpectrumOfUnevenBeam, HasTheModesOfTheLumpedBeamAtFilteredFrequencies) {
  const Section tube = tube_section(0.1, 0.08, 0.3);
  BeamParameters beam = test::steel_beam(8);
  beam.segments.push_back({.length = 3.0,
                           .elements = 11,
                           .bending_stiffness = 2.1e11 * tube.inertia,
                           .mass_per_length = 7850.0 * tube.area,
                           .shear_stiffness = 4e7,
                           .foundation_stiffness = 5e4});
  beam.left = test::kPinned;
  beam.tension = 2e5;
  beam.point_masses = {{.position = 4.0, .mass = 300.0}};
  expect_filtered_modes(beam, 120.0, Formulation::mixed, kSpectrumTolerance);
  expect_filtered_modes(beam, 120.0, Formulation::hermite, kSpectrumTolerance);
}

TEST(FilterSpectrumOnLineSupports, HasTheModesOfTheLumpedBeamAtFilteredFrequencies) {
  BeamParameters beam = test::steel_beam(20);
  beam.line_supports = {{.position = 2.0}, {.position = 5.2, .stiffness = 3e5}, {.position = 9.0}};
  expect_filtered_modes(beam, 50.0, Formulation::mixed, kSpectrumTolerance);
  expect_filtered_modes(beam, 400.0, Formulation::mixed, kSpectrumTolerance);
  expect_filtered_modes(beam, 100.0, Formulation::hermite, kSpectrumTolerance);
}

/// The steel beam, a gap, and a tube half as long: no two of their frequencies are alike.
BeamParameters two_beams(PetscInt elements_of_first) {
  const Section tube = tube_section(0.1, 0.08, 0.3);
  BeamParameters beam = test::steel_beam(elements_of_first);
  beam.segments.push_back({.length = 0.5, .elements = 1});
  beam.segments.push_back({.length = 5.0,
                           .elements = 21 - elements_of_first,
                           .bending_stiffness = 2.1e11 * tube.inertia,
                           .mass_per_length = 7850.0 * tube.area});
  return beam;
}

TEST(FilterSpectrumOfTwoBeams, HasTheModesOfBothAtFilteredFrequencies) {
  for (const PetscInt elements_of_first : {13, 12, 11}) {  // on two ranks, 11 put the gap between them
    BeamParameters beam = two_beams(elements_of_first);
    for (const bool held : {false, true}) {
      if (held) {
        beam.left = test::kClamped;
        beam.right = {.translational_stiffness = 1e5, .rotational_stiffness = 1e5};
        beam.line_supports = {{.position = 12.0}};
      }
      expect_filtered_modes(beam, 50.0, Formulation::mixed, kSpectrumTolerance);
      expect_filtered_modes(beam, 400.0, Formulation::mixed, kSpectrumTolerance);
      expect_filtered_modes(beam, 100.0, Formulation::hermite, kSpectrumTolerance);
    }
  }
}

/// The lowest modes are those of the lumped beam after its rigid ones, at wf = 50 rad/s.
void expect_lowest_modes(const BeamChain& beam, const test::Eigen& exact, PetscInt count, std::size_t rigid) {
  FilteredStructure line{beam, {.filter_frequency = 50.0}};
  const std::vector<Mode> modes = lowest_modes(line, count);
  ASSERT_EQ(modes.size(), static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < modes.size(); ++i) {
    const double w = std::sqrt(exact.values[i + rigid]);
    // The eigensolver works to 1e-10 on w^2 / (wf^2 + w^2), which loses (w / wf)^2 of it, here up to 1e2.
    EXPECT_NEAR(modes[i].frequency / w, 1.0, 1e-7);
    EXPECT_NEAR(modes[i].filtered / (50.0 * w / std::hypot(50.0, w)), 1.0, 1e-7);
  }
}

TEST(LowestModes, AreTheLowestBendingFrequenciesOfTheLumpedBeam) {
  const BeamChain beam{PETSC_COMM_WORLD, test::steel_beam(20)};
  expect_lowest_modes(beam, test::lumped_modes(beam), 4, 2);
}

TEST(LowestModes, OfTwoBeamsComeAfterFourRigidOnes) {
  const BeamChain beam{PETSC_COMM_WORLD, two_beams(12)};
  const test::Eigen exact = test::lumped_modes(beam);
  EXPECT_LT(std::abs(exact.values[3]), 1e-4);
  EXPECT_GT(exact.values[4], 1e2);
  expect_lowest_modes(beam, exact, 5, 4);
}

TEST(LowestModes, OfTwoEqualBeamsComeInPairs) {
  BeamParameters parameters = test::steel_beam(40);
  parameters.segments.push_back({.length = 0.5, .elements = 1});
  parameters.segments.push_back(parameters.segments[0]);
  const BeamChain beam{PETSC_COMM_WORLD, parameters};
  expect_lowest_modes(beam, test::lumped_modes(beam), 4, 4);
}

TEST(FilteredStructure, MatchesTheDenseSolveUnderLoad) {
  BeamParameters parameters = test::steel_beam(12);
  parameters.right = test::kClamped;
  const BeamChain beam{PETSC_COMM_WORLD, parameters};
  const double wf = 80.0;
  FilteredStructure line{beam, {.filter_frequency = wf}};
  const auto n = static_cast<std::size_t>(beam.nodes());
  test::Dense matrix = test::line_stiffness(beam);
  std::vector<double> displacement(n);
  std::vector<double> force(n);
  std::vector<double> right_hand_side(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double k = wf * wf * beam.mass(static_cast<PetscInt>(i));
    displacement[i] = 0.1 * std::sin(1.7 * static_cast<double>(i));
    force[i] = 1e4 * std::cos(0.9 * static_cast<double>(i));
    matrix(i, i) += k;
    right_hand_side[i] = k * displacement[i] + force[i];
  }
  displacement[n - 1] = 0.0;
  right_hand_side[n - 1] = 0.0;
  for (std::size_t j = 0; j < n; ++j) {
    matrix(n - 1, j) = matrix(j, n - 1) = j == n - 1 ? 1.0 : 0.0;
  }
  const std::vector<double> exact = test::solve(matrix, right_hand_side);
  const auto first = static_cast<std::size_t>(beam.begin());
  const auto count = static_cast<std::size_t>(beam.local_nodes());
  std::vector<double> stretch(count);
  std::vector<double> moment(count);
  line.solve(std::span{displacement}.subspan(first, count), std::span{force}.subspan(first, count), stretch, moment);
  for (std::size_t i = 0; i < count; ++i) {
    EXPECT_NEAR(stretch[i] + displacement[first + i], exact[first + i], 1e-13);  // displacements are of order 0.1
  }
}

TEST(FilteredStructure, RefusesASolverThatIsWrongAlthoughItSaysItConverged) {
  const test::Option type{"-filter_ksp_type", "preonly"};
  const test::Option preconditioner{"-filter_pc_type", "jacobi"};
  const BeamChain beam{PETSC_COMM_WORLD, test::steel_beam(20)};
  FilteredStructure line{beam, {.filter_frequency = 50.0}};
  const auto count = static_cast<std::size_t>(beam.local_nodes());
  std::vector<double> bent(count);
  for (std::size_t i = 0; i < count; ++i) {
    bent[i] = std::sin(static_cast<double>(beam.begin()) + static_cast<double>(i));
  }
  std::vector<double> stretch(count);
  std::vector<double> moment(count);
  EXPECT_THROW(line.solve(bent, std::vector<double>(count, 0.0), stretch, moment), SolveError);
}

}  // namespace
}  // namespace udar
