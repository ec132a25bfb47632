// ranks: 1 2 3; size: medium
/// @file
/// Masses that strike a beam: what stays on it is a point mass, what bounces keeps momentum and energy, from below as
/// from above; loads and gauges at a node that is struck.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "support/small_frame.hpp"
#include "support/steel_beam.hpp"
#include "support/world.hpp"
#include "udar/contact/power_law.hpp"
#include "udar/motion/finite.hpp"
#include "udar/structure/striker.hpp"

namespace udar {
namespace {

constexpr double kMass = 300.0;  // [kg], of a node 123

/// The model with strikers and a face for each.
ModelParameters struck(ModelParameters parameters, const std::vector<Striker>& strikers, double restitution,
                       const std::shared_ptr<const ContactLaw>& law = nullptr) {
  parameters.strikers = strikers;
  for (std::size_t i = 0; i < strikers.size(); ++i) {
    Support& face =
        parameters.supports.emplace_back(Support{.position = strikers[i].place.x, .restitution = restitution});
    face.strike = static_cast<PetscInt>(i);
    face.contact_law = law;
  }
  return parameters;
}

/// A run with a row every hundredth of a second; heights of nodes and strikers.
struct Strikes {
  explicit Strikes(const ModelParameters& parameters) : fall{parameters} {
    fall.dynamics.add_observer(record);
    fall.dynamics.solve();
  }

  test::Recorder record{0.01};
  test::Fall fall;

  [[nodiscard]] const MassPoints& points() const { return fall.structure->points(); }
  /// Of what adds up from points, on every rank. @param values of a row
  [[nodiscard]] static double sum(const MassPoints& points, const std::vector<PointShare>& shares,
                                  const std::vector<double>& values) {
    double value = 0.0;
    for (const auto& [point, share] : shares) {
      if (points.owns(point)) {
        value += share * values[static_cast<std::size_t>(point - points.begin())];
      }
    }
    MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
    return value;
  }
  [[nodiscard]] double node(std::size_t row, double x) const {
    return sum(points(), points().height_of(points().nearest({.x = x})), record.positions[row]);
  }
  [[nodiscard]] double striker(std::size_t row, std::size_t which) const {
    return sum(points(), points().height_of(points().strikes()[which].gap), record.positions[row]);
  }
  [[nodiscard]] double speed(std::size_t row, std::size_t which) const {
    return sum(points(), points().height_of(points().strikes()[which].gap), record.velocities[row]);
  }
  /// Of beam and strikers [kg m/s]; gaps have none.
  [[nodiscard]] double momentum(std::size_t row) const {
    double own = 0.0;
    for (std::size_t point = 0; point < points().own_points(); ++point) {
      own += points().mass()[point] * record.velocities[row][point];
    }
    MPI_Allreduce(MPI_IN_PLACE, &own, 1, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
    return own;
  }
};

struct Case {
  const char* type;
  const char* tolerance;
};

class StrikersBy : public testing::TestWithParam<Case> {
 private:
  test::Option type_{"-ts_type", GetParam().type};
  test::Option tolerance_{"-ts_rtol", GetParam().tolerance};
};
INSTANTIATE_TEST_SUITE_P(All, StrikersBy,
                         testing::Values(Case{"chebyshev", "1e-14"}, Case{"impact", "1e-12"}, Case{"rk", "1e-11"}),
                         [](const auto& tested) { return std::string{tested.param.type}; });

BeamParameters pinned_beam() {
  BeamParameters beam = test::steel_beam(20);
  beam.left = test::kPinned;
  beam.right = test::kPinned;
  return beam;
}

/// Laid on a beam that a growing load lifts it stays there, and tends to a point mass with the filter frequency: the
/// node alone has a filter spring, which a point mass makes stiffer.
TEST_P(StrikersBy, OneThatStaysOnTendsToAPointMass) {
  const test::Option end{"-ts_max_time", "0.2"};
  constexpr double kAll = std::numeric_limits<double>::infinity();
  std::array<double, 2> off{};
  for (const std::size_t fine : {0U, 1U}) {
    const ModelParameters beam{.beam = test::steel_beam(10),
                               .filter = {.filter_frequency = fine == 0 ? 1000.0 : 2000.0},
                               .gravity = 0.0,
                               .loads = {{.position = 5.0, .width = kAll, .table = time_table({0.0, 0.2}, {0.0, 1e5})}},
                               .initial = {.height = 0.0}};
    ModelParameters with_mass = beam;
    with_mass.beam.point_masses = {{.position = 4.0, .mass = kMass}};
    const Strikes laid{struck(beam, {{.place = {.x = 4.0}, .mass = kMass}}, 0.0)};
    const Strikes fixed{with_mass};
    ASSERT_EQ(laid.record.times.size(), 21U);
    for (std::size_t row = 0; row < laid.record.times.size(); ++row) {
      EXPECT_NEAR(laid.striker(row, 0), laid.node(row, 4.0), 1e-13) << laid.record.times[row];
      for (const double x : {0.0, 4.0, 7.0}) {
        off.at(fine) = std::max(off.at(fine), std::abs(laid.node(row, x) - fixed.node(row, x)));
      }
    }
    EXPECT_GT(fixed.node(20, 4.0), 0.1);
    EXPECT_LT(laid.record.largest_drift(), 1e-9);
    EXPECT_EQ(laid.fall.dynamics.counts().impacts, 0);
  }
  EXPECT_LT(off[1], 2e-4);
  EXPECT_GT(off[0] / off[1], 3.0);
}

/// One from above and one from below on a beam that flies: what is given is taken.
TEST_P(StrikersBy, KeepMomentumAndEnergy) {
  const test::Option end{"-ts_max_time", "0.3"};
  for (const double restitution : {1.0, 0.4, 0.0}) {
    const Strikes both{struck({.beam = test::steel_beam(20),
                               .filter = {.filter_frequency = 100.0},
                               .gravity = 3.0,
                               .initial = {.height = 0.0}},
                              {{.place = {.x = 2.5}, .mass = kMass, .gap = 0.01, .velocity = -4.0},
                               {.place = {.x = 8.0}, .mass = 10.0, .gap = 0.05, .velocity = 7.0, .below = true}},
                              restitution)};
    const std::size_t last = both.record.times.size() - 1;
    const double mass = both.points().total_mass();
    const double start = -4.0 * kMass + 7.0 * 10.0;
    EXPECT_NEAR(both.momentum(0), start, 1e-11 * mass);
    EXPECT_NEAR(both.momentum(last) - start, -3.0 * 0.3 * mass, 1e-11 * mass) << restitution;
    EXPECT_LT(both.record.largest_drift(), 1e-9) << restitution;
    for (std::size_t row = 0; row <= last; ++row) {
      EXPECT_GE(both.striker(row, 0) - both.node(row, 2.5), -1e-12) << both.record.times[row];
      EXPECT_GE(both.node(row, 8.0) - both.striker(row, 1), -1e-12) << both.record.times[row];
    }
    EXPECT_GT(both.fall.dynamics.counts().impacts, restitution > 0.0 ? 2 : 1);
    // The integral of its pull on what rests is of the order of the step in Runge-Kutta's.
    const double error = std::string_view{GetParam().type} == "rk" ? 1e-5 : 1e-8;
    // The impulse of the contact is what the striker has lost.
    const auto& impulse = both.fall.dynamics.support_impulses();
    EXPECT_NEAR(impulse[0], kMass * (both.speed(last, 0) + 4.0 + 3.0 * 0.3), error) << restitution;
    EXPECT_NEAR(impulse[1], -10.0 * (both.speed(last, 1) - 7.0 + 3.0 * 0.3), error) << restitution;
    EXPECT_GT(impulse[0], 10.0);
  }
}

/// A node of the mass of its striker takes over all of its speed.
TEST_P(StrikersBy, EqualMassesExchangeTheirVelocities) {
  const test::Option end{"-ts_max_time", "0.01"};
  const BeamParameters beam = test::steel_beam(20);
  const double node_mass = beam.segments[0].mass_per_length * 0.5;
  const Strikes hit{
      struck({.beam = beam, .filter = {.filter_frequency = 100.0}, .gravity = 0.0, .initial = {.height = 0.0}},
             {{.place = {.x = 5.0}, .mass = node_mass, .gap = 0.01, .velocity = -1.25}}, 1.0)};
  // It arrives at 8 ms, and stands still from then on, while the node is 2 ms further.
  EXPECT_NEAR(hit.speed(1, 0), 0.0, 1e-13);
  EXPECT_NEAR(hit.striker(1, 0), 0.0, 1e-13);
  EXPECT_NEAR(hit.node(1, 5.0), -1.25 * 2e-3, 1e-4);
  EXPECT_EQ(hit.fall.dynamics.counts().impacts, 1);
}

TEST_P(StrikersBy, FromBelowIsFromAboveTurnedOver) {
  const test::Option end{"-ts_max_time", "0.2"};
  const ModelParameters beam{
      .beam = pinned_beam(), .filter = {.filter_frequency = 100.0}, .gravity = 0.0, .initial = {.height = 0.0}};
  const Striker above{.place = {.x = 6.5}, .mass = kMass, .gap = 0.02, .velocity = -3.0};
  const Striker below{.place = {.x = 6.5}, .mass = kMass, .gap = 0.02, .velocity = 3.0, .below = true};
  const Strikes down{struck(beam, {above}, 0.7)};
  const Strikes up{struck(beam, {below}, 0.7)};
  for (std::size_t row = 0; row < down.record.times.size(); ++row) {
    EXPECT_NEAR(down.striker(row, 0), -up.striker(row, 0), 1e-12);
    EXPECT_NEAR(down.node(row, 6.5), -up.node(row, 6.5), 1e-12);
    EXPECT_NEAR(down.node(row, 1.0), -up.node(row, 1.0), 1e-12);
  }
  EXPECT_GT(down.fall.dynamics.counts().impacts, 1);
}

/// A load at the node, spread or not, acts on the node and not on what has left it.
TEST_P(StrikersBy, LoadsActOnTheNode) {
  const test::Option end{"-ts_max_time", "0.2"};
  for (const double width : {0.0, 2.0}) {
    const auto table = time_table({0.0, 0.2}, {0.0, 3e3});
    const ModelParameters beam{.beam = pinned_beam(),
                               .filter = {.filter_frequency = 100.0},
                               .gravity = 0.0,
                               .loads = {{.position = 6.5, .width = width, .table = table}},
                               .initial = {.height = 0.0}};
    const Strikes away{struck(beam, {{.place = {.x = 6.5}, .mass = kMass, .gap = 1.0, .velocity = 1.0}}, 1.0)};
    const Strikes alone{beam};
    for (std::size_t row = 0; row < away.record.times.size(); ++row) {
      EXPECT_NEAR(away.striker(row, 0), 1.0 + away.record.times[row], 1e-12);
      // Steps are others, and each is right to -ts_rtol.
      EXPECT_NEAR(away.node(row, 6.5), alone.node(row, 6.5), 1e-10);
      EXPECT_NEAR(away.node(row, 2.0), alone.node(row, 2.0), 1e-10);
    }
    EXPECT_GT(alone.node(20, 6.5), 1e-3);
    EXPECT_NEAR(away.record.energies.back().load_work, alone.record.energies.back().load_work, 1e-7);
  }
}

/// Base and travelling loads find their way as well.
TEST(Strikers, StayBehindABaseAndLetAxlesPass) {
  const test::Option type{"-ts_type", "impact"};
  const test::Option tolerance{"-ts_rtol", "1e-12"};
  const test::Option end{"-ts_max_time", "0.2"};
  const BaseMotion shaken{BaseQuantity::acceleration, {0.0, 0.05, 0.2}, {0.0, 8.0, -3.0}};
  const ModelParameters beam{.beam = pinned_beam(),
                             .filter = {.filter_frequency = 100.0},
                             .gravity = 0.0,
                             .travelling_loads = {{.offset = {0.0, 1.5}, .force = {-2e3, -1e3}, .speed = 40.0}},
                             .base_motion = {shaken},
                             .initial = {.height = 0.0}};
  const Strikes away{struck(beam, {{.place = {.x = 5.0}, .mass = kMass, .gap = 3.0}}, 1.0)};
  const Strikes alone{beam};
  for (std::size_t row = 0; row < away.record.times.size(); ++row) {
    const double base = shaken.at(away.record.times[row]).displacement;
    EXPECT_NEAR(away.striker(row, 0) + base, 3.0, 1e-9);
    EXPECT_NEAR(away.node(row, 5.0), alone.node(row, 5.0), 1e-9);
  }
}

/// What hardly gives way sends a ball back as a wall would.
TEST(Strikers, ABallByHertzComesBackFromAStiffBeam) {
  const test::Option type{"-ts_type", "impact"};
  const test::Option tolerance{"-ts_rtol", "1e-12"};
  const test::Option end{"-ts_max_time", "0.02"};
  BeamParameters beam = test::steel_beam(8);
  beam.segments[0].bending_stiffness *= 1e3;
  beam.left = test::kClamped;
  beam.right = test::kClamped;
  constexpr double kStiffness = 1e8;  // [N/m^1.5]
  constexpr double kSpeed = 0.5;
  constexpr double kBall = 0.2;
  const auto law = std::make_shared<PowerLaw>(PowerLaw::Parameters{.stiffness = kStiffness});
  const Strikes hit{
      struck({.beam = beam, .filter = {.filter_frequency = 2e4}, .gravity = 0.0, .initial = {.height = 0.0}},
             {{.place = {.x = 5.0}, .mass = kBall, .gap = 0.0, .velocity = -kSpeed}}, 1.0, law)};
  EXPECT_NEAR(hit.speed(1, 0), kSpeed, 2e-3 * kSpeed);
  EXPECT_LT(hit.record.largest_drift(), 1e-9);
  EXPECT_NEAR(hit.fall.dynamics.support_impulses()[0], 2.0 * kBall * kSpeed, 2e-3 * kBall * kSpeed);
}

/// How far off it starts is no strain: tolerances are those of its fall, however high the filter frequency.
TEST(Strikers, FallFreelyAtAnyFilterFrequency) {
  constexpr double kTolerance = 1e-11;
  constexpr double kEnd = 0.07;
  const test::Option type{"-ts_type", "impact"};
  const test::Option tolerance{"-ts_rtol", "1e-11"};
  const test::Option end{"-ts_max_time", "0.07"};
  constexpr double kGravity = 9.81;
  constexpr double kGap = 0.02;  // it hits with sqrt(2 g h), 0.63 m/s, after 64 ms
  constexpr double kFalling = 80.0;
  BeamParameters beam = test::steel_beam(8);  // so stiff that it stays where it is
  beam.segments[0].bending_stiffness *= 1e3;
  beam.left = test::kClamped;
  beam.right = test::kClamped;
  const auto law = std::make_shared<PowerLaw>(PowerLaw::Parameters{.stiffness = 1e8});
  for (const double wf : {1e5, 1e6}) {
    const Strikes fall{
        struck({.beam = beam, .filter = {.filter_frequency = wf}, .gravity = kGravity, .initial = {.height = 0.0}},
               {{.place = {.x = 5.0}, .mass = kFalling, .gap = kGap}}, 1.0, law)};
    const double last = std::sqrt(2.0 * kGravity * kGap);
    const double off = 10.0 * kTolerance * std::sqrt(wf * kEnd);  // errors of steps have no sign
    for (std::size_t row = 0; row < 7; ++row) {
      const double time = fall.record.times[row];
      EXPECT_NEAR(fall.speed(row, 0), -kGravity * time, off * last) << wf;
      EXPECT_NEAR(fall.striker(row, 0), kGap - 0.5 * kGravity * time * time, off * kGap) << wf;
    }
    EXPECT_GT(fall.fall.dynamics.support_impulses()[0], 0.5 * kFalling * last) << wf;
    for (const EnergyLedger& energy : fall.record.energies) {  // beside what it brings, which no tolerance hides
      EXPECT_LT(std::abs(energy.drift() * energy.scale), 2.0 * off * kFalling * kGravity * kGap) << wf;
    }
  }
}

/// What goes wrong is told of the node, of a beam as of a network, whose table of points ends before the gaps.
TEST(Strikers, HaveTheNameOfTheirNode) {
  const ModelParameters beam{.beam = pinned_beam()};
  std::vector<ModelParameters> all{beam};
  int ranks = 1;
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  if (ranks <= 2) {  // as many as it has junctions
    all.push_back({.network = test::turned_beam(10.0, 20)});
  }
  for (const ModelParameters& parameters : all) {
    const auto structure =
        make_structure(PETSC_COMM_WORLD, struck(parameters, {{.place = {.x = 5.0}, .mass = 1.0}}, 1.0));
    const MassPoints& points = structure->points();
    each_own(points, [&](const Strike& /*strike*/, std::size_t centre, std::size_t gap) {
      EXPECT_EQ(name_of_node(*structure, gap).node, name_of_node(*structure, centre).node);
      EXPECT_DOUBLE_EQ(name_of_node(*structure, gap).x, 5.0);
    });
  }
}

TEST(Strikers, RefuseWhatCannotBe) {
  const auto refused = [](const Striker& striker, std::string_view because, std::vector<Support> supports = {}) {
    ModelParameters beam{.beam = pinned_beam(), .filter = {.filter_frequency = 100.0}, .supports = std::move(supports)};
    const std::string message =
        test::failure_of<InputError>([&] { const Model model{PETSC_COMM_WORLD, struck(beam, {striker}, 1.0)}; });
    EXPECT_NE(message.find(because), std::string::npos) << message;
  };
  refused({.place = {.x = 5.0}, .mass = 0.0}, "striker mass");
  refused({.place = {.x = 5.0}, .mass = 1.0, .gap = -1e-3}, "striker gap");
  refused({.place = {.x = 11.0}, .mass = 1.0}, "striker position");
  refused({.place = {.x = 0.0}, .mass = 1.0}, "this one is held");
  refused({.place = {.x = 5.0}, .mass = 1.0}, "no support may touch", {{.position = 5.0}});
  const ModelParameters beam{.beam = pinned_beam(), .filter = {.filter_frequency = 100.0}};
  const std::vector<Striker> two{{.place = {.x = 5.0}, .mass = 1.0}, {.place = {.x = 5.1}, .mass = 1.0, .below = true}};
  const std::string message =
      test::failure_of<InputError>([&] { const Model model{PETSC_COMM_WORLD, struck(beam, two, 1.0)}; });
  EXPECT_NE(message.find("a node of its own"), std::string::npos) << message;
}

}  // namespace
}  // namespace udar
