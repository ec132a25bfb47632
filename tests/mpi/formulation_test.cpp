// ranks: 1 2 3; size: medium
/// @file
/// The two forms of the line are the same model, however few nodes a rank has.

#include <gtest/gtest.h>

#include <cmath>

#include "support/steel_beam.hpp"

namespace udar {
namespace {

TEST(Formulations, GiveTheSameLineMomentsAndEnergyDownToTwoNodesPerRank) {
  for (const PetscInt elements : {PetscInt{5}, PetscInt{6}, PetscInt{11}}) {
    BeamParameters parameters = test::steel_beam(elements);
    parameters.right = test::kClamped;
    parameters.segments[0].shear_stiffness = 3e7;
    const BeamChain beam{PETSC_COMM_WORLD, parameters};
    const auto count = static_cast<std::size_t>(beam.local_nodes());
    std::vector<double> displacement(count);
    std::vector<double> force(count);
    for (std::size_t i = 0; i < count; ++i) {
      const double x = beam.position(beam.begin() + static_cast<PetscInt>(i));
      displacement[i] = 0.01 * (10.0 - x) * std::sin(x + 1.0);
      force[i] = 1e4 * std::cos(2.0 * x);
    }
    std::array<std::vector<double>, 2> stretch;
    std::array<std::vector<double>, 2> moment;
    std::array<double, 2> energy{};
    for (const Formulation form : {Formulation::mixed, Formulation::hermite}) {
      const auto which = static_cast<std::size_t>(form);
      stretch[which].resize(count);
      moment[which].resize(count);
      FilteredStructure line{beam, {.filter_frequency = 80.0, .formulation = form}};
      line.solve(displacement, force, stretch[which], moment[which]);
      std::vector<double> position(count);
      for (std::size_t i = 0; i < count; ++i) {
        position[i] = displacement[i] + stretch[which][i];
      }
      energy[which] = line.filter_operator().strain_energy(position, moment[which]);
    }
    MPI_Allreduce(MPI_IN_PLACE, energy.data(), 2, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
    // The Hermite form loses some digits to the conditioning of its rotations; moments are of order 1e4 N m here.
    for (std::size_t i = 0; i < count; ++i) {
      EXPECT_NEAR(stretch[0][i], stretch[1][i], 1e-12) << "node " << beam.begin() + static_cast<PetscInt>(i);
      EXPECT_NEAR(moment[0][i], moment[1][i], 1e-6) << "node " << beam.begin() + static_cast<PetscInt>(i);
    }
    EXPECT_NEAR(energy[1] / energy[0], 1.0, 1e-9);
  }
}

}  // namespace
}  // namespace udar
