// ranks: 1 2 3; size: medium
/// @file
/// Places that hold a beam and move by themselves: against a base that moves as all of them do, against the modes of a
/// beam with one end driven, an oscillator of two masses on springs with one foot driven; work and energy.

#include "udar/structure/held_motion.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <string_view>
#include <vector>

#include "support/steel_beam.hpp"
#include "support/world.hpp"

namespace udar {
namespace {

constexpr double kFilter = 200.0;  // [rad/s]

/// Back and forth, in the end with a velocity.
BaseMotion sway() { return {BaseQuantity::acceleration, {0.0, 0.04, 0.1, 0.16, 0.25}, {0.0, 40.0, -50.0, 10.0, 0.0}}; }

/// The tolerance that was asked for, in each of some hundred steps.
constexpr double kAsked = 1e-8;

/// The furthest that it goes at a row [m].
double furthest() { return sway().at(0.1).displacement; }

/// By an integrator, to a tolerance that leaves nothing but rounding, or its own.
struct HeldCase {
  const char* type;
  const char* tolerance;
};

class HeldMotionBy : public testing::TestWithParam<HeldCase> {
 protected:
  [[nodiscard]] static bool is(std::string_view type) { return type == GetParam().type; }

 private:
  test::Option type_{"-ts_type", GetParam().type};
  test::Option tolerance_{"-ts_rtol", GetParam().tolerance};
  test::Option end_{"-ts_max_time", "0.3"};
};

INSTANTIATE_TEST_SUITE_P(All, HeldMotionBy,
                         testing::Values(HeldCase{"chebyshev", "1e-14"}, HeldCase{"impact", "1e-10"},
                                         HeldCase{"rk", "1e-10"}),
                         [](const auto& tested) { return std::string{tested.param.type}; });

/// A run with a row every hundredth of a second.
struct HeldRun {
  explicit HeldRun(const ModelParameters& parameters) : fall{parameters} {
    fall.dynamics.add_observer(record);
    fall.dynamics.solve();
  }

  test::Recorder record{0.01};
  test::Fall fall;
};

double largest_of_all(double own) {
  MPI_Allreduce(MPI_IN_PLACE, &own, 1, MPI_DOUBLE, MPI_MAX, PETSC_COMM_WORLD);
  return own;
}

/// Largest difference of two runs in places, and in velocities times the time of the filter, of all but the held nodes,
/// where the second has the first's places less `base`.
double difference(const HeldRun& moved, const HeldRun& relative, const BaseMotion& base) {
  double largest = 0.0;
  const MassPoints& points = moved.fall.structure->points();
  EXPECT_EQ(moved.record.times.size(), relative.record.times.size());
  for (std::size_t k = 0; k < moved.record.times.size(); ++k) {
    const BaseMotion::State at = base.at(moved.record.times[k]);
    for (std::size_t i = 0; i < points.points(); ++i) {
      if (points.fixed(i)) {
        continue;
      }
      const double place = moved.record.positions[k][i] - at.displacement - relative.record.positions[k][i];
      const double speed = moved.record.velocities[k][i] - at.velocity - relative.record.velocities[k][i];
      largest = std::max({largest, std::abs(place), std::abs(speed) / kFilter});
    }
  }
  return largest_of_all(largest);
}

BeamParameters held_in_three_places() {
  BeamParameters beam = test::steel_beam(16);
  beam.left = test::kPinned;
  beam.right = test::kClamped;
  beam.point_masses = {{.position = 3.125, .mass = 80.0}};
  beam.line_supports = {{.position = 7.5}};
  return beam;
}

std::vector<HeldMotion> all_three(const BaseMotion& motion) {
  return {{.place = {.kind = HeldKind::left_end}, .motion = motion},
          {.place = {.kind = HeldKind::line_support, .number = 0}, .motion = motion},
          {.place = {.kind = HeldKind::right_end}, .motion = motion}};
}

/// Where all places leave at a constant speed the beam does what it does on places that stand, seen by who leaves.
TEST_P(HeldMotionBy, AtOneSpeedIsThatOfWhoMovesPastTheBeam) {
  const BaseMotion leaving{BaseQuantity::velocity, {0.0, 1.0}, {0.9, 0.9}};
  for (const Formulation formulation : {Formulation::mixed, Formulation::hermite}) {
    BeamParameters beam = held_in_three_places();
    beam.tension = formulation == Formulation::mixed ? 2e4 : 0.0;
    ModelParameters parameters{.beam = beam, .filter = {.filter_frequency = kFilter, .formulation = formulation}};
    ModelParameters standing = parameters;
    standing.initial.velocity = -0.9;
    parameters.held_motion = all_three(leaving);
    const HeldRun moved{parameters};
    const HeldRun relative{standing};
    const double way = leaving.at(0.3).displacement;
    EXPECT_LT(difference(moved, relative, leaving), (is("chebyshev") ? 1e-11 : 1e-9) * way);
    EXPECT_LT(moved.record.largest_drift(), is("chebyshev") ? 1e-11 : 1e-7);
    EXPECT_GT(std::abs(moved.record.energies.back().base_work), 10.0) << "[J]";
  }
}

/// A base that moves pulls at the line, as weight does; places take masses along by their springs: the filter's own
/// error apart, which falls with the square of its frequency.
TEST_P(HeldMotionBy, IsThatOfTheBaseButForTheFilter) {
  std::array<double, 3> off{};
  for (std::size_t k = 0; k < off.size(); ++k) {
    BeamParameters beam = test::steel_beam(12);
    beam.left = test::kClamped;
    ModelParameters parameters{.beam = beam, .filter = {.filter_frequency = 400.0 * std::exp2(k)}};
    ModelParameters on_base = parameters;
    on_base.base_motion = {sway()};
    parameters.held_motion = {{.place = {.kind = HeldKind::left_end}, .motion = sway(), .accuracy = 1e-6}};
    off.at(k) = difference(HeldRun{parameters}, HeldRun{on_base}, sway());
  }
  EXPECT_LT(off[0], 0.02 * furthest());
  EXPECT_NEAR(off[0] / off[1], 4.0, 0.5);
  EXPECT_NEAR(off[1] / off[2], 4.0, 0.3);
}

/// A pinned beam whose right end alone moves: it swings about the straight line to that end by its modes, which are
/// sines on the mesh, too.
TEST_P(HeldMotionBy, DrivesTheModesOfABeamByOneEnd) {
  constexpr std::size_t kElements = 12;
  BeamParameters beam = test::steel_beam(kElements);
  beam.left = test::kPinned;
  beam.right = test::kPinned;
  const BeamSegment& segment = beam.segments[0];
  const HeldRun run{{.beam = beam,
                     .filter = {.filter_frequency = kFilter},
                     .gravity = 0.0,
                     .held_motion = {{.place = {.kind = HeldKind::right_end}, .motion = sway(), .accuracy = 1e-7}},
                     .initial = {.height = 0.0}}};
  const double h = segment.length / static_cast<double>(kElements);
  const double mass = segment.mass_per_length * h;
  const BaseMotion motion = sway();
  const TimeTable& acceleration = *motion.acceleration();
  double largest = 0.0;
  for (std::size_t row = 0; row < run.record.times.size(); ++row) {
    const double t = run.record.times[row];
    std::array<double, kElements + 1> place{};
    for (std::size_t i = 0; i <= kElements; ++i) {
      place.at(i) = sway().at(t).displacement * static_cast<double>(i) / kElements;
    }
    for (std::size_t k = 1; k < kElements; ++k) {
      const double angle = std::numbers::pi * static_cast<double>(k) / kElements;
      const double turn = (2.0 - 2.0 * std::cos(angle)) / h;
      const double w2 = turn * turn * 3.0 * segment.bending_stiffness / (h * (2.0 + std::cos(angle)) * mass);
      const double lambda = std::sqrt(kFilter * kFilter * w2 / (kFilter * kFilter + w2));
      double share = 0.0;  // of the straight line
      for (std::size_t i = 1; i < kElements; ++i) {
        share += 2.0 / kElements * static_cast<double>(i) / kElements * std::sin(angle * static_cast<double>(i));
      }
      // q'' + lambda^2 q = -share b'' with b'' linear from row to row.
      std::array<double, 2> q{};
      double begin = 0.0;
      acceleration.each_piece(0.0, t, [&](double, double end) {
        const auto [a, rate] = acceleration.at(begin);
        const double c = -share / (lambda * lambda);
        const double rest = q[0] - c * a;
        const double speed = q[1] - c * rate;
        const double phase = lambda * (end - begin);
        q = {rest * std::cos(phase) + speed / lambda * std::sin(phase) + c * (a + rate * (end - begin)),
             -lambda * rest * std::sin(phase) + speed * std::cos(phase) + c * rate};
        begin = end;
      });
      for (std::size_t i = 1; i < kElements; ++i) {
        place.at(i) += q[0] * std::sin(angle * static_cast<double>(i));
      }
    }
    const MassPoints& points = run.fall.structure->points();
    for (std::size_t i = 0; i < points.points(); ++i) {
      if (!points.fixed(i)) {
        const double closed = place.at(static_cast<std::size_t>(points.global(i)));
        largest = std::max(largest, std::abs(run.record.positions[row][i] - closed));
      }
    }
  }
  EXPECT_LT(largest_of_all(largest), (is("rk") ? 3e-9 : 1e-9) * furthest());
  EXPECT_LT(run.record.largest_drift(), is("impact") ? kAsked : 1e-9);
}

/// Two masses, each on a spring to the ground, with a tight string between them: the foot of one spring moves.
TEST_P(HeldMotionBy, DrivesAnOscillatorOfTwoMassesByOneFoot) {
  if (test::world_size() > 1) {
    GTEST_SKIP() << "one element";
  }
  constexpr double kStiffness = 2e5;  // [N/m]
  constexpr double kTension = 4e5;    // [N]
  BeamParameters beam = test::steel_beam(1);
  beam.left = {.translational_stiffness = kStiffness};
  beam.right = {.translational_stiffness = kStiffness};
  beam.tension = kTension;
  const double mass = 0.5 * beam.segments[0].length * beam.segments[0].mass_per_length;
  const BaseMotion motion{BaseQuantity::velocity, {0.0, 0.1}, {0.3, 0.3}};
  const HeldRun run{{.beam = beam,
                     .filter = {.filter_frequency = kFilter},
                     .gravity = 0.0,
                     .held_motion = {{.place = {.kind = HeldKind::left_end}, .motion = motion}},
                     .initial = {.height = 0.0}}};
  // Together and against each other; the line under a force f at the masses' places 0 goes f / (k + wf^2 m), and a mass
  // is pulled by wf^2 m times that.
  const std::array<double, 2> stiffness{kStiffness, kStiffness + 2.0 * kTension / beam.segments[0].length};
  double work = 0.0;
  for (std::size_t row = 0; row < run.record.times.size(); ++row) {
    const double t = run.record.times[row];
    std::array<double, 2> place{};
    for (std::size_t mode = 0; mode < 2; ++mode) {
      const double k = stiffness.at(mode);
      const double lambda2 = kFilter * kFilter * k / (k + kFilter * kFilter * mass);
      const double lambda = std::sqrt(lambda2);
      const double drive = 0.5 * kStiffness / k * 0.3;  // where it would rest, per second
      const double q = drive * (t - std::sin(lambda * t) / lambda);
      place[0] += q;
      place[1] += mode == 0 ? q : -q;
    }
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_NEAR(run.record.positions[row][i], place.at(i), 1e-9 * 0.09) << t;
    }
    work = run.record.energies[row].base_work;
    EXPECT_NEAR(work, run.record.energies[row].total(), (is("impact") ? kAsked : 1e-9) * run.record.energies[row].scale)
        << "it began with none";
  }
  EXPECT_GT(work, 100.0) << "[J]";
}

/// Ends that move apart, under weight, loads and impacts: what they bring in is in the ledger.
TEST_P(HeldMotionBy, BringsInWhatIsStoredAndLost) {
  BeamParameters beam = test::steel_beam(16);
  beam.left = test::kPinned;
  beam.right = {.translational_stiffness = 3e5};
  const HeldRun run{{.beam = beam,
                     .filter = {.filter_frequency = kFilter},
                     .loads = {{.position = 3.3, .table = time_table({0.0, 0.1, 0.1, 0.2}, {0.0, 900.0, -300.0, 0.0})}},
                     .held_motion = {{.place = {.kind = HeldKind::left_end}, .motion = sway()},
                                     {.place = {.kind = HeldKind::right_end},
                                      .motion = {BaseQuantity::displacement, {0.0, 0.1, 0.2}, {0.0, -0.08, 0.03}}}},
                     .initial = {.height = 0.0},
                     .supports = {{.position = 5.0, .height = -0.02, .restitution = 0.5}}}};
  EXPECT_FALSE(largest_of_all(static_cast<double>(run.record.impacts.size())) == 0.0);
  EXPECT_LT(run.record.largest_drift(), is("chebyshev") ? 1e-10 : 1e-7);
  EXPECT_GT(run.record.energies.back().lost_in_impacts, 1.0) << "[J]";
}

/// What the table leaves out falls as is promised, and rows stand only where the motion bends.
TEST(HeldMotionTable, IsAsCloseAsItIsToldTo) {
  const BaseMotion motion = sway();
  const double way = furthest();
  for (const double accuracy : {1e-2, 1e-4, 1e-6}) {
    const auto table = displacement_table(motion, accuracy);
    double off = 0.0;
    double mean = 0.0;
    for (int k = 0; k <= 50000; ++k) {
      const double t = 5e-6 * k;
      const double error = table->at(t).value - motion.at(t).displacement;
      off = std::max(off, std::abs(error));
      mean += 5e-6 * error;
    }
    EXPECT_LT(off, 1.01 * accuracy * way) << accuracy;
    EXPECT_GT(off, 0.2 * accuracy * way) << accuracy;
    EXPECT_LT(std::abs(mean), 0.02 * off * 0.25) << accuracy;
    EXPECT_DOUBLE_EQ(table->at(5.0).value, motion.at(5.0).displacement);
  }
  EXPECT_LE(displacement_table({BaseQuantity::velocity, {0.0, 1.0, 2.0}, {1.0, 1.0, 1.0}}, 1e-6)->time().size(), 4U);
}

TEST(HeldMotionPlaces, AreRefusedWhereNothingHolds) {
  const auto failure = [](BeamParameters beam, const HeldPlace& place, ModelParameters parameters = {}) {
    parameters.beam = std::move(beam);
    parameters.filter = {.filter_frequency = kFilter};
    parameters.held_motion = {{.place = place, .motion = sway()}};
    return test::failure_of<InputError>([&] { const Model model{PETSC_COMM_WORLD, parameters}; });
  };
  const BeamParameters beam = held_in_three_places();
  EXPECT_NE(failure(test::steel_beam(8), {.kind = HeldKind::left_end}).find("left is not allowed, nothing holds"),
            std::string::npos);
  EXPECT_NE(failure(beam, {.kind = HeldKind::line_support, .number = 1}).find("line_support_1"), std::string::npos);
  EXPECT_NE(failure(beam, {.kind = HeldKind::junction}).find("a beam has none"), std::string::npos);
  BeamParameters twice = beam;
  twice.line_supports = {{.position = 0.0}};
  EXPECT_NE(failure(twice, {.kind = HeldKind::left_end}).find("another support holds its node"), std::string::npos);
  EXPECT_NE(failure(beam, {.kind = HeldKind::left_end},
                    {.supports = {{.position = 5.0}}, .contact = {.surface = ContactSurface::line}})
                .find("contact on the line"),
            std::string::npos);
}

}  // namespace
}  // namespace udar
