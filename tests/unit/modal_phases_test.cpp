// ranks: 1; size: short
/// @file
/// The exact motion of reduced models against closed forms.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "support/dense.hpp"
#include "support/reduced_table.hpp"
#include "support/steel_beam.hpp"
#include "udar/modal/exact_phases.hpp"
#include "udar/modal/oscillator.hpp"
#include "udar/modal/reduced_model.hpp"
#include "udar/numerics/symmetric_eigen.hpp"

namespace udar {
namespace {

Drive weight(double gravity, std::vector<double> offset) {
  return {.load = {-gravity * std::sqrt(test::kReducedMass), 0.0}, .offset = std::move(offset)};
}

TEST(ExactPhases, FlatFallOnACentralSupportLeavesAsItCame) {
  const double compliance = 3e-7;
  const double give = 1.0 / 2e8;
  const ReducedModel model = test::over_centre(compliance, give);
  const double speed = 4.0;
  const double omega = 1.0 / std::sqrt(test::kReducedMass * (compliance + give));
  ExactPhases motion{model};
  ModalState state{2, 1};
  state.velocity[0] = -speed * std::sqrt(test::kReducedMass);
  motion.start(state, weight(test::kGravity, {0.0}));
  ASSERT_EQ(motion.now().touches[0], 1);
  const double contact = (std::numbers::pi + 2.0 * std::atan(test::kGravity / (omega * speed))) / omega;
  const double lowest = 0.5 * contact;
  const double largest = test::kReducedMass * (test::kGravity + std::hypot(test::kGravity, omega * speed));
  EXPECT_NEAR(motion.at(lowest).force[0], largest, 1e-12 * largest);
  // 1e-13: a zero is found to the rounding of its function.
  EXPECT_NEAR(motion.advance(1.0), contact, 1e-13);
  EXPECT_EQ(motion.now().touches[0], 0);
  EXPECT_NEAR(motion.now().velocity[0], speed * std::sqrt(test::kReducedMass),
              1e-12 * speed * std::sqrt(test::kReducedMass));
  // And it comes back after the flight of a ball.
  EXPECT_NEAR(motion.advance(10.0), contact + 2.0 * speed / test::kGravity, 1e-12);
  EXPECT_EQ(motion.count(), 2U);
}

TEST(ExactPhases, WhatIsLaidDownStaysThere) {
  const ReducedModel model = test::over_centre(3e-7, 0.0);
  const double weighs = test::kReducedMass * test::kGravity;
  ModalState state{2, 1};
  state.amplitude[0] = -weighs * 3e-7 * std::sqrt(test::kReducedMass);
  ExactPhases motion{model};
  motion.start(state, weight(test::kGravity, {0.0}));
  EXPECT_DOUBLE_EQ(motion.advance(100.0), 100.0);
  EXPECT_NEAR(motion.now().force[0], weighs, 1e-12 * weighs);
  EXPECT_NEAR(motion.now().velocity[0], 0.0, 1e-12);
}

TEST(ExactPhases, WhatIsReleasedAtTheSupportTouchesAtOnce) {
  const ReducedModel model = test::over_centre(3e-7, 0.0);
  ExactPhases motion{model};
  motion.start(ModalState{2, 1}, weight(test::kGravity, {0.0}));
  ASSERT_EQ(motion.now().touches[0], 1);
  const double omega = 1.0 / std::sqrt(test::kReducedMass * 3e-7);
  const double half_way = std::numbers::pi / omega;
  EXPECT_NEAR(motion.at(half_way).force[0], 2.0 * test::kReducedMass * test::kGravity,
              1e-9 * test::kReducedMass * test::kGravity);
}

TEST(ExactPhases, ALoadThatGrowsAndASupportThatRisesAreExact) {
  // Held between a support and its weight: y = u t - g t^2/2 + a t^3/6 until it touches again.
  const ReducedModel model = test::over_centre(3e-7, 0.0);
  ModalState state{2, 1};
  state.velocity[0] = 1.0 * std::sqrt(test::kReducedMass);
  Drive drive = weight(test::kGravity, {0.0});
  drive.load_rate = {-6.0 * std::sqrt(test::kReducedMass), 0.0};
  drive.offset_rate = {-0.25};  // the support rises
  ExactPhases motion{model};
  motion.start(state, drive);
  const double back = motion.advance(10.0);
  EXPECT_NEAR(0.75 * back - 0.5 * test::kGravity * back * back - back * back * back, 0.0, 1e-14);
}

TEST(ExactPhases, KeepsItsEnergyOverManyChanges) {
  const ReducedModel model = test::table_on_supports(1e-8, test::kReducedMass);
  ModalState state{6, 4};
  state.velocity[0] = -3.0 * std::sqrt(test::kReducedMass);
  state.velocity[1] = 0.4 * std::sqrt(test::kReducedMass);
  Drive drive{.load = std::vector<double>(6, 0.0), .offset = {0.01, 0.02, 0.03, 0.04}};
  drive.load[0] = -test::kGravity * std::sqrt(test::kReducedMass);
  ExactPhases motion{model};
  motion.start(state, drive);
  const double before = modal_energy(model, drive, motion.now()).total();
  while (motion.advance(2.0) < 2.0) {
  }
  EXPECT_GT(motion.count(), 20U);
  // Rounding of some hundred phases.
  EXPECT_NEAR(modal_energy(model, drive, motion.now()).total(), before, 1e-12 * before);
}

TEST(ExactPhases, MirrorImagesTouchTogether) {
  const ReducedModel model = test::table_on_supports(1e-8, test::kReducedMass);
  ModalState state{6, 4};
  state.velocity[0] = -3.0 * std::sqrt(test::kReducedMass);
  Drive drive{.load = std::vector<double>(6, 0.0), .offset = std::vector<double>(4, 0.0)};
  drive.load[0] = -test::kGravity * std::sqrt(test::kReducedMass);
  ExactPhases motion{model};
  motion.start(state, drive);
  while (motion.advance(1.0) < 1.0) {
    EXPECT_EQ(motion.now().touches[0], motion.now().touches[3]);
    EXPECT_EQ(motion.now().touches[1], motion.now().touches[2]);
  }
  EXPECT_GT(motion.count(), 4U);
  // A landing makes rounding some hundred times larger.
  EXPECT_NEAR(motion.now().amplitude[1], 0.0, 1e-12);
}

/// Eigenvalues of Lambda + b_S'(W + 1/K)_S^-1 b_S, the last.
double fastest_squared(const ReducedModel& model, unsigned touching) {
  const std::size_t modes = model.modes();
  std::vector<std::size_t> set;
  for (std::size_t i = 0; i < model.points(); ++i) {
    if ((touching >> i & 1U) != 0) {
      set.push_back(i);
    }
  }
  const std::vector<double> closed = model.closed_compliance();
  test::Dense compliance{set.size()};
  for (std::size_t a = 0; a < set.size(); ++a) {
    for (std::size_t b = 0; b < set.size(); ++b) {
      compliance(a, b) = closed[set[a] * model.points() + set[b]];
    }
  }
  std::vector<double> matrix(modes * modes);
  for (std::size_t m = 0; m < modes; ++m) {
    std::vector<double> moved(set.size());
    std::ranges::transform(set, moved.begin(), [&](std::size_t i) { return model.row_of(i)[m]; });
    const std::vector<double> force = set.empty() ? std::vector<double>{} : test::solve(compliance, moved);
    for (std::size_t n = 0; n < modes; ++n) {
      matrix[m * modes + n] = m == n ? model.frequency[m] * model.frequency[m] : 0.0;
      for (std::size_t a = 0; a < set.size(); ++a) {
        matrix[m * modes + n] += model.row_of(set[a])[n] * force[a];
      }
    }
  }
  std::vector<double> values(modes);
  symmetric_eigen(matrix, values);
  return values.back();
}

TEST(ReducedModel, NoFrequencyIsAboveItsBound) {
  for (const double give : {0.0, 1e-9, 1e-8, 1e-6}) {
    const ReducedModel model = test::table_on_supports(give, test::kReducedMass);
    const double bound = model.frequency_bound();
    double fastest = 0.0;
    for (unsigned touching = 0; touching < 16; ++touching) {
      fastest = std::max(fastest, std::sqrt(fastest_squared(model, touching)));
    }
    EXPECT_LE(fastest, bound * (1.0 + 1e-12)) << give;
    // Weyl's inequality adds the largest of both: no more than sqrt(2) in all.
    EXPECT_GE(fastest, bound / std::numbers::sqrt2) << give;
  }
}

TEST(Oscillator, SeriesAndSinesAgree) {
  // On both sides of where one gives way to the other, with and without damping.
  for (const double ratio : {0.0, 0.01, 0.5}) {
    const double w = 100.0;
    const Oscillator below = Oscillator::after(0.005 * (1.0 - 1e-14), w, ratio);
    const Oscillator above = Oscillator::after(0.005 * (1.0 + 1e-14), w, ratio);
    EXPECT_NEAR(below.c, above.c, 1e-14);
    EXPECT_NEAR(below.s, above.s, 1e-16);
    EXPECT_NEAR(below.ds, above.ds, 1e-14);
    EXPECT_NEAR(below.f2 * w * w, above.f2 * w * w, 1e-14);
    EXPECT_NEAR(below.f3 * w * w * w, above.f3 * w * w * w, 1e-14);
    EXPECT_NEAR(below.f4 * w * w * w * w, above.f4 * w * w * w * w, 1e-14);
  }
}

TEST(Oscillator, KeepsItsPhaseOverManyPeriods) {
  const double w = 60.0;
  const double period = 2.0 * std::numbers::pi / w;
  const Oscillator after = Oscillator::after(1e4 * period, w);
  EXPECT_NEAR(after.c, 1.0, 1e-12);
  EXPECT_NEAR(after.s * w, 0.0, 1e-11);  // rounding of an angle of 6e4
}

}  // namespace
}  // namespace udar
