// ranks: 1 2; size: medium
/// @file
/// Masses that travel along a beam and are carried by it: the series of Stokes, modal equations of a simply supported
/// beam, momentum and energy of a free one, a mass that is none.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include "support/steel_beam.hpp"
#include "support/world.hpp"

namespace udar {
namespace {

/// Keeps the masses that travel; only the first rank hears of their heights.
class RiderRecorder final : public Observer {
 public:
  explicit RiderRecorder(double interval) : interval_{interval} {}
  [[nodiscard]] double interval() const override { return interval_; }
  void snapshot(const Snapshot& state) override {
    times.push_back(state.time);
    riders.emplace_back(state.riders.begin(), state.riders.end());
    drift = std::max(drift, std::abs(state.energy.drift()));
    ledger = state.energy;
  }

  std::vector<double> times;
  std::vector<std::vector<RiderState>> riders;
  double drift = 0.0;
  EnergyLedger ledger;

 private:
  double interval_;
};

bool first_rank() {
  int rank = 0;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  return rank == 0;
}

BeamParameters simply_supported(PetscInt elements, double mass_per_length) {
  BeamParameters beam = test::steel_beam(elements);
  beam.left = test::kPinned;
  beam.right = test::kPinned;
  beam.segments[0].mass_per_length = mass_per_length;
  return beam;
}

/// The height of a mass M that crosses a massless simply supported beam with the speed v, over its static sag in the
/// middle, as the share s of the length is behind it: with y = 16 S Y the equation M y'' = M g - 3 EI L y / (x (L -
/// x))^2 is Y'' = b - b Y / (s (1 - s))^2, solved by powers of s. Source: G. G. Stokes, Discussion of a differential
/// equation relating to the breaking of railway bridges, Trans. Cambridge Phil. Soc. 8 (1849) 707.
double stokes(double b, double s) {
  std::array<double, 3> last{};  // coefficients n - 2, n - 1, n
  double sum = 0.0;
  double power = s * s;
  for (int n = 2; n < 2000; ++n) {
    const double given = n == 2 ? b : n == 3 ? -2.0 * b : n == 4 ? b : 0.0;
    last = {last[1], last[2], 0.0};
    last[2] = (given + 2.0 * (n - 1) * (n - 2) * last[1] - (n - 2.0) * (n - 3.0) * last[0]) / (n * (n - 1.0) + b);
    sum += last[2] * power;
    power *= s;
  }
  return 16.0 * sum;
}

/// The largest distance from it up to 0.9 of the length, over the sag in the middle. @param light mass of the beam over
/// that which travels @param wf over the first frequency of the beam
double off_stokes(double light, double wf, PetscInt elements) {
  constexpr double kB = 2.0;
  BeamParameters beam = simply_supported(elements, 1.0);
  BeamSegment& segment = beam.segments[0];
  const double mass = 500.0;
  segment.mass_per_length = light * mass / segment.length;
  const double speed = std::sqrt(3.0 * segment.bending_stiffness / (kB * mass * segment.length));
  const double sag = mass * 9.81 * std::pow(segment.length, 3) / (48.0 * segment.bending_stiffness);
  const double first =
      std::pow(std::numbers::pi / segment.length, 2) * std::sqrt(segment.bending_stiffness / segment.mass_per_length);
  const double crossing = segment.length / speed;
  const test::Option end{"-ts_max_time", std::to_string(0.9 * crossing).c_str()};
  ModelParameters model{.beam = beam, .filter = {.filter_frequency = wf * first}, .gravity = 9.81};
  model.travelling_loads = {{.offset = {0.0}, .force = {0.0}, .speed = speed, .mass = {mass}}};
  model.initial.height = 0.0;
  test::Fall fall{model};
  RiderRecorder record{crossing / 20.0};
  fall.dynamics.add_observer(record);
  fall.dynamics.solve();
  EXPECT_LT(record.drift, 1e-6);
  double off = 0.0;
  for (std::size_t k = 0; k < record.times.size() && first_rank(); ++k) {
    off = std::max(off, std::abs(-record.riders[k][0].height / sag - stokes(kB, record.times[k] / crossing)));
  }
  MPI_Bcast(&off, 1, MPI_DOUBLE, 0, PETSC_COMM_WORLD);
  return off;
}

TEST(TravellingMass, CrossesALightBeamAsStokesFound) {
  // The beam's inertia and weight are off by their share; found 0.019 and 0.0041.
  const double heavy = off_stokes(0.02, 20.0, 40);
  const double light = off_stokes(0.005, 20.0, 40);
  EXPECT_LT(heavy, 0.02);
  EXPECT_LT(light, 0.25 * 0.02);
  EXPECT_GT(heavy, 3.0 * light);
}

/// A steel beam under two masses, one on a spring, that are on it from the start.
ModelParameters carrying(PetscInt elements, double wf) {
  ModelParameters model{.beam = test::steel_beam(elements), .filter = {.filter_frequency = wf}, .gravity = 9.81};
  model.travelling_loads = {{.offset = {0.0, 1.5},
                             .force = {0.0, 0.0},
                             .speed = 12.0,
                             .start = -0.3,
                             .mass = {700.0, 400.0},
                             .stiffness = {0.0, 3e5}}};
  model.initial = {.height = 0.0, .velocity = 1.0, .angular_velocity = 0.4};
  return model;
}

TEST(TravellingMass, KeepsMomentumAndTurningOfAFreeBeam) {
  constexpr double kEnd = 0.3;
  const test::Option end{"-ts_max_time", "0.3"};
  const test::Option tolerance{"-ts_rtol", "1e-10"};
  test::Fall fall{carrying(40, 200.0)};
  const MassState before = fall.dynamics.masses();
  RiderRecorder record{0.01};
  fall.dynamics.add_observer(record);
  fall.dynamics.solve();
  const MassState after = fall.dynamics.masses();
  const std::span<const Rider> riders = fall.structure->points().riders();
  ASSERT_EQ(riders.size(), 2U);
  std::array<double, 3> sums{};  // gain of momentum, gain of moment, what weight and guidance gave to that
  for (std::size_t i = 0; i < after.velocity.size(); ++i) {
    const bool node = i < fall.structure->points().own_points();
    const double x = fall.structure->points().place(i).x;
    const double mass = fall.line.mass()[i];
    sums[0] += mass * (after.velocity[i] - before.velocity[i]);
    sums[1] += node ? mass * x * (after.velocity[i] - before.velocity[i]) : 0.0;
    sums[2] -= node ? mass * x * 9.81 * kEnd : 0.0;
  }
  for (const Rider& rider : riders) {
    if (fall.structure->points().owns(rider.point)) {
      const auto i = static_cast<std::size_t>(rider.point - fall.structure->points().begin());
      const double from = rider.passage.x(0.0);
      const double to = rider.passage.x(kEnd);
      sums[1] += rider.mass * (to * after.velocity[i] - from * before.velocity[i]);
      sums[2] += rider.mass * (12.0 * (after.position[i] - before.position[i]) - 9.81 * kEnd * 0.5 * (from + to));
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), 3, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
  const double given = -9.81 * kEnd * fall.structure->points().total_mass();
  // Sums of some hundred steps round by their last digits; moments are as exact as positions.
  EXPECT_NEAR(sums[0], given, 1e-11 * std::abs(given));
  EXPECT_NEAR(sums[1], sums[2], 1e-8 * std::abs(sums[2]));
  EXPECT_LT(record.drift, 1e-9);
  EXPECT_GT(std::abs(record.ledger.load_work), 10.0);  // by the guidance, on the slope of a beam that turns
}

/// The force between a mass and the line is what it takes to move it.
TEST(TravellingMass, PressesByItsWeightAndItsInertia) {
  const test::Option end{"-ts_max_time", "0.1"};
  test::Fall fall{carrying(40, 200.0)};
  RiderRecorder record{1e-4};
  fall.dynamics.add_observer(record);
  fall.dynamics.solve();
  for (std::size_t k = 1; k + 1 < record.times.size() && first_rank(); k += 50) {
    for (const std::size_t i : {0U, 1U}) {
      const double mass = i == 0 ? 700.0 : 400.0;
      const double acceleration = (record.riders[k + 1][i].velocity - record.riders[k - 1][i].velocity) / 2e-4;
      EXPECT_NEAR(record.riders[k][i].force, -mass * (9.81 + acceleration), 1e-3 * mass * 9.81);
      // What stands on no spring is on the line but for its filter spring.
      const double above = record.riders[k][i].height - record.riders[k][i].below;
      const double softness = 1.0 / (200.0 * 200.0 * mass) + (i == 0 ? 0.0 : 1.0 / 3e5);
      EXPECT_NEAR(above, (record.riders[k][i].force + mass * 9.81) * softness, 1e-9);
    }
  }
}

/// Heights of all masses, those that travel last, and of the line at the end.
std::vector<double> end_of(const ModelParameters& model) {
  test::Fall fall{model};
  RiderRecorder record{0.05};
  fall.dynamics.add_observer(record);
  fall.dynamics.solve();
  EXPECT_LT(record.drift, 1e-8);
  return fall.dynamics.masses().position;
}

double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double off = 0.0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    off = std::max(off, std::abs(a[i] - b[i]));
  }
  MPI_Allreduce(MPI_IN_PLACE, &off, 1, MPI_DOUBLE, MPI_MAX, PETSC_COMM_WORLD);
  return off;
}

ModelParameters crossing(double force, double mass, double speed) {
  ModelParameters model{.beam = simply_supported(20, 246.6), .filter = {.filter_frequency = 200.0}, .gravity = 0.0};
  model.travelling_loads = {{.offset = {0.0, 2.2}, .force = {force, force}, .speed = speed, .mass = {mass, mass}}};
  model.initial.height = 0.0;
  return model;
}

TEST(TravellingMass, IsAForceIfItHasNoInertia) {
  const test::Option end{"-ts_max_time", "0.4"};
  const test::Option type{"-ts_type", "rk"};
  const test::Option tolerance{"-ts_rtol", "1e-10"};
  const std::vector<double> force = end_of(crossing(-2e4, 0.0, 20.0));
  const double heavy = largest_difference(force, end_of(crossing(-2e4, 1e-2, 20.0)));
  const double light = largest_difference(force, end_of(crossing(-2e4, 1e-4, 20.0)));
  EXPECT_GT(heavy, 1e-8);
  EXPECT_NEAR(light, 0.01 * heavy, 0.002 * heavy);
}

TEST(TravellingMass, GoesEitherWay) {
  const test::Option end{"-ts_max_time", "0.4"};
  const test::Option tolerance{"-ts_rtol", "1e-10"};
  ModelParameters model = crossing(0.0, 500.0, 20.0);
  model.gravity = 9.81;
  test::Fall right{model};
  model.travelling_loads[0].speed = -20.0;
  test::Fall left{model};
  for (test::Fall* fall : {&right, &left}) {
    fall->dynamics.solve();
  }
  std::vector<std::vector<double>> lines;
  for (test::Fall* fall : {&right, &left}) {
    const MassState masses = fall->dynamics.masses();
    std::vector<double>& all = lines.emplace_back(23, 0.0);
    for (std::size_t i = 0; i < masses.position.size(); ++i) {
      const MassPoints& points = fall->structure->points();
      const std::size_t node =
          i < points.own_points() ? static_cast<std::size_t>(points.nodes().begin()) + i : 21 + i - points.own_points();
      all[node] = masses.position[i];
    }
    MPI_Allreduce(MPI_IN_PLACE, all.data(), 23, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
  }
  EXPECT_LT(lines[0][10], -1e-3);
  for (std::size_t node = 0; node <= 20; ++node) {
    EXPECT_NEAR(lines[0][node], lines[1][20 - node], 1e-10) << node;
  }
  EXPECT_NEAR(lines[0][21], lines[1][21], 1e-10);
  EXPECT_NEAR(lines[0][22], lines[1][22], 1e-10);
}

/// Gravity and a base that is accelerated upwards are the same to what stands on it.
TEST(TravellingMass, FeelsTheMotionOfTheBase) {
  const test::Option end{"-ts_max_time", "0.3"};
  const test::Option tolerance{"-ts_rtol", "1e-10"};
  ModelParameters model = crossing(0.0, 500.0, 20.0);
  model.gravity = 9.81;
  const std::vector<double> heavy = end_of(model);
  model.gravity = 0.0;
  model.base_motion.emplace_back(BaseQuantity::acceleration, std::vector<double>{0.0, 1.0},
                                 std::vector<double>{9.81, 9.81}, kUp);
  EXPECT_LT(largest_difference(heavy, end_of(model)), 1e-10);
}

/// A striker that rests on the beam meanwhile: what it is pressed with is an integral of the line's stretch, whose rate
/// masses that travel are part of.
TEST(TravellingMass, PassesUnderAMassThatRestsOnTheBeam) {
  const test::Option end{"-ts_max_time", "0.5"};
  const test::Option tolerance{"-ts_rtol", "1e-9"};
  ModelParameters model = crossing(0.0, 500.0, 20.0);
  model.gravity = 9.81;
  model.strikers = {{.place = {.x = 6.0}, .mass = 40.0, .gap = 0.0}};
  model.supports = {{.restitution = 0.0, .strike = 0}};
  test::Fall fall{model};
  test::Recorder events{0.01};
  RiderRecorder record{0.01};
  fall.dynamics.add_observer(events);
  fall.dynamics.add_observer(record);
  fall.dynamics.solve();
  EXPECT_GT(fall.dynamics.counts().rests, 0);
  EXPECT_LT(record.drift, 1e-8);
  const Strike& strike = fall.structure->points().strikes()[0];
  const MassState masses = fall.dynamics.masses();
  double speed = 0.0;
  each_own(fall.structure->points(), [&](const Strike& of, std::size_t centre, std::size_t gap) {
    speed = of.other_of(masses.velocity[centre], masses.velocity[gap]);
  });
  MPI_Allreduce(MPI_IN_PLACE, &speed, 1, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
  const double given = 40.0 * (speed - strike.velocity + 9.81 * 0.5);
  // Ten times the tolerance; without the masses' part in the rate the balance of energy is off by far more.
  EXPECT_NEAR(events.support_impulses.back()[0], given, 1e-8 * given);
}

TEST(TravellingMass, IsRefusedWithWhatDoesNotKnowIt) {
  ModelParameters model = crossing(0.0, 500.0, 20.0);
  const auto refused = [](const ModelParameters& parameters) { EXPECT_THROW(test::Fall{parameters}, InputError); };
  ModelParameters damped = model;
  damped.damping.mass = 1.0;
  refused(damped);
  ModelParameters held = model;
  held.contact.surface = ContactSurface::line;
  held.supports = {{.position = 5.0, .height = -0.1}};
  refused(held);
  for (const char* type : {"chebyshev", "impact", "modal"}) {
    const test::Option given{"-ts_type", type};
    refused(model);
  }
  ModelParameters negative = model;
  negative.travelling_loads[0].mass = {-1.0, 1.0};
  refused(negative);
  negative.travelling_loads[0].mass = {1.0};
  refused(negative);
  ModelParameters gap = model;
  gap.beam.segments.push_back(gap.beam.segments.front());
  gap.beam.segments.insert(gap.beam.segments.begin() + 1, BeamSegment{.length = 0.5, .elements = 1});
  refused(gap);
}

}  // namespace
}  // namespace udar
