// ranks: 1 2; size: medium
/// @file
/// The motion against closed forms, by every integrator: flight, bounces, rest, exact impacts of few masses, energy,
/// static equilibrium.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "support/dense.hpp"
#include "support/steel_beam.hpp"
#include "support/world.hpp"
#include "udar/numerics/step_polynomial.hpp"

namespace udar {
namespace {

/// Every test runs with `-ts_type` rk, chebyshev and impact.
class Motion : public testing::TestWithParam<const char*> {
 protected:
  /// The impact integrator is of finite order through impacts: it is asked for 1e-9.
  [[nodiscard]] static bool finite_order() { return std::string_view{GetParam()} == "impact"; }
  [[nodiscard]] static const char* rtol(const char* exact) { return finite_order() ? "1e-9" : exact; }
  /// ... of the scale of the motion in every step, which a hundred steps and ten impacts make a hundred times that.
  [[nodiscard]] static double within(double exact) { return finite_order() ? std::max(exact, 1e-7) : exact; }

 private:
  test::Option type_{"-ts_type", GetParam()};
  test::Option tolerance_{"-ts_rtol", std::string_view{GetParam()} == "rk" ? "1e-8" : rtol("1e-14")};
};

INSTANTIATE_TEST_SUITE_P(All, Motion, testing::Values("rk", "chebyshev", "impact"),
                         [](const auto& tested) { return std::string{tested.param}; });

double x_of(const BeamChain& beam, std::size_t local) {
  return beam.position(beam.begin() + static_cast<PetscInt>(local));
}

TEST_P(Motion, FreeFlightFollowsTheParabolaWithRotation) {
  const test::Option end{"-ts_max_time", "0.7"};
  const InitialState initial{.height = 20.0, .slope = 0.02, .velocity = 1.5, .angular_velocity = 0.3};
  test::Fall fall{test::steel_beam(30), 100.0, test::kGravity, initial, {Support::floor(0.0, 1.0)}};
  test::Recorder record{0.07};
  fall.dynamics.add_observer(record);
  fall.dynamics.solve();
  ASSERT_EQ(record.times.size(), 11U);
  for (std::size_t k = 0; k < record.times.size(); ++k) {
    const double t = record.times[k];
    EXPECT_DOUBLE_EQ(t, 0.07 * static_cast<double>(k));
    for (std::size_t i = 0; i < record.positions[k].size(); ++i) {
      const double arm = x_of(fall.beam, i) - 5.0;
      // Small rotations: straight-line motion of every mass. 1e-12: round-off of 20 m over 70 steps.
      EXPECT_NEAR(record.positions[k][i], 20.0 + 0.02 * arm + (1.5 + 0.3 * arm) * t - 0.5 * test::kGravity * t * t,
                  within(1e-12));
      EXPECT_NEAR(record.velocities[k][i], 1.5 + 0.3 * arm - test::kGravity * t, within(1e-11));
      EXPECT_NEAR(record.lines[k][i], record.positions[k][i] - test::kGravity / 1e4, within(1e-12));
    }
  }
  EXPECT_EQ(fall.dynamics.counts().impacts, 0);
}

TEST_P(Motion, FlatFallBouncesAsABallAndRestsAtTheZenoTime) {
  const test::Option end{"-ts_max_time", "2.0"};
  const double e = 0.5;
  const InitialState initial{.height = 1.0};
  test::Fall fall{test::steel_beam(20),    100.0, test::kGravity, initial, {Support::floor(0.0, e)},
                  {.hop_tolerance = 1e-17}};
  test::Recorder record{2.0};
  fall.dynamics.add_observer(record);
  fall.dynamics.solve();
  const auto masses = static_cast<std::size_t>(fall.beam.local_nodes());
  ASSERT_EQ(record.impacts.size() % masses, 0U);
  const double t0 = std::sqrt(2.0 / test::kGravity);
  double expected = t0;
  for (std::size_t bounce = 0; bounce < record.impacts.size() / masses; ++bounce) {
    for (std::size_t i = 0; i < masses; ++i) {
      const ImpactRecord& hit = record.impacts[bounce * masses + i];
      ASSERT_NEAR(hit.time, expected, within(1e-8)) << "bounce " << bounce;
      ASSERT_NEAR(hit.velocity_before, -test::kGravity * t0 * std::pow(e, static_cast<double>(bounce)), within(1e-8));
    }
    expected += 2.0 * t0 * std::pow(e, static_cast<double>(bounce) + 1.0);
  }
  ASSERT_EQ(record.rests.size(), masses);
  for (const RestRecord& rest : record.rests) {
    EXPECT_FALSE(rest.release);
    EXPECT_NEAR(rest.time, t0 * (1.0 + e) / (1.0 - e), within(1e-8));
  }
  for (std::size_t i = 0; i < masses; ++i) {
    EXPECT_EQ(record.positions.back()[i], 0.0);
    EXPECT_EQ(record.velocities.back()[i], 0.0);
    EXPECT_NEAR(record.lines.back()[i], -test::kGravity / 1e4, within(1e-12));
  }
  const EnergyLedger& last = record.energies.back();
  EXPECT_NEAR(last.lost_in_impacts, fall.beam.total_mass() * test::kGravity,
              within(1e-8) * fall.beam.total_mass() * test::kGravity);
  EXPECT_LT(std::abs(last.drift()), within(1e-12));
  // Momentum: the floor took what gravity gave.
  EXPECT_NEAR(fall.dynamics.support_impulses().front(), fall.beam.total_mass() * test::kGravity * 2.0,
              within(1e-9) * fall.beam.total_mass() * test::kGravity * 2.0);
}

TEST_P(Motion, FlatFallWithoutRestitutionRestsAtOnce) {
  const test::Option end{"-ts_max_time", "0.6"};
  const InitialState initial{.height = 1.0};
  test::Fall fall{test::steel_beam(10), 100.0, test::kGravity, initial, {Support::floor(0.0, 0.0)}};
  fall.dynamics.solve();
  EXPECT_EQ(fall.dynamics.counts().impacts, 11);
  EXPECT_EQ(fall.dynamics.counts().rests, 11);
  EXPECT_NEAR(fall.dynamics.counts().first_contact_time, std::sqrt(2.0 / test::kGravity), within(1e-12));
  for (const double position : fall.dynamics.masses().position) {
    EXPECT_EQ(position, 0.0);
  }
}

TEST_P(Motion, FlatFallKeepsItsEnergyWhenElastic) {
  const test::Option end{"-ts_max_time", "9.5"};
  const InitialState initial{.height = 1.0};
  test::Fall fall{test::steel_beam(10), 100.0, test::kGravity, initial, {Support::floor(0.0, 1.0)}};
  test::Recorder record{0.5};
  fall.dynamics.add_observer(record);
  fall.dynamics.solve();
  // Bounces at t0, 3 t0, 5 t0, ... with t0 = 0.4515 s: eleven of eleven masses.
  EXPECT_EQ(fall.dynamics.counts().impacts, 11 * 11);
  EXPECT_LT(std::abs(record.energies.back().drift()), within(1e-12));
}

/// One element without bending: two masses that bounce as balls, each in its own rhythm.
TEST_P(Motion, TwoMassesBounceIndependentlyOnATiltedStart) {
  if (test::world_size() > 1) {
    GTEST_SKIP() << "one element cannot be dealt to several ranks";
  }
  const test::Option end{"-ts_max_time", "1.5"};
  const InitialState initial{.height = 0.8, .slope = 0.05};  // ends at 0.55 m and 1.05 m
  const auto supports = std::vector<Support>{Support::floor(0.1, 0.7)};
  test::Fall fall{test::steel_beam(1), 60.0, test::kGravity, initial, supports};
  test::Recorder record{0.1};
  fall.dynamics.add_observer(record);
  fall.dynamics.solve();
  const std::array<double, 2> drop{0.45, 0.95};
  std::array<std::size_t, 2> bounces{};
  for (const ImpactRecord& hit : record.impacts) {
    const auto end_node = static_cast<std::size_t>(hit.node);
    const double t0 = std::sqrt(2.0 * drop[end_node] / test::kGravity);
    const auto k = static_cast<double>(bounces[end_node]++);
    const double expected = t0 + 2.0 * t0 * 0.7 * (1.0 - std::pow(0.7, k)) / (1.0 - 0.7);
    EXPECT_NEAR(hit.time, expected, within(1e-12) * (k + 1.0)) << "node " << hit.node << " bounce " << k;
    EXPECT_NEAR(hit.impulse, fall.beam.mass(hit.node) * 1.7 * test::kGravity * t0 * std::pow(0.7, k),
                1e3 * within(1e-11));
  }
}

/// The tip mass of a one-element cantilever is an oscillator with lambda = wf w / sqrt(wf^2 + w^2); between two stops
/// its impacts have closed-form times.
TEST_P(Motion, OneMassVibratesBetweenStopsInClosedForm) {
  if (test::world_size() > 1) {
    GTEST_SKIP() << "one element cannot be dealt to several ranks";
  }
  const test::Option end{"-ts_max_time", "2.0"};
  const test::Option tolerance{"-ts_rtol", rtol("1e-12")};
  const test::TipMass tip{.filter_frequency = 9.0};
  const double lambda = tip.lambda();
  InitialState initial{.height = 0.0};
  initial.shape = {.x = {0.0, 10.0}, .offset = {0.0, 0.2}, .velocity = {}};
  const std::vector<Support> stops{{.position = 10.0, .height = -0.1, .restitution = 1.0, .side = SupportSide::below},
                                   {.position = 10.0, .height = 0.25, .restitution = 1.0, .side = SupportSide::above}};
  test::Fall fall{tip.beam, tip.filter_frequency, 0.0, initial, stops};
  test::Recorder record{0.1};
  fall.dynamics.add_observer(record);
  fall.dynamics.solve();
  // From 0.2 at rest down to -0.1, mirrored there, back to 0.2 at rest, and so on; the upper stop is never reached.
  const double first = std::acos(-0.5) / lambda;
  std::array<double, 2> local{static_cast<double>(record.impacts.size()), 0.0};
  for (std::size_t k = 0; k < record.impacts.size(); ++k) {
    local[1] = std::max(local[1], std::abs(record.impacts[k].time - first * static_cast<double>(2 * k + 1)));
    EXPECT_EQ(record.impacts[k].support, 0);
  }
  MPI_Allreduce(MPI_IN_PLACE, local.data(), 2, MPI_DOUBLE, MPI_MAX, PETSC_COMM_WORLD);
  EXPECT_EQ(local[0], std::floor((2.0 / first + 1.0) / 2.0));
  EXPECT_GE(local[0], 2.0);
  EXPECT_LT(local[1], within(1e-9));
}

TEST_P(Motion, OneMassHitsBothStops) {
  if (test::world_size() > 1) {
    GTEST_SKIP() << "one element cannot be dealt to several ranks";
  }
  const test::Option end{"-ts_max_time", "1.0"};
  const test::Option tolerance{"-ts_rtol", rtol("1e-12")};
  BeamParameters parameters = test::steel_beam(1);
  parameters.left = test::kClamped;
  parameters.segments[0].bending_stiffness = 1e-3;  // a free mass on a line without strength
  InitialState initial{.height = 0.0};
  initial.shape = {.x = {0.0, 10.0}, .offset = {0.0, 0.0}, .velocity = {0.0, 3.0}};
  const std::vector<Support> stops{{.position = 10.0, .height = -0.1, .restitution = 0.8, .side = SupportSide::below},
                                   {.position = 10.0, .height = 0.2, .restitution = 0.8, .side = SupportSide::above}};
  test::Fall fall{parameters, 9.0, 0.0, initial, stops};
  test::Recorder record;
  fall.dynamics.add_observer(record);
  fall.dynamics.solve();
  double time = 0.2 / 3.0;
  double speed = 3.0;
  for (std::size_t k = 0; k < record.impacts.size(); ++k) {
    EXPECT_NEAR(record.impacts[k].time, time,
                within(1e-8));  // the line keeps a stiffness of within(1e-9) of the filter spring
    EXPECT_EQ(record.impacts[k].support, k % 2 == 0 ? 1 : 0);
    speed *= 0.8;
    time += 0.3 / speed;
  }
  auto hits = static_cast<int>(record.impacts.size());
  MPI_Allreduce(MPI_IN_PLACE, &hits, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
  EXPECT_GE(hits, 4);
}

TEST_P(Motion, ElasticImpactKeepsTheEnergyOverTwentyImpacts) {
  const test::Option end{"-ts_max_time", "3.0"};
  const test::Option tolerance{"-ts_rtol", rtol("1e-10")};
  for (const double wf : {50.0, 100.0, 400.0}) {
    const InitialState initial{.height = 1.0};
    test::Fall fall{test::steel_beam(20), wf, test::kGravity, initial, {{.position = 2.0}, {.position = 8.0}}};
    test::Recorder record{0.05};
    fall.dynamics.add_observer(record);
    fall.dynamics.set_stop_request([&fall] { return fall.dynamics.counts().impacts >= 20; });
    fall.dynamics.solve();
    EXPECT_GE(fall.dynamics.counts().impacts, 20) << "wf = " << wf;
    EXPECT_FALSE(fall.dynamics.completed());
    for (const EnergyLedger& energy : record.energies) {
      EXPECT_LT(std::abs(energy.drift()), within(1e-9)) << "wf = " << wf;
      EXPECT_EQ(energy.lost_in_impacts, 0.0);
    }
  }
}

/// Two equal beams in a row; only the first meets supports, and the second must not know.
TEST_P(Motion, TwoBeamsFallEachOnTheirOwn) {
  const test::Option end{"-ts_max_time", "0.8"};
  const test::Option tolerance{"-ts_rtol", rtol("1e-11")};
  BeamParameters parameters = test::steel_beam(20);
  parameters.segments.push_back({.length = 0.5, .elements = 1});
  parameters.segments.push_back(parameters.segments[0]);
  const double wf = 100.0;
  const InitialState initial{.height = 1.0};
  const std::vector<Support> supports{{.position = 2.0}, {.position = 8.0}};
  test::Fall fall{parameters, wf, test::kGravity, initial, supports};
  test::Recorder record{0.05};
  fall.dynamics.add_observer(record);
  fall.dynamics.solve();
  EXPECT_GE(fall.dynamics.counts().impacts, 10);
  for (const ImpactRecord& hit : record.impacts) {
    EXPECT_TRUE(hit.node == 4 || hit.node == 16) << "node " << hit.node;
  }
  for (std::size_t k = 0; k < record.times.size(); ++k) {
    const double t = record.times[k];
    for (std::size_t i = 0; i < record.positions[k].size(); ++i) {
      if (fall.beam.begin() + static_cast<PetscInt>(i) >= 21) {
        EXPECT_NEAR(record.positions[k][i], 1.0 - 0.5 * test::kGravity * t * t, within(1e-10)) << "t = " << t;
        EXPECT_NEAR(record.velocities[k][i], -test::kGravity * t, within(4e-10)) << "t = " << t;  // rtol of 4 m/s
        EXPECT_NEAR(record.lines[k][i], record.positions[k][i] - test::kGravity / (wf * wf), within(1e-10))
            << "t = " << t;
      }
    }
    EXPECT_LT(std::abs(record.energies[k].drift()), within(1e-9));
    EXPECT_EQ(record.energies[k].lost_in_impacts, 0.0);
  }
}

TEST_P(Motion, InelasticImpactBalancesItsEnergy) {
  const test::Option end{"-ts_max_time", "1.5"};
  const test::Option tolerance{"-ts_rtol", rtol("1e-10")};
  for (const double e : {0.0, 0.5}) {
    const InitialState initial{.height = 1.0};
    test::Fall fall{test::steel_beam(20),
                    100.0,
                    test::kGravity,
                    initial,
                    {{.position = 2.0, .width = 1.0, .restitution = e}, {.position = 8.0, .restitution = e}}};
    test::Recorder record{0.05};
    fall.dynamics.add_observer(record);
    fall.dynamics.solve();
    EXPECT_GT(fall.dynamics.counts().rests, 0);
    EXPECT_GT(fall.dynamics.counts().releases, 0);
    EXPECT_GT(record.energies.back().lost_in_impacts, 1000.0);
    EXPECT_LT(std::abs(record.energies.back().drift()), within(1e-9)) << "e = " << e;
  }
}

TEST_P(Motion, SymmetricFallStaysSymmetricToRoundOff) {
  const test::Option end{"-ts_max_time", "0.6"};
  const InitialState initial{.height = 1.0};
  test::Fall fall{test::steel_beam(20), 100.0, test::kGravity, initial, {{.position = 2.0}, {.position = 8.0}}};
  fall.dynamics.solve();
  const MassState masses = fall.dynamics.masses();
  std::vector<double> all(21, 0.0);
  std::ranges::copy(masses.position, all.begin() + fall.beam.begin());
  MPI_Allreduce(MPI_IN_PLACE, all.data(), 21, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
  EXPECT_GE(fall.dynamics.counts().impacts, 10);
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_NEAR(all[i], all[20 - i], within(1e-12));  // round-off of within(1e-16) grown over seven elastic impacts
  }
}

/// Masses on wide supports rest, the others hang on the line: starting there nothing may move.
TEST_P(Motion, StaticSagOfABeamOnWideSupportsStays) {
  const test::Option end{"-ts_max_time", "0.5"};
  const double wf = 100.0;
  const BeamChain beam{PETSC_COMM_WORLD, test::steel_beam(40)};
  const std::vector<Support> supports{{.position = 1.0, .width = 1.0, .restitution = 0.5},
                                      {.position = 9.0, .width = 1.0, .restitution = 0.5}};
  const auto n = static_cast<std::size_t>(beam.nodes());
  // Which masses press on their support in equilibrium follows by dropping those that pull, until none does.
  std::vector<bool> resting(n, false);
  for (const Support& support : supports) {
    const auto [first, last] = beam.nodes_within(support.from(), support.to());
    std::fill(resting.begin() + first, resting.begin() + last + 1, true);
  }
  const test::Dense stiffness = test::line_stiffness(beam);
  std::vector<double> line;
  for (bool settled = false; !settled;) {
    settled = true;
    test::Dense matrix = stiffness;
    std::vector<double> weight(n);
    for (std::size_t i = 0; i < n; ++i) {
      const double mass = beam.mass(static_cast<PetscInt>(i));
      weight[i] = -test::kGravity * mass;
      matrix(i, i) += resting[i] ? wf * wf * mass : 0.0;
    }
    line = test::solve(matrix, weight);
    for (std::size_t i = 0; i < n; ++i) {
      if (resting[i] && line[i] > 0.0) {
        resting[i] = false;
        settled = false;
      }
    }
  }
  InitialState initial{.height = 0.0};
  for (std::size_t i = 0; i < n; ++i) {
    initial.shape.x.push_back(beam.position(static_cast<PetscInt>(i)));
    // A mass that does not press stands where the line is, above the support or free between them.
    initial.shape.offset.push_back(resting[i] ? 0.0 : line[i]);
  }
  test::Fall fall{test::steel_beam(40), wf, test::kGravity, initial, supports};
  test::Recorder record{0.05};
  fall.dynamics.add_observer(record);
  fall.dynamics.solve();
  EXPECT_EQ(fall.dynamics.counts().resting, std::ranges::count(resting, true));
  EXPECT_EQ(fall.dynamics.counts().releases, 0);
  const auto first = static_cast<std::size_t>(beam.begin());
  const double sag = -*std::ranges::min_element(line);
  EXPECT_GT(sag, 0.01);  // 4 m of overhang and 8 m of span do bend
  for (std::size_t k = 0; k < record.times.size(); ++k) {
    for (std::size_t i = 0; i < record.positions[k].size(); ++i) {
      EXPECT_NEAR(record.positions[k][i], resting[first + i] ? 0.0 : line[first + i], within(1e-9));
      EXPECT_NEAR(record.lines[k][i], line[first + i], within(1e-9));
    }
  }
}

/// A beam that flies flat against two points without gravity: at the impact nothing pulls or presses their masses,
/// which rest all the same until the beam swings back. The way there only takes time.
TEST_P(Motion, PlasticFlightWithoutGravityRestsAndLeaves) {
  const test::Option end{"-ts_max_time", "0.5"};
  double held = 0.0;
  for (const double height : {0.05, 0.15, 0.2, 0.3, 0.33}) {
    test::Fall fall{test::steel_beam(20),
                    100.0,
                    0.0,
                    {.height = height, .velocity = -1.0},
                    {{.position = 2.0, .restitution = 0.0}, {.position = 8.0, .restitution = 0.0}}};
    test::Recorder record;
    fall.dynamics.add_observer(record);
    fall.dynamics.solve();
    EXPECT_EQ(fall.dynamics.counts().impacts, 2) << height;
    EXPECT_EQ(fall.dynamics.counts().rests, 2) << height;
    EXPECT_EQ(fall.dynamics.counts().releases, 2) << height;
    for (const RestRecord& rest : record.rests) {
      EXPECT_NEAR(rest.time, height + (rest.release ? 0.1008174807 : 0.0), within(1e-9)) << height;
      held = rest.release ? rest.time - height : held;
    }
  }
  EXPECT_GT(held, test::world_size() > 1 ? -1.0 : 0.1);
}

/// A load that grows and stays on a free beam: momentum and work follow from the table.
TEST_P(Motion, TimeTableGivesItsImpulseAndItsWork) {
  const test::Option end{"-ts_max_time", "0.5"};
  const test::Option tolerance{"-ts_rtol", rtol("1e-11")};
  const NodalLoad load{.position = 3.0, .table = time_table({0.05, 0.123, 0.3}, {0.0, 4000.0, -1000.0})};
  test::Fall fall{test::steel_beam(20), 100.0, 0.0, {.height = 0.0}, {}, {}, {load}};
  test::Recorder record{0.1};
  fall.dynamics.add_observer(record);
  fall.dynamics.solve();
  const double momentum = test::momentum_of(fall.line, fall.dynamics);
  const double impulse = 0.5 * 4000.0 * 0.073 + 0.5 * 3000.0 * 0.177 - 1000.0 * 0.2;
  EXPECT_NEAR(momentum, impulse, within(1e-8) * impulse);
  EXPECT_GT(std::abs(record.energies.back().total()), 1.0);
  EXPECT_LT(std::abs(record.energies.back().drift()), within(1e-8));
}

/// A cantilever that a blow sets going from rest, without gravity: nothing but the load says how large the motion is.
TEST_P(Motion, AnswersAreInProportionToTheLoadOverTwelveDecades) {
  const test::Option end{"-ts_max_time", "0.2"};
  BeamParameters beam = test::steel_beam(10);
  beam.left = test::kClamped;
  const auto positions = [&](double force) {
    const NodalLoad load{.position = 10.0, .table = time_table({0.0, 0.01, 0.02}, {0.0, force, 0.0})};
    test::Fall fall{beam, 100.0, 0.0, {.height = 0.0}, {}, {}, {load}};
    test::Recorder record{0.02};
    fall.dynamics.add_observer(record);
    fall.dynamics.solve();
    EXPECT_LT(record.largest_drift(), 1e-5) << force << " N";
    return record.positions;
  };
  constexpr double kRatio = 1e-12;
  const auto large = positions(1e4);
  const auto small = positions(kRatio * 1e4);
  for (std::size_t k = 1; k < large.size(); ++k) {
    for (std::size_t i = 0; i < large[k].size(); ++i) {
      // Rounding may decide otherwise about a step: as far apart as two runs of the tolerance are, 1e-8 of the motion.
      EXPECT_NEAR(small[k][i] / kRatio, large[k][i], 1e-8 * 1e-2) << "the tip moves by some centimetres";
    }
  }
}

/// Nothing moves for a while: the balance of the little that moves first is judged by what it is to become.
TEST_P(Motion, ALoadThatBeginsLateKeepsTheBalance) {
  const test::Option end{"-ts_max_time", "0.6"};
  const test::Option tolerance{"-ts_rtol", "1e-8"};
  BeamParameters beam = test::steel_beam(10);
  beam.left = test::kClamped;
  const NodalLoad load{.position = 5.0, .table = time_table({0.0, 0.3, 0.6}, {0.0, 0.0, 0.1})};
  test::Fall fall{beam, 100.0, 0.0, {.height = 0.0}, {}, {}, {load}};
  test::Recorder record{0.005};
  fall.dynamics.add_observer(record);
  fall.dynamics.solve();
  EXPECT_LT(std::abs(record.energies.back().drift()), 1e-6);
}

/// Steps end at the many kinks of a table but for the last bits of their times, and none takes the slope before it.
TEST_P(Motion, ManyKinksOfATableGiveTheirImpulseAndTheirWork) {
  const test::Option end{"-ts_max_time", "0.3"};
  const test::Option tolerance{"-ts_rtol", rtol("1e-11")};
  const test::Option steps{"-ts_adapt_dt_max", "2.5e-4"};  // eight of them are two milliseconds, but for rounding
  std::vector<double> time;
  std::vector<double> force;
  double impulse = 0.0;
  for (int k = 0; k <= 150; ++k) {
    time.push_back(0.002 * k);
    force.push_back(4000.0 * std::sin(2.0 * M_PI * 8.0 * time.back()) + (k % 2 == 0 ? 500.0 : -500.0));
    const auto last = static_cast<std::size_t>(k);
    impulse += k > 0 ? 0.5 * (time[last] - time[last - 1]) * (force[last - 1] + force[last]) : 0.0;
  }
  const NodalLoad load{.position = 3.0, .table = time_table(time, force)};
  test::Fall fall{test::steel_beam(20), 1000.0, 0.0, {.height = 0.0}, {}, {}, {load}};
  test::Recorder record{0.1};
  fall.dynamics.add_observer(record);
  fall.dynamics.solve();
  const double momentum = test::momentum_of(fall.line, fall.dynamics);
  // 4000 N are the scale of the sums; one step with the wrong slope is off by 1e-4 of it.
  EXPECT_NEAR(momentum, impulse, within(1e-8) * 4000.0 * 0.3);
  EXPECT_LT(std::abs(record.energies.back().drift()), within(1e-8));
}

/// A load that jumps up and down, on a beam that flies or that it tears off its supports, against steep ramps about the
/// same times: places and work agree as the ramps get short.
TEST_P(Motion, AJumpOfALoadIsWhatSteepRampsTendTo) {
  const test::Option end{"-ts_max_time", "0.25"};
  const test::Option tolerance{"-ts_rtol", rtol("1e-11")};
  constexpr double kRamp = 1e-6;  // [s]; what it changes is of its square, but for masses that it lets go
  for (const bool rests : {false, true}) {
    std::vector<double> jump_time;
    std::vector<double> ramp_time;
    std::vector<double> forces;
    double before = 0.0;
    double impulse = 0.0;
    for (const auto& [time, force] : {std::pair{0.05, 60000.0}, {0.12, -20000.0}, {0.2, 0.0}}) {
      jump_time.insert(jump_time.end(), {time, time});
      ramp_time.insert(ramp_time.end(), {time - 0.5 * kRamp, time + 0.5 * kRamp});
      forces.insert(forces.end(), {before, force});
      impulse += force * (time == 0.05 ? 0.07 : 0.08);
      before = force;
    }
    const std::vector<Support> supports(rests ? 1 : 0, Support::floor(0.0, 0.0));
    std::array<test::Recorder, 2> record{test::Recorder{0.05}, test::Recorder{0.05}};
    std::array<double, 2> momentum{};
    for (std::size_t k = 0; k < 2; ++k) {
      test::Fall fall{test::steel_beam(20),
                      100.0,
                      rests ? test::kGravity : 0.0,
                      {.height = 0.0},
                      supports,
                      {},
                      {{.position = 3.2, .table = time_table(k == 0 ? jump_time : ramp_time, forces)}}};
      fall.dynamics.add_observer(record[k]);
      fall.dynamics.solve();
      momentum[k] = test::momentum_of(fall.line, fall.dynamics);
    }
    EXPECT_LT(std::abs(record[0].energies.back().drift()), within(1e-8)) << rests;
    if (!rests) {
      EXPECT_NEAR(momentum[0], impulse, within(1e-8) * impulse);
    }
    const double apart = rests ? 1e-5 : within(1e-9);  // [m]
    for (std::size_t i = 0; i < record[0].positions.back().size(); ++i) {
      EXPECT_NEAR(record[0].positions.back()[i], record[1].positions.back()[i], apart) << rests;
    }
    EXPECT_NEAR(record[0].energies.back().load_work, record[1].energies.back().load_work,
                1e-5 * std::abs(record[1].energies.back().load_work))
        << rests;
    EXPECT_GT(std::abs(record[1].energies.back().load_work), 100.0);
    ASSERT_EQ(record[0].rests.size(), record[1].rests.size());
    for (std::size_t i = 0; i < record[0].rests.size(); ++i) {
      EXPECT_NEAR(record[0].rests[i].time, record[1].rests[i].time, 1e-5);
    }
  }
}

/// A run ends with a row of each listener, whether its interval divides the end or not.
TEST_P(Motion, TheEndIsARow) {
  const test::Option end{"-ts_max_time", "0.5"};
  test::Fall fall{test::steel_beam(10), 100.0, test::kGravity, {.height = 1.0}, {Support::floor(0.0, 1.0)}};
  std::array<test::Recorder, 3> record{test::Recorder{0.03}, test::Recorder{0.1}, test::Recorder{2.0}};
  for (test::Recorder& one : record) {
    fall.dynamics.add_observer(one);
  }
  fall.dynamics.solve();
  EXPECT_EQ(record[0].times.size(), 18U);
  EXPECT_EQ(record[1].times.size(), 6U);
  EXPECT_EQ(record[2].times, (std::vector<double>{0.0, 0.5}));
  const MassState masses = fall.dynamics.masses();
  for (const test::Recorder& one : record) {
    EXPECT_EQ(one.times.back(), 0.5);
    EXPECT_EQ(one.positions.back(), masses.position);
  }
}

TEST(DenseOutput, IsNoWorseThanTheOneOfTheIntegrator) {
  // PETSc's interpolant of 5dp is of order 4, the quintic through both ends of order 5: halfway through one step of a
  // vibrating beam the latter must be at least as close to the exact motion.
  BeamParameters parameters = test::steel_beam(1);
  parameters.left = test::kClamped;
  const double wf = 9.0;
  const double w = std::sqrt(3.0 * parameters.segments[0].bending_stiffness / 1000.0 /
                             (0.5 * parameters.segments[0].mass_per_length * 10.0));
  const double lambda = wf * w / std::hypot(wf, w);
  for (const double h : {0.05, 0.1}) {
    const auto exact = [&](double t) {
      return Kinematics{.position = std::cos(lambda * t),
                        .velocity = -lambda * std::sin(lambda * t),
                        .acceleration = -lambda * lambda * std::cos(lambda * t)};
    };
    const StepPolynomial quintic{exact(0.0), exact(h), h};
    petsc::TimeStepper stepper;
    petsc::Vector state;
    petsc::Vector middle;
    UDAR_CALL(TSCreate(PETSC_COMM_SELF, stepper.put()));
    UDAR_CALL(VecCreateSeq(PETSC_COMM_SELF, 2, state.put()));
    UDAR_CALL(VecDuplicate(state, middle.put()));
    UDAR_CALL(VecSetValue(state, 0, 1.0, INSERT_VALUES));
    UDAR_CALL(TSSetType(stepper, TSRK));
    UDAR_CALL(TSRKSetType(stepper, TSRK5DP));
    double square = lambda * lambda;
    UDAR_CALL(TSSetRHSFunction(
        stepper, nullptr,
        [](TS, PetscReal, Vec u, Vec f, void* context) -> PetscErrorCode {
          const double* from = nullptr;
          double* to = nullptr;
          VecGetArrayRead(u, &from);
          VecGetArray(f, &to);
          to[0] = from[1];
          to[1] = -*static_cast<double*>(context) * from[0];
          VecRestoreArray(f, &to);
          VecRestoreArrayRead(u, &from);
          return 0;
        },
        &square));
    TSAdapt adapt = nullptr;
    UDAR_CALL(TSGetAdapt(stepper, &adapt));
    UDAR_CALL(TSAdaptSetType(adapt, TSADAPTNONE));
    UDAR_CALL(TSSetTimeStep(stepper, h));
    UDAR_CALL(TSSetMaxSteps(stepper, 1));
    UDAR_CALL(TSSetExactFinalTime(stepper, TS_EXACTFINALTIME_STEPOVER));
    UDAR_CALL(TSSolve(stepper, state));
    UDAR_CALL(TSInterpolate(stepper, 0.5 * h, middle));
    double theirs = 0.0;
    const PetscInt zero = 0;
    UDAR_CALL(VecGetValues(middle, 1, &zero, &theirs));
    const double truth = exact(0.5 * h).position;
    EXPECT_LE(std::abs(quintic.position(0.5) - truth), std::abs(theirs - truth)) << "lambda h = " << lambda * h;
  }
}

}  // namespace
}  // namespace udar
