// ranks: 1; size: short
/// @file
/// Steps of even forces against closed forms, exact phases and their own energy.

#include "udar/modal/kernel_steps.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <numeric>
#include <utility>
#include <vector>

#include "support/reduced_table.hpp"
#include "support/steel_beam.hpp"
#include "udar/modal/exact_phases.hpp"
#include "udar/modal/reduced_model.hpp"

namespace udar {
namespace {

constexpr double kCompliance = 3e-7;

Drive weight(double gravity) { return {.load = {-gravity * std::sqrt(test::kReducedMass), 0.0}, .offset = {0.0}}; }

/// Falling at the support [m/s].
ModalState falling(double speed) {
  ModalState state{2, 1};
  state.velocity[0] = -speed * std::sqrt(test::kReducedMass);
  return state;
}

double speed_of(const ModalMotion& motion) { return motion.now().velocity[0] / std::sqrt(test::kReducedMass); }

void go(ModalMotion& motion, double until) {
  while (motion.now().time < until) {
    motion.advance(until);
  }
}

/// A spring beside a damper, z = omega lag / 2, throws a mass back where it no longer pushes, at this share of the
/// speed.
double rebound(double z) { return std::exp(-z * (std::numbers::pi - 2.0 * std::asin(z)) / std::sqrt(1.0 - z * z)); }

TEST(KernelSteps, ALagTakesWhatItsClosedFormSays) {
  const double omega = 1.0 / std::sqrt(test::kReducedMass * kCompliance);
  EXPECT_NEAR(rebound(0.05), 0.8587581018, 1e-10);
  EXPECT_NEAR(rebound(0.1), 0.7440793977, 1e-10);
  EXPECT_NEAR(rebound(0.3), 0.4509754529, 1e-10);
  for (const double z : {0.05, 0.1, 0.3}) {
    ReducedModel rest = test::over_centre(kCompliance, 0.0);
    rest.rest_lag = 2.0 * z / omega;
    ReducedModel support = test::over_centre(1e-6 * kCompliance, kCompliance);
    support.support_lag = {2.0 * z / omega};
    for (const ReducedModel& model : {rest, support}) {
      double last = 1.0;
      for (const double tolerance : {1e-3, 1e-5, 1e-7}) {
        KernelSteps motion{model, tolerance};
        motion.start(falling(4.0), weight(0.0));
        go(motion, 0.2);
        const double error = std::abs(speed_of(motion) / (4.0 * rebound(z)) - 1.0);
        EXPECT_LE(error, std::max(0.5 * last, 1e-5)) << z << ' ' << tolerance << ' ' << model.rest_lag;
        last = error;
      }
      EXPECT_LE(last, 1e-5) << z;
    }
  }
}

TEST(KernelSteps, BooksWhatIsLost) {
  for (const bool in_rest : {true, false}) {
    ReducedModel model = test::over_centre(kCompliance, in_rest ? 0.0 : kCompliance);
    (in_rest ? model.rest_lag : model.support_lag.emplace_back()) = 1e-3;
    KernelSteps motion{model, 1e-6};
    const Drive drive = weight(test::kGravity);
    motion.start(falling(4.0), drive);
    const double before = modal_energy(model, drive, motion.now()).total();
    double lost = 0.0;
    while (motion.now().time < 0.5) {
      const double end = motion.advance(0.5);
      lost += in_rest ? motion.flow(end).radiated : motion.flow(end).in_supports;
    }
    EXPECT_GT(lost, 0.04 * before);
    EXPECT_NEAR(modal_energy(model, drive, motion.now()).total() + lost, before, 1e-5 * before);
  }
}

std::pair<ModalState, Drive> tilted() {
  ModalState state{6, 4};
  state.velocity[0] = -3.0 * std::sqrt(test::kReducedMass);
  state.velocity[1] = 0.4 * std::sqrt(test::kReducedMass);
  Drive drive{.load = std::vector<double>(6, 0.0), .offset = {0.01, 0.02, 0.03, 0.04}};
  drive.load[0] = -test::kGravity * std::sqrt(test::kReducedMass);
  return {state, drive};
}

TEST(KernelSteps, ApproachExactPhases) {
  const ReducedModel model = test::table_on_supports(1e-8, test::kReducedMass);
  const auto [state, drive] = tilted();
  ExactPhases exact{model};
  exact.start(state, drive);
  go(exact, 0.1);
  double last = 1.0;
  for (const double tolerance : {1e-3, 1e-5, 1e-7}) {
    KernelSteps motion{model, tolerance};
    motion.start(state, drive);
    const double before = modal_energy(model, drive, motion.now()).total();
    go(motion, 0.1);
    double error = 0.0;
    for (std::size_t m = 0; m < 6; ++m) {
      error = std::max(error,
                       std::abs(motion.now().amplitude[m] - exact.now().amplitude[m]) / std::sqrt(test::kReducedMass));
    }
    EXPECT_LE(error, 0.3 * last) << tolerance;
    EXPECT_NEAR(modal_energy(model, drive, motion.now()).total(), before, 10.0 * tolerance * before);
    last = error;
  }
  EXPECT_LE(last, 1e-6);  // [m]
}

double gap_of(const ReducedModel& model, const Drive& drive, const ModalState& state, std::size_t point) {
  const auto row = model.row_of(point);
  double gap = drive.offset_at(point, state.time) + state.give[point];
  gap += std::inner_product(row.begin(), row.end(), state.amplitude.begin(), 0.0);
  for (std::size_t j = 0; j < model.points(); ++j) {
    gap += model.compliance[point * model.points() + j] * state.rest_force[j];
  }
  return gap;
}

/// Work of contact forces on gaps from a time to `now`, [r'g] - int r'' g dt of forces that are linear between.
double work_on_gaps(const ReducedModel& model, const Drive& drive, const KernelSteps& motion, const ModalState& from) {
  const ModalState& end = motion.now();
  const double length = end.time - from.time;
  double work = 0.0;
  for (std::size_t i = 0; i < model.points(); ++i) {
    work += end.force[i] * gap_of(model, drive, end, i) - from.force[i] * gap_of(model, drive, from, i);
    // Gauss's rule of five points; gaps hardly swing within a step.
    constexpr std::array<std::array<double, 2>, 5> kRule{{{0.5, 64.0 / 225.0},
                                                          {0.2307653449471584545, 0.2393143352496832340},
                                                          {0.7692346550528415455, 0.2393143352496832340},
                                                          {0.0469100770306680036, 0.1184634425280945438},
                                                          {0.9530899229693319964, 0.1184634425280945438}}};
    for (const auto& [place, weight] : kRule) {
      const ModalState within = motion.at(from.time + place * length);
      work -= weight * (end.force[i] - from.force[i]) * gap_of(model, drive, within, i);
    }
  }
  return work;
}

TEST(KernelSteps, WhatTheBalanceMissesIsTheWorkOnGaps) {
  ReducedModel model = test::table_on_supports(1e-8, test::kReducedMass);
  model.ratio.assign(6, 0.02);
  model.support_lag = {1e-4, 0.0, 2e-4, 1e-4};
  for (const double lag : {0.0, 1e-4}) {
    model.rest_lag = lag;
    auto [state, drive] = tilted();
    drive.retreat.assign(4, {0.0, 0.1, -2.0, 5.0});
    KernelSteps motion{model, 1e6};  // never refuses a step
    motion.start(state, drive);
    double wrong = 0.0;
    double missed = 0.0;
    int compared = 0;
    while (motion.now().time < 0.1) {
      const ModalState from = motion.now();
      const std::size_t before = motion.count();
      const double end = motion.advance(from.time + 2e-5);
      if (motion.count() != before + 1) {
        continue;  // a flight and what follows
      }
      const ModalFlow flow = motion.flow(end);
      const double gained = modal_energy(model, drive, motion.now()).total() - modal_energy(model, drive, from).total();
      const double balance = gained + flow.radiated + flow.in_supports + flow.in_modes - flow.support_work;
      ModalState begun = motion.at(from.time);  // with the force that a touch jumps to
      wrong = std::max(wrong, std::abs(balance - work_on_gaps(model, drive, motion, begun)));
      missed = std::max(missed, std::abs(balance));
      ++compared;
    }
    const double energy = modal_energy(model, drive, state).swinging();
    EXPECT_GT(compared, 1000);
    EXPECT_GT(missed, 1e-6 * energy) << lag;
    EXPECT_LT(wrong, 1e-12 * energy) << lag;
  }
}

TEST(KernelSteps, MirrorImagesTouchTogether) {
  ReducedModel model = test::table_on_supports(1e-8, test::kReducedMass);
  model.rest_lag = 1e-4;
  auto [state, drive] = tilted();
  state.velocity[1] = 0.0;
  drive.offset.assign(4, 0.0);
  KernelSteps motion{model, 1e-4};
  motion.start(state, drive);
  while (motion.now().time < 0.2) {
    motion.advance(0.2);
    EXPECT_NEAR(motion.now().force[0], motion.now().force[3], 1e-3);
    EXPECT_NEAR(motion.now().force[1], motion.now().force[2], 1e-3);
  }
  EXPECT_NEAR(motion.now().amplitude[1], 0.0, 1e-12);
  EXPECT_NEAR(motion.now().amplitude[3], 0.0, 1e-12);
}

TEST(KernelSteps, WithinAStepIsWhatTheStepSays) {
  ReducedModel model = test::table_on_supports(1e-8, test::kReducedMass);
  model.ratio.assign(6, 0.02);
  model.support_lag.assign(4, 1e-4);
  model.rest_lag = 1e-4;
  const auto [state, drive] = tilted();
  KernelSteps motion{model, 1e-4};
  motion.start(state, drive);
  while (motion.now().time < 0.03) {
    motion.advance(0.03);
  }
  const double end = motion.now().time;
  const double just_before = std::nextafter(end, 0.0);
  const ModalState now = motion.at(just_before);
  for (std::size_t m = 0; m < 6; ++m) {
    EXPECT_NEAR(now.amplitude[m], motion.now().amplitude[m], 1e-12);
    EXPECT_NEAR(now.velocity[m], motion.now().velocity[m], 1e-9);
  }
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(now.rest_force[i], motion.now().rest_force[i], 1e-3);
    EXPECT_NEAR(now.give[i], motion.now().give[i], 1e-12);
    EXPECT_NEAR(motion.flow(just_before).impulse[i], motion.flow(end).impulse[i], 1e-6);
  }
  EXPECT_NEAR(motion.flow(just_before).in_modes, motion.flow(end).in_modes, 1e-6);
  EXPECT_NEAR(motion.flow(just_before).radiated, motion.flow(end).radiated, 1e-6);
}

TEST(KernelSteps, DampedModesFallIdle) {
  ReducedModel model = test::over_centre(kCompliance, 0.0);
  model.frequency = {0.0, 100.0};
  model.ratio = {0.0, 0.01};
  ModalState state{2, 1};
  state.amplitude = {10.0, 1.0};
  KernelSteps motion{model, 1e-4};
  const Drive drive = weight(0.0);
  motion.start(state, drive);
  EXPECT_EQ(motion.advance(1.0), 1.0);  // one flight
  const double damped = 100.0 * std::sqrt(1.0 - 1e-4);
  EXPECT_NEAR(motion.now().amplitude[1], std::exp(-1.0) * (std::cos(damped) + 1.0 / damped * std::sin(damped)), 1e-13);
  EXPECT_NEAR(motion.flow(1.0).in_modes + modal_energy(model, drive, motion.now()).total(), 0.5 * 1e4, 1e-9);
}

TEST(KernelSteps, ASupportThatRisesDoesItsWork) {
  // At rest on a spring whose foot goes by a t^2 / 2: y'' = -omega^2 (y - s).
  const ReducedModel model = test::over_centre(kCompliance, 0.0);
  const double omega = 1.0 / std::sqrt(test::kReducedMass * kCompliance);
  const double a = 2.0;
  Drive drive = weight(test::kGravity);
  drive.retreat = {{0.0, 0.0, -0.5 * a, 0.0}};
  ModalState state{2, 1};
  state.amplitude[0] = -test::kReducedMass * test::kGravity * kCompliance * std::sqrt(test::kReducedMass);
  double last = 1.0;
  for (const double tolerance : {1e-4, 1e-6, 1e-8}) {
    KernelSteps motion{model, tolerance};
    motion.start(state, drive);
    const double before = modal_energy(model, drive, motion.now()).total();
    double work = 0.0;
    while (motion.now().time < 0.1) {
      const double end = motion.advance(0.1);
      work += motion.flow(end).support_work;
    }
    const double rise = 0.5 * a * 0.01 - a / (omega * omega) * (1.0 - std::cos(omega * 0.1));
    const double error =
        std::abs((motion.now().amplitude[0] - state.amplitude[0]) / std::sqrt(test::kReducedMass) / rise - 1.0);
    EXPECT_LE(error, std::max(0.5 * last, 1e-9)) << tolerance;
    EXPECT_NEAR(modal_energy(model, drive, motion.now()).total() - before, work, 10.0 * tolerance * work);
    last = error;
  }
  EXPECT_LE(last, 1e-6);
}

TEST(KernelSteps, AFaceThatComesToABeamInTheAirIsMetInTime) {
  const ReducedModel model = test::over_centre(kCompliance, 0.0);
  Drive drive = weight(0.0);
  drive.offset = {1.0};
  drive.retreat = {{0.0, 0.0, 0.0, -8.0}};  // 1 = 8 t^3
  KernelSteps motion{model, 1e-4};
  motion.start(ModalState{2, 1}, drive);
  motion.advance(1.0);
  ASSERT_FALSE(motion.contacts().empty());
  EXPECT_NEAR(motion.contacts().front().from, 0.5, 1e-12);
}

TEST(KernelSteps, GoOnBitForBit) {
  ReducedModel model = test::table_on_supports(1e-8, test::kReducedMass);
  model.rest_lag = 1e-4;
  const auto [state, drive] = tilted();
  KernelSteps whole{model, 1e-4};
  whole.start(state, drive);
  whole.advance(0.2);
  const double there = whole.now().time;
  KernelSteps rest{model, 1e-4};
  rest.resume(whole.memory(), drive, there);
  go(whole, 0.2);
  go(rest, 0.2);
  EXPECT_EQ(whole.now().amplitude, rest.now().amplitude);
  EXPECT_EQ(whole.now().rest_force, rest.now().rest_force);
  const double last = whole.now().time;
  whole.advance(0.25);
  whole.take_back();
  EXPECT_EQ(whole.now().time, last);
  EXPECT_EQ(whole.now().amplitude, rest.now().amplitude);
}

}  // namespace
}  // namespace udar
