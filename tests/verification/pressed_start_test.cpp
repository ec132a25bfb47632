// ranks: 1 2; size: short
/// @file
/// Supports on springs that press on the line from the start: closed forms, the ledger from its first row, refusals.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "support/line_ways.hpp"
#include "support/steel_beam.hpp"
#include "support/world.hpp"

namespace udar {
namespace {

/// A fall that begins with faces as high, or as deep, as given.
ModelParameters pressed(PetscInt elements, std::vector<Support> supports, double speed = 0.0) {
  return {.beam = test::steel_beam(elements),
          .filter = test::unfiltered(1e-4),
          .gravity = test::kGravity,
          .loads = {},
          .initial = {.velocity = speed},
          .supports = std::move(supports)};
}

Support pressed_spring(double height, double stiffness, SupportSide side = SupportSide::below) {
  Support support{.position = 5.0, .height = height, .side = side};
  support.stiffness = stiffness;
  return support;
}

/// Three nodes are a mass on what the line between them gives way by, L^3 / (192 EI), and the spring under it.
const double kGive = 1000.0 / (192.0 * test::steel_beam(2).segments[0].bending_stiffness);

void expect_balance(const test::Recorder& rows, double tolerance) {
  for (std::size_t k = 0; k < rows.times.size(); ++k) {
    EXPECT_NEAR(rows.energies[k].drift(), 0.0, tolerance) << rows.times[k];
  }
}

TEST(PressedStart, ModesLeaveASpringAsAMassDoes) {
  if (test::world_size() > 1) {
    GTEST_SKIP() << "three nodes are one rank's";
  }
  constexpr double kStiffness = 3e6;
  constexpr double kDepth = 0.05;
  const test::Option type{"-ts_type", "modal"};
  const test::Option modes{"-modal_modes", "2"};
  const test::Option end{"-ts_max_time", "0.1"};
  test::Fall fall{pressed(2, {pressed_spring(kDepth, kStiffness)})};
  test::Recorder rows{1e-3};
  fall.dynamics.add_observer(rows);
  fall.dynamics.solve();
  const double mass = fall.beam.total_mass();
  const double give = kGive + 1.0 / kStiffness;
  const double omega = 1.0 / std::sqrt(mass * give);
  const double sag = test::kGravity / (omega * omega);
  const double leaves = std::acos(sag / (sag - kDepth)) / omega;
  ASSERT_LT(leaves, 0.1);
  for (std::size_t k = 0; k < rows.times.size(); ++k) {
    const double t = rows.times[k];
    const double z = t < leaves ? -sag + (sag - kDepth) * std::cos(omega * t) : 0.0;
    const double held = 0.5 * std::pow(z / give, 2) / kStiffness;
    EXPECT_NEAR(rows.energies[k].support_springs, held, 1e-10 * kDepth * kDepth / give) << t;
    // The line stands on the spring.
    EXPECT_NEAR(t < leaves ? rows.lines[k][1] : 0.0, t < leaves ? kDepth + z / give / kStiffness : 0.0, 1e-12) << t;
  }
  expect_balance(rows, 1e-12);
  EXPECT_NEAR(rows.energies.front().initial, rows.energies.front().total(), 0.0);
  EXPECT_NEAR(fall.dynamics.counts().last_contact_time, leaves, 1e-12);
  const double speed = (kDepth - sag) * omega * std::sin(omega * leaves);
  EXPECT_NEAR(test::momentum_of(fall.line, fall.dynamics) / mass, speed - test::kGravity * (0.1 - leaves), 1e-10);
  EXPECT_NEAR(fall.dynamics.support_impulses()[0], mass * (speed + test::kGravity * leaves), 1e-9 * mass);
  EXPECT_NEAR(fall.dynamics.smallest_line_gap().gap, -kDepth / give / kStiffness, 1e-12);
}

TEST(PressedStart, TwoSpringsThatSqueezeAreOneThatHoldsBothWays) {
  if (test::world_size() > 1) {
    GTEST_SKIP() << "three nodes are one rank's";
  }
  constexpr double kStiffness = 3e6;
  constexpr double kDepth = 0.02;
  constexpr double kSpeed = -0.3;
  const test::Option type{"-ts_type", "modal"};
  const test::Option modes{"-modal_modes", "2"};
  const test::Option end{"-ts_max_time", "0.3"};
  ModelParameters parameters =
      pressed(2, {pressed_spring(kDepth, kStiffness), pressed_spring(-kDepth, kStiffness, SupportSide::above)}, kSpeed);
  parameters.gravity = 0.0;
  test::Fall fall{parameters};
  test::Recorder rows{1e-3};
  fall.dynamics.add_observer(rows);
  fall.dynamics.solve();
  const double softened = 1.0 + 2.0 * kStiffness * kGive;  // by the line itself
  const double omega = std::sqrt(2.0 * kStiffness / (fall.beam.total_mass() * softened));
  for (std::size_t k = 0; k < rows.times.size(); ++k) {
    const double line = kSpeed / omega * std::sin(omega * rows.times[k]) / softened;
    ASSERT_LT(std::abs(line), kDepth) << "both press all the time";
    EXPECT_NEAR(rows.lines[k][1], line, 1e-12) << rows.times[k];
    EXPECT_NEAR(rows.energies[k].support_springs, kStiffness * (kDepth * kDepth + line * line), 1e-8)
        << rows.times[k] << " [J]";
  }
  expect_balance(rows, 1e-12);
}

/// z'' = r/M - g, z + W r + y = 0, k y + c y' = r, by Runge-Kutta's fourth order in tiny steps.
std::vector<double> damped_positions(double mass, double stiffness, double damping, double depth, std::size_t rows) {
  struct State {
    double z;
    double v;
    double y;
  };
  const auto rate = [&](const State& at) {
    const double r = std::max(-(at.z + at.y) / kGive, 0.0);
    return State{at.v, r / mass - test::kGravity, (r - stiffness * at.y) / damping};
  };
  const auto moved = [](const State& at, const State& by, double h) {
    return State{at.z + h * by.z, at.v + h * by.v, at.y + h * by.y};
  };
  const double first = depth / (kGive + 1.0 / stiffness) / stiffness;
  State now{-depth, 0.0, first};
  std::vector<double> all;
  constexpr int kSteps = 2000;
  constexpr double h = 1e-3 / kSteps;
  for (std::size_t row = 0; row < rows; ++row) {
    all.push_back(now.z + depth);
    for (int step = 0; step < kSteps; ++step) {
      const State a = rate(now);
      const State b = rate(moved(now, a, 0.5 * h));
      const State c = rate(moved(now, b, 0.5 * h));
      const State d = rate(moved(now, c, h));
      now = moved(now,
                  {(a.z + 2.0 * (b.z + c.z) + d.z) / 6.0, (a.v + 2.0 * (b.v + c.v) + d.v) / 6.0,
                   (a.y + 2.0 * (b.y + c.y) + d.y) / 6.0},
                  h);
    }
  }
  return all;
}

TEST(PressedStart, ADamperBesideTheSpringTakesItsShare) {
  if (test::world_size() > 1) {
    GTEST_SKIP() << "three nodes are one rank's";
  }
  constexpr double kStiffness = 3e6;
  constexpr double kDamping = 5e3;
  constexpr double kDepth = 0.05;
  const test::Option type{"-ts_type", "modal"};
  const test::Option modes{"-modal_modes", "2"};
  const test::Option end{"-ts_max_time", "0.06"};
  const test::Option tolerance{"-ts_rtol", "1e-7"};
  std::vector<Support> supports{pressed_spring(kDepth, kStiffness)};
  supports[0].damping = kDamping;
  test::Fall fall{pressed(2, supports)};
  test::Recorder rows{1e-3};
  fall.dynamics.add_observer(rows);
  fall.dynamics.solve();
  const std::vector<double> exact =
      damped_positions(fall.beam.total_mass(), kStiffness, kDamping, kDepth, rows.times.size());
  for (std::size_t k = 0; k < rows.times.size(); ++k) {
    // The centre of mass: a quarter of the ends and half of the middle.
    const double centre = 0.25 * (rows.positions[k][0] + rows.positions[k][2]) + 0.5 * rows.positions[k][1];
    EXPECT_NEAR(centre, exact[k], 1e-6) << rows.times[k];
  }
  expect_balance(rows, 1e-5);
  EXPECT_GT(rows.energies.back().lost_in_dampers, 0.02 * rows.energies.front().support_springs);
}

/// Under the whole beam, per mass.
Support table(double height, double stiffness_over_mass) {
  const BeamParameters beam = test::steel_beam(6);
  Support support{.position = 5.0, .width = 10.0, .height = height};
  support.stiffness = stiffness_over_mass * beam.segments[0].mass_per_length * beam.segments[0].length;
  return support;
}

TEST(PressedStart, MoreauJeanLeavesATableOfSprings) {
  constexpr double kDepth = 0.01;
  constexpr double kPlace = 0.3;  // of the face
  constexpr double w = 100.0;
  const double sag = test::kGravity / (w * w);
  const double mass = 7850.0 * std::numbers::pi * 0.1;
  const test::Option end{"-ts_max_time", "0.015"};
  double before = 0.0;
  for (const double step : {1e-3, 5e-4, 2.5e-4}) {
    ModelParameters parameters = pressed(6, {table(kPlace, w * w)});
    parameters.filter = test::unfiltered(step);
    parameters.initial.height = kPlace - kDepth;
    test::Fall fall{parameters};
    test::Recorder rows{1e-3};
    fall.dynamics.add_observer(rows);
    fall.dynamics.solve();
    double error = 0.0;
    for (std::size_t k = 0; k < rows.times.size(); ++k) {
      const double z = -sag + (sag - kDepth) * std::cos(w * rows.times[k]);
      error = std::max(error, std::abs(rows.positions[k].front() - kPlace - z));
    }
    EXPECT_NEAR(rows.energies.front().support_springs, 0.5 * mass * std::pow(w * kDepth, 2), 1e-9);
    expect_balance(rows, 1e-12);
    if (before > 0.0) {
      EXPECT_NEAR(std::log2(before / error), 2.0, 0.05);
    }
    before = error;
  }
  EXPECT_LT(before, 1e-6);
}

TEST(PressedStart, MoreauJeanHoldsNothingInSpringsOutOfReach) {
  // Its first row once took the beam for one at y = 0.
  const test::Option end{"-ts_max_time", "0.01"};
  ModelParameters parameters = pressed(6, {table(0.5, 1e4)});
  parameters.initial.height = 1.0;
  test::Fall fall{parameters};
  test::Recorder rows{1e-3};
  fall.dynamics.add_observer(rows);
  fall.dynamics.solve();
  for (const EnergyLedger& energy : rows.energies) {
    EXPECT_EQ(energy.support_springs, 0.0);
  }
  expect_balance(rows, 1e-9);
}

TEST(PressedStart, TheFilteredLineLeavesATableOfSprings) {
  constexpr double kDepth = 0.02;
  constexpr double kFilter = 50.0;
  constexpr double kTable = 2500.0;  // [1/s^2]
  const double square = 1.0 / (1.0 / (kFilter * kFilter) + 1.0 / kTable);
  const double w = std::sqrt(square);
  const double sag = test::kGravity / kTable;  // of the mass below the face, where it would rest
  const test::Option end{"-ts_max_time", "0.03"};
  const test::Option tolerance{"-ts_rtol", "1e-10"};
  std::vector<test::Way> ways{test::kWays.begin(), test::kWays.end()};
  ways.push_back({.integrator = "chebyshev", .dense = 100});
  for (const test::Way& way : ways) {
    const char* const name = way.integrator;
    const test::Option type{"-ts_type", name};
    test::Fall fall{test::steel_beam(6),     kFilter, test::kGravity, {.height = -kDepth}, {table(0.0, kTable)},
                    test::on_line(way.dense)};
    test::Recorder rows{1e-3};
    fall.dynamics.add_observer(rows);
    fall.dynamics.solve();
    for (std::size_t k = 0; k < rows.times.size(); ++k) {
      const double y = -sag + (sag - kDepth) * std::cos(w * rows.times[k]);
      for (const double position : rows.positions[k]) {
        EXPECT_NEAR(position, y, 1e-9) << name << ' ' << rows.times[k];
      }
      const double push = square * (test::kGravity / (kFilter * kFilter) - y);  // over the mass
      ASSERT_GT(push, 0.0);
      EXPECT_NEAR(rows.energies[k].support_springs, 0.5 * fall.beam.total_mass() * push * push / kTable, 1e-5)
          << name << ' ' << rows.times[k] << " [J]";
    }
    expect_balance(rows, 5e-8);
    EXPECT_EQ(fall.dynamics.counts().first_contact_time, 0.0) << name;
  }
}

TEST(PressedStart, NothingPressesThatCannotGiveWay) {
  const auto said = [](const ModelParameters& parameters, const char* name) {
    const test::Option type{"-ts_type", name};
    return test::failure_of<InputError>([&] { const test::Fall fall{parameters}; });
  };
  ModelParameters rigid = pressed(20, {{.position = 5.0, .height = 0.02}});
  for (const char* name : {"modal", "moreau"}) {
    const std::string message = said(rigid, name);
    EXPECT_NE(message.find("support height: 0.02 is not allowed, support 0 overlaps the beam at the start, by 0.02 m"),
              std::string::npos)
        << message;
    EXPECT_NE(message.find("`support stiffness`"), std::string::npos) << message;
  }
  for (const ContactSurface surface : {ContactSurface::line, ContactSurface::mass}) {
    for (const bool elastic : {false, true}) {
      if (surface == ContactSurface::line && elastic) {
        continue;
      }
      ModelParameters parameters = pressed(20, {{.position = 5.0, .width = 1.0, .height = 0.02}});
      parameters.filter = {.filter_frequency = 50.0};
      parameters.contact.surface = surface;
      if (elastic) {
        parameters.supports[0].stiffness = 1e6;
      }
      for (const char* name : {"impact", "rk", "chebyshev"}) {
        EXPECT_NE(said(parameters, name).find("overlaps the beam at the start"), std::string::npos) << name;
      }
    }
  }
}

}  // namespace
}  // namespace udar
