// ranks: 1 2 3; size: medium
/// @file
/// A structure on a base that moves: against inertia forces on every node, an oscillator in closed form, supports that
/// move as the base does; its frame, its work and its tables.

#include "udar/structure/base_motion.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "support/steel_beam.hpp"
#include "support/world.hpp"

namespace udar {
namespace {

/// A shock that jumps, a pause, and another one back.
BaseMotion shock() {
  return {BaseQuantity::acceleration, {0.02, 0.05, 0.05, 0.11, 0.2}, {0.0, 60.0, -25.0, -25.0, 0.0}};
}

/// @name Beams, and the supports of what is to touch some.
/// @{
BeamParameters on_line_supports() {
  BeamParameters beam = test::steel_beam(16);
  beam.left = test::kPinned;
  beam.point_masses = {{.position = 3.125, .mass = 80.0}};
  beam.line_supports = {{.position = 7.5}};
  return beam;
}
/// @}

/// By an integrator, to a tolerance that leaves nothing but rounding, or its own.
struct Case {
  const char* type;
  const char* tolerance;
};

class BaseMotionBy : public testing::TestWithParam<Case> {
 protected:
  [[nodiscard]] static bool is(std::string_view type) { return type == GetParam().type; }
  /// The filter that goes with the integrator.
  [[nodiscard]] static FilterParameters filter() {
    return is("moreau") || is("modal") ? test::unfiltered(is("modal") ? 1e-4 : 1e-3)
                                       : FilterParameters{.filter_frequency = 200.0};
  }

 private:
  test::Option type_{"-ts_type", GetParam().type};
  test::Option tolerance_{"-ts_rtol", GetParam().tolerance};
  test::Option end_{"-ts_max_time", "0.3"};
  test::Option modes_{"-modal_modes", "10"};
};

INSTANTIATE_TEST_SUITE_P(All, BaseMotionBy,
                         testing::Values(Case{"chebyshev", "1e-14"}, Case{"impact", "1e-10"}, Case{"rk", "1e-10"},
                                         Case{"modal", "1e-6"}, Case{"moreau", "1e-6"}),
                         [](const auto& tested) { return std::string{tested.param.type}; });

/// A run with a row every hundredth of a second.
struct Recorded {
  explicit Recorded(const ModelParameters& parameters) : fall{parameters} {
    fall.dynamics.add_observer(record);
    fall.dynamics.solve();
  }

  test::Recorder record{0.01};
  test::Fall fall;
};

double largest(const std::vector<std::vector<double>>& rows) {
  double most = 0.0;
  for (const auto& row : rows) {
    for (const double value : row) {
      most = std::max(most, std::abs(value));
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_DOUBLE, MPI_MAX, PETSC_COMM_WORLD);
  return most;
}

/// The same forces by hand, one table for each node; what is held does not feel them.
TEST_P(BaseMotionBy, IsAnInertiaForceOnEveryNode) {
  ModelParameters parameters{.beam = on_line_supports(), .filter = filter()};
  ModelParameters by_hand = parameters;
  parameters.base_motion = {shock()};
  {
    const BeamChain beam{PETSC_COMM_WORLD, parameters.beam};
    std::vector<double> mass(static_cast<std::size_t>(beam.points().total()), 0.0);
    for (std::size_t i = 0; i < beam.points().points(); ++i) {
      mass[static_cast<std::size_t>(beam.points().global(i))] = beam.points().mass()[i];
    }
    MPI_Allreduce(MPI_IN_PLACE, mass.data(), static_cast<int>(mass.size()), MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
    const BaseMotion motion = shock();
    const auto& acceleration = motion.acceleration();
    for (std::size_t node = 0; node < mass.size(); ++node) {
      std::vector<double> force;
      for (const double value : acceleration->value()) {
        force.push_back(-mass[node] * value);
      }
      by_hand.loads.push_back(
          {.position = 0.625 * static_cast<double>(node),
           .table = time_table({acceleration->time().begin(), acceleration->time().end()}, std::move(force))});
    }
  }
  const Recorded on_base{parameters};
  const Recorded under_forces{by_hand};
  const test::Recorder& base = on_base.record;
  const test::Recorder& forces = under_forces.record;
  ASSERT_EQ(base.times.size(), forces.times.size());
  const double moved = largest(base.positions);
  const double speed = largest(base.velocities);
  EXPECT_GT(moved, 0.02);
  for (std::size_t k = 0; k < base.times.size(); ++k) {
    for (std::size_t i = 0; i < base.positions[k].size(); ++i) {
      EXPECT_NEAR(base.positions[k][i], forces.positions[k][i], 1e-9 * moved) << base.times[k];
      EXPECT_NEAR(base.velocities[k][i], forces.velocities[k][i], 1e-9 * speed) << base.times[k];
    }
    // What is work of the base here is work of loads there, and in their potential.
    const EnergyLedger& there = forces.energies[k];
    const double work = base.energies[k].base_work;
    const double of_loads = there.load_work - (there.load_potential - there.initial_potential);
    const double of_weight =
        base.energies[k].load_work - (base.energies[k].load_potential - base.energies[k].initial_potential);
    EXPECT_NEAR(work + of_weight, of_loads, 1e-9 * std::max(base.energies[k].scale, 1.0)) << base.times[k];
  }
  EXPECT_GT(base.energies.back().base_work, 10.0) << "[J]";
  EXPECT_LT(base.largest_drift(), is("moreau") ? 1e-9 : 1e-6);
}

/// On a foundation in proportion to its masses a free beam moves as one: an oscillator, which the filter slows down.
TEST_P(BaseMotionBy, MovesAnOscillatorAsInClosedForm) {
  if (is("moreau")) {
    GTEST_SKIP() << "of second order in its step";
  }
  constexpr double kW = 30.0;  // [rad/s]
  BeamParameters beam = test::steel_beam(10);
  beam.segments[0].foundation_stiffness = kW * kW * beam.segments[0].mass_per_length;
  const bool filtered = !is("modal");
  const double share = filtered ? 200.0 * 200.0 / (200.0 * 200.0 + kW * kW) : 1.0;
  const double lambda = kW * std::sqrt(share);
  constexpr double kTime = 0.1;
  constexpr double kWay = 0.04;
  // The clamped cubic between two rows, its velocity a parabola; a = a0 + j t, then none.
  const double a0 = 6.0 * kWay / (kTime * kTime);
  const double jerk = -12.0 * kWay / (kTime * kTime * kTime);
  const auto swings = [&](double t) {  // x'' + lambda^2 x = -share (a0 + jerk t), from rest
    const double c = share / (lambda * lambda);
    return std::array{-c * (a0 * (1.0 - std::cos(lambda * t)) + jerk * (t - std::sin(lambda * t) / lambda)),
                      -c * (a0 * lambda * std::sin(lambda * t) + jerk * (1.0 - std::cos(lambda * t)))};
  };
  test::Fall fall{{.beam = beam,
                   .filter = filter(),
                   .gravity = 0.0,
                   .base_motion = {{BaseQuantity::displacement, {0.0, kTime}, {0.0, kWay}}},
                   .initial = {.height = 0.0}}};
  test::Recorder record{0.01};
  fall.dynamics.add_observer(record);
  fall.dynamics.solve();
  ASSERT_EQ(record.times.size(), 31U);
  const auto [left, fast] = swings(kTime);
  // The tolerance that was asked for, in each of some hundred steps, but where nothing is left but rounding.
  const double error = is("chebyshev") || is("modal") ? 1e-9 : 1e-7;
  for (std::size_t k = 0; k < record.times.size(); ++k) {
    const double t = record.times[k];
    const double after = t - kTime;
    const double place =
        after < 0.0 ? swings(t)[0] : left * std::cos(lambda * after) + fast / lambda * std::sin(lambda * after);
    const double velocity =
        after < 0.0 ? swings(t)[1] : fast * std::cos(lambda * after) - lambda * left * std::sin(lambda * after);
    for (std::size_t i = 0; i < record.positions[k].size(); ++i) {
      EXPECT_NEAR(record.positions[k][i], place, error * kWay) << t;
      EXPECT_NEAR(record.velocities[k][i], velocity, error * kWay * kW) << t;
    }
  }
  // What the base gave is what swings in the end, less what the line had at the start: it stands under the first force.
  const double mass = fall.beam.total_mass();
  const double energy = 0.5 * mass * (fast * fast + lambda * lambda * left * left);
  const double before = filtered ? 0.5 * mass * a0 * a0 / (200.0 * 200.0 + kW * kW) : 0.0;
  EXPECT_NEAR(record.energies.back().base_work, energy - before, 10.0 * error * energy);
  EXPECT_LT(record.largest_drift(), 1e-8);
}

/// What nothing holds stays where it is, whatever the base does: its frame leaves.
TEST_P(BaseMotionBy, LeavesAFreeBeamBehind) {
  const std::vector<BaseMotion> motions{shock(),
                                        {BaseQuantity::velocity, {0.0, 0.1, 0.25}, {0.0, 0.4, -0.1}},
                                        {BaseQuantity::displacement, {0.0, 0.05, 0.12, 0.3}, {0.0, 0.01, -0.03, 0.02}}};
  test::Fall fall{{.beam = test::steel_beam(10),
                   .filter = filter(),
                   .gravity = 0.0,
                   .base_motion = motions,
                   .initial = {.height = 0.5}}};
  test::Recorder record{0.01};
  fall.dynamics.add_observer(record);
  fall.dynamics.solve();
  const double mass = fall.beam.total_mass();
  for (std::size_t k = 0; k < record.times.size(); ++k) {
    const double way = base_displacement(motions, record.times[k]).y;
    const double speed = base_velocity(motions, record.times[k]).y;
    for (std::size_t i = 0; i < record.positions[k].size(); ++i) {
      // A step without filter takes the mean of the force and is off by its square within.
      EXPECT_NEAR(record.positions[k][i] + way, 0.5, is("moreau") ? 1e-4 : 1e-9) << record.times[k];
      EXPECT_NEAR(record.velocities[k][i] + speed, 0.0, is("moreau") ? 1e-9 : 1e-8) << record.times[k];
    }
    // Besides the speed it gives what the line hangs by, which is none before the first step.
    const double hangs = record.energies[k].fictitious_springs - record.energies[0].fictitious_springs;
    EXPECT_NEAR(record.energies[k].base_work, 0.5 * mass * speed * speed + hangs, 1e-6) << "[J]";
  }
}

/// Between stops that move with the base, and in the frame of the ground between stops that move by themselves.
TEST(BaseMotionOfStops, IsThatOfSupportsThatMove) {
  const test::Option type{"-ts_type", "impact"};
  const test::Option tolerance{"-ts_rtol", "1e-11"};
  const test::Option end{"-ts_max_time", "0.25"};
  const BaseMotion motion{BaseQuantity::acceleration, {0.0, 0.03, 0.09, 0.16, 0.25}, {0.0, 50.0, -70.0, 40.0, 0.0}};
  std::vector<Support> stops{{.position = 2.0, .height = -0.01, .restitution = 0.6},
                             {.position = 8.0, .height = -0.01, .restitution = 0.6},
                             {.position = 5.0, .height = 0.02, .restitution = 0.6, .side = SupportSide::above}};
  const ModelParameters on_base{.beam = test::steel_beam(16),
                                .filter = {.filter_frequency = 100.0},
                                .base_motion = {motion},
                                .initial = {.height = 0.0},
                                .supports = stops};
  std::vector<double> height;
  std::vector<double> velocity;
  const auto times = motion.acceleration()->time();
  for (const double time : times) {
    height.push_back(motion.at(time).displacement);
    velocity.push_back(motion.at(time).velocity);
  }
  for (Support& stop : stops) {
    stop.motion =
        std::make_shared<const SupportMotion>(std::vector<double>{times.begin(), times.end()}, height, velocity);
  }
  ModelParameters on_ground = on_base;
  on_ground.base_motion = {};
  on_ground.supports = stops;
  const Recorded moves{on_base};
  const Recorded stays{on_ground};
  const test::Recorder& relative = moves.record;
  const test::Recorder& absolute = stays.record;
  EXPECT_GT(moves.fall.dynamics.counts().impacts, 4);
  ASSERT_EQ(relative.times.size(), absolute.times.size());
  for (std::size_t k = 0; k < relative.times.size(); ++k) {
    const double way = motion.at(relative.times[k]).displacement;
    for (std::size_t i = 0; i < relative.positions[k].size(); ++i) {
      // Both runs are right to -ts_rtol of the motion in a step; hundreds of steps and some impacts add up.
      EXPECT_NEAR(relative.positions[k][i] + way, absolute.positions[k][i], 1e-7) << relative.times[k];
    }
  }
  EXPECT_LT(relative.largest_drift(), 1e-6);
  for (std::size_t k = 0; k < moves.fall.dynamics.contact().support_impulses().size(); ++k) {
    EXPECT_NEAR(moves.fall.dynamics.contact().support_impulses()[k],
                stays.fall.dynamics.contact().support_impulses()[k], 1e-3)
        << "[N s]";
  }
}

/// A load and the base jump at one time. Had one come before the other, it would have worked against the line where the
/// other had not yet brought it: what each does at once is the mean of both orders.
TEST_P(BaseMotionBy, SharesTheWorkOfAJumpWithALoad) {
  constexpr double kApart = 1e-7;  // [s]
  std::array<EnergyLedger, 3> end{};
  for (std::size_t k = 0; k < end.size(); ++k) {
    const double jump = 0.05 + kApart * (static_cast<double>(k) - 1.0);
    BeamParameters beam = test::steel_beam(16);
    beam.left = test::kPinned;
    beam.right = test::kPinned;
    test::Fall fall{{.beam = beam,
                     .filter = filter(),
                     .gravity = 0.0,
                     .loads = {{.position = 5.0, .table = time_table({jump, jump}, {0.0, 2e4})}},
                     .base_motion = {shock()},
                     .initial = {.height = 0.0}}};
    test::Recorder record{0.01};
    fall.dynamics.add_observer(record);
    fall.dynamics.solve();
    EXPECT_LT(record.largest_drift(), is("moreau") ? 1e-9 : 1e-6) << k;
    end.at(k) = record.energies.back();
  }
  EXPECT_NEAR(end[1].base_work, 0.5 * (end[0].base_work + end[2].base_work), 1e-5 * end[1].scale);
  EXPECT_NEAR(end[1].load_work, 0.5 * (end[0].load_work + end[2].load_work), 1e-5 * end[1].scale);
  EXPECT_GT(std::abs(end[1].base_work), 1.0) << "[J]";
  EXPECT_GT(std::abs(end[1].load_work), 1.0) << "[J]";
}

TEST(BaseMotionTable, GivesWayVelocityAndAccelerationOfEachKind) {
  const std::vector<double> time{0.5, 1.0, 2.0};
  const BaseMotion pushed{BaseQuantity::acceleration, time, {2.0, 4.0, -1.0}};
  EXPECT_DOUBLE_EQ(pushed.at(0.4).velocity, 0.0);
  EXPECT_DOUBLE_EQ(pushed.at(0.5).acceleration, 2.0);
  EXPECT_DOUBLE_EQ(pushed.at(1.0).velocity, 1.5);
  EXPECT_DOUBLE_EQ(pushed.at(1.0).displacement, 0.5 * 0.5 * (2.0 * 2.0 + 4.0) / 6.0);
  EXPECT_DOUBLE_EQ(pushed.at(2.5).velocity, 3.0);
  EXPECT_DOUBLE_EQ(pushed.at(2.5).acceleration, 0.0);
  EXPECT_DOUBLE_EQ(pushed.at(3.0).displacement - pushed.at(2.0).displacement, 3.0);
  EXPECT_DOUBLE_EQ(pushed.peak(), 4.0);
  const BaseMotion driven{BaseQuantity::velocity, time, {1.0, 3.0, 3.0}};
  EXPECT_DOUBLE_EQ(driven.at(0.0).displacement, 0.0);
  EXPECT_DOUBLE_EQ(driven.at(0.5).displacement, 0.5);
  EXPECT_DOUBLE_EQ(driven.at(0.75).velocity, 2.0);
  EXPECT_DOUBLE_EQ(driven.at(0.75).acceleration, 4.0);
  EXPECT_DOUBLE_EQ(driven.at(1.5).acceleration, 0.0);
  EXPECT_DOUBLE_EQ(driven.at(3.0).displacement, 0.5 + 1.0 + 6.0);
}

/// A spline is right to the fourth order in its rows and has no jumps of acceleration between them.
TEST(BaseMotionTable, FollowsDisplacementsByASpline) {
  const auto way = [](double t) { return t * t * t * (10.0 + t * (6.0 * t - 15.0)); };  // at rest at 0 and 1
  std::array<double, 2> off{};
  for (const std::size_t fine : {0U, 1U}) {
    const int rows = fine == 0 ? 20 : 40;
    std::vector<double> time;
    std::vector<double> value;
    for (int k = 0; k <= rows; ++k) {  // of uneven rows
      const double s = static_cast<double>(k) / rows;
      time.push_back(s + 0.1 * s * (1.0 - s));
      value.push_back(way(time.back()));
    }
    const BaseMotion motion{BaseQuantity::displacement, time, value};
    for (int k = 0; k <= 1000; ++k) {
      off[fine] = std::max(off[fine], std::abs(motion.at(1e-3 * k).displacement - way(1e-3 * k)));
    }
    for (std::size_t k = 0; k < time.size(); ++k) {
      EXPECT_NEAR(motion.at(time[k]).displacement, value[k], 1e-15);
    }
    EXPECT_EQ(motion.acceleration()->jumps(), (std::vector<double>{0.0, 1.0})) << "to and from rest alone";
    EXPECT_EQ(motion.at(-1.0).displacement, 0.0);
    EXPECT_EQ(motion.at(2.0).velocity, 0.0);
    EXPECT_EQ(motion.at(2.0).displacement, value.back());
  }
  EXPECT_LT(off[0], 1e-5);
  EXPECT_GT(off[0] / off[1], 12.0);
}

TEST(BaseMotionTable, TakesLongRecords) {
  constexpr int kRows = 100000;
  std::vector<double> time;
  std::vector<double> value;
  for (int k = 0; k < kRows; ++k) {
    time.push_back(0.005 * k);
    value.push_back(std::sin(0.37 * k) - 0.5 * std::sin(1.1 * k));
  }
  const BaseMotion motion{BaseQuantity::acceleration, time, value};
  const BeamChain beam{PETSC_COMM_WORLD, test::steel_beam(12)};
  const Loads loads{beam.points(), 9.81, {}, {&motion, 1}};
  EXPECT_EQ(loads.patterns().size(), 1U);
  EXPECT_EQ(loads.kinks().size(), static_cast<std::size_t>(kRows));
  std::vector<double> work;
  EXPECT_NEAR(loads.force(250.0, work)[0], -beam.points().mass()[0] * (9.81 + value[50000]), 1e-9);
}

TEST(BaseMotionTable, RefusesWhatIsNone) {
  const auto refused = [](BaseQuantity given, std::vector<double> time, std::vector<double> value,
                          const Place& direction = kUp) {
    EXPECT_THROW((BaseMotion{given, std::move(time), std::move(value), direction}), InputError);
  };
  refused(BaseQuantity::acceleration, {0.0}, {1.0});
  refused(BaseQuantity::acceleration, {0.0, 0.0}, {1.0, 1.0});
  refused(BaseQuantity::acceleration, {0.0, 1.0, 1.0, 1.0}, {1.0, 1.0, 2.0, 3.0});
  refused(BaseQuantity::velocity, {0.0, 1.0, 1.0}, {1.0, 1.0, 2.0});
  refused(BaseQuantity::displacement, {0.0, 1.0}, {1.0});
  refused(BaseQuantity::velocity, {0.0, 1.0}, {1.0, 4e8});
  refused(BaseQuantity::displacement, {0.0, 1.0}, {0.0, 1.0}, {});
  const BaseMotion across{BaseQuantity::velocity, {0.0, 1.0}, {0.0, 1.0}, {.x = 1.0}};
  const BeamChain beam{PETSC_COMM_WORLD, test::steel_beam(12)};
  EXPECT_THROW((Loads{beam.points(), 9.81, {}, {&across, 1}}), InputError);
}

}  // namespace
}  // namespace udar
