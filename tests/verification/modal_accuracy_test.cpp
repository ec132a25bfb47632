// ranks: 1; size: medium
/// @file
/// How the modal integrator's errors fall with modes and tolerance, and what they cost: the steel beam on two supports.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "support/modal_fall.hpp"
#include "udar/modal/exact_phases.hpp"
#include "udar/modal/kernel_steps.hpp"

namespace udar {
namespace {

constexpr PetscInt kElements = 160;

/// Where end, middle and centre of mass are [m], row by row, in the first 50 ms.
std::vector<std::array<double, 3>> course_of(PetscInt modes, double stiffness, double row_length) {
  const test::ModalFall fall{kElements, test::two_points(kElements, stiffness), {.modes = modes}};
  ExactPhases motion{fall.model.reduced()};
  fall.start(motion);
  std::vector<double> position(fall.beam.points().points());
  std::vector<double> velocity(position.size());
  std::vector<std::array<double, 3>> rows;
  constexpr double kEnd = 0.05;
  for (int row = 1; row * row_length < kEnd; ++row) {
    const double time = row * row_length;
    while (motion.now().time < time) {
      motion.advance(time);
    }
    fall.model.expand(motion.now(), position, velocity);
    rows.push_back({position.front(), position[kElements / 2], fall.centre(motion.now().amplitude)});
  }
  return rows;
}

/// Root of the mean square [mm].
double distance(const std::vector<std::array<double, 3>>& a, const std::vector<std::array<double, 3>>& b) {
  double sum = 0.0;
  for (std::size_t row = 0; row < a.size(); ++row) {
    for (std::size_t i = 0; i < 3; ++i) {
      sum += std::pow(a[row][i] - b[row][i], 2);
    }
  }
  return 1e3 * std::sqrt(sum / (3.0 * static_cast<double>(a.size())));
}

TEST(ModalAccuracy, ErrorsFallExponentiallyWithModes) {
  struct Table {
    double stiffness;             // [N/m]
    std::array<double, 5> error;  // of 8, 12, 16, 20, 24 modes in the first 50 ms [mm]
  };
  constexpr std::array<PetscInt, 5> kModes{8, 12, 16, 20, 24};
  for (const Table& table :
       {Table{2e8, {0.54, 0.017, 0.0030, 0.0015, 0.0004}}, Table{2e9, {8.0, 2.4, 0.71, 0.093, 0.028}}}) {
    const auto converged = course_of(64, table.stiffness, 5e-4);
    for (std::size_t k = 0; k < kModes.size(); ++k) {
      const double error = distance(course_of(kModes[k], table.stiffness, 5e-4), converged);
      EXPECT_NEAR(error, table.error[k], 0.2 * table.error[k]) << table.stiffness << ' ' << kModes[k];
    }
  }
}

TEST(ModalAccuracy, TwentyFourModesOnSpringsInEightySolves) {
  constexpr double kStiffness = 2e9;
  const test::ModalFall fall{kElements, test::two_points(kElements, kStiffness), {.modes = 24}};
  EXPECT_LE(fall.model.solves(), 80);
  ExactPhases motion{fall.model.reduced()};
  fall.start(motion);
  EXPECT_NEAR(test::land(fall, motion, 1.0).rebound, 0.7272, 2e-4);
  const auto rows = course_of(24, kStiffness, 2e-5);
  const auto lowest = [&](std::size_t which) {
    return (*std::ranges::min_element(rows, {}, [which](const auto& row) { return row[which]; }))[which];
  };
  EXPECT_NEAR(lowest(0), -0.03196, 1e-5);
  EXPECT_NEAR(lowest(1), -0.03676, 1e-5);
}

TEST(ModalAccuracy, StepsKeepTheEnergyToTheirToleranceAndFindTheThirdLanding) {
  struct Tolerance {
    double asked;
    double balance;  // of the energy, over three landings
    double second;   // landing is off by [s]
  };
  constexpr std::array kTolerances{Tolerance{1e-2, 4e-3, 3e-4}, Tolerance{1e-3, 5e-4, 3e-4},
                                   Tolerance{1e-4, 1e-4, 3e-4}, Tolerance{1e-5, 1e-5, 4e-5},
                                   Tolerance{1e-6, 5e-6, 1e-5}};
  for (const double stiffness : {2e7, 2e8, 2e9}) {
    const test::ModalFall fall{kElements, test::two_points(kElements, stiffness), {.modes = 24}};
    ExactPhases exact{fall.model.reduced()};
    fall.start(exact);
    const double before = fall.energy(exact.now());
    const test::Landings truth = test::land(fall, exact, 1.6);
    ASSERT_GE(truth.times.size(), 2U);
    double third = 0.0;
    for (const Tolerance& tolerance : kTolerances) {
      KernelSteps motion{fall.model.reduced(), tolerance.asked};
      fall.start(motion);
      const test::Landings found = test::land(fall, motion, 1.6);
      EXPECT_LT(std::abs(fall.energy(motion.now()) / before - 1.0), tolerance.balance)
          << stiffness << ' ' << tolerance.asked;
      ASSERT_GE(found.times.size(), 2U);
      EXPECT_NEAR(found.times[0], truth.times[0], tolerance.second) << stiffness << ' ' << tolerance.asked;
      third = std::abs(found.times[1] - truth.times[1]);
      EXPECT_LT(motion.count() + motion.rejected(), 6000U);
    }
    // On 2e8 and 2e9 N/m it grazes: what is wrong before grows a hundredfold.
    EXPECT_LT(third, stiffness < 1e8 ? 5e-6 : 5e-4) << stiffness;
  }
}

TEST(ModalAccuracy, RigidPointsScatterAtFivePlacesAndFiveNumbersOfModes) {
  struct Place {
    PetscInt node;  // of the left point, the other is its mirror image
    double ends;    // lowest, by fine Moreau-Jean (docs/verification.md) [m]
    double middle;
    double rebound;  // [m/s]
  };
  constexpr std::array kPlaces{Place{29, -0.023134, -0.041828, 2.3789}, Place{31, -0.029555, -0.038177, 2.5747},
                               Place{32, -0.032412, -0.036316, 2.9576}, Place{33, -0.034814, -0.034915, 2.9326},
                               Place{35, -0.035418, -0.033094, 3.0169}};
  constexpr std::array<PetscInt, 5> kModes{24, 26, 28, 30, 32};
  std::array<double, 3> square{};
  for (const Place& place : kPlaces) {
    for (const PetscInt modes : kModes) {
      std::vector<LinePoint> points(2);
      points[0].node = place.node;
      points[1].node = kElements - place.node;
      const test::ModalFall fall{kElements, points, {.modes = modes, .retardation = 0.07}};
      KernelSteps motion{fall.model.reduced(), 1e-4};
      fall.start(motion);
      std::vector<double> position(fall.beam.points().points());
      std::vector<double> velocity(position.size());
      double ends = 0.0;
      double middle = 0.0;
      for (int row = 1; row <= 500; ++row) {
        while (motion.now().time < 1e-4 * row) {
          motion.advance(1e-4 * row);
        }
        fall.model.expand(motion.now(), position, velocity);
        ends = std::min(ends, position.front());
        middle = std::min(middle, position[kElements / 2]);
      }
      const double rebound = fall.rebound(motion.now()) * test::kFallSpeed;
      square[0] += std::pow(ends / place.ends - 1.0, 2) / 25.0;
      square[1] += std::pow(middle / place.middle - 1.0, 2) / 25.0;
      square[2] += std::pow(rebound / place.rebound - 1.0, 2) / 25.0;
    }
  }
  // Found: 1.6, 0.5 and 3.4 %.
  EXPECT_LT(std::sqrt(square[0]), 0.02);
  EXPECT_LT(std::sqrt(square[1]), 0.01);
  EXPECT_LT(std::sqrt(square[2]), 0.04);
}

TEST(ModalAccuracy, EveryModeKeepsItsFrequencyInFlight) {
  const test::ModalFall fall{kElements, {}, {.modes = 32}};
  const ReducedModel& model = fall.model.reduced();
  for (std::size_t m = 2; m < model.modes(); ++m) {
    constexpr double kPeriods = 1e4;
    const double angle = kPeriods * 2.0 * std::numbers::pi;
    ModalState state{model.modes(), 0};
    state.amplitude[m] = 1.0;
    Drive still{.load = std::vector<double>(model.modes(), 0.0), .offset = {}};
    ExactPhases phases{model};
    KernelSteps steps{model, 1e-4};
    for (ModalMotion* motion : {static_cast<ModalMotion*>(&phases), static_cast<ModalMotion*>(&steps)}) {
      motion->start(state, still);
      EXPECT_EQ(motion->advance(angle / model.frequency[m]), angle / model.frequency[m]);
      EXPECT_NEAR(motion->now().velocity[m] / model.frequency[m], 0.0, 1e-12 * angle) << m;
      EXPECT_NEAR(motion->now().amplitude[m], 1.0, 1e-12) << m;
    }
  }
}

}  // namespace
}  // namespace udar
