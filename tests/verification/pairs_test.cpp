// ranks: 1 2; size: medium
/// @file
/// Nodes of a structure that touch each other across a gap: momentum and energy of both parts, what a wall between two
/// that mirror each other would do, and what a striker would.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "structure/place_algebra.hpp"
#include "support/small_frame.hpp"
#include "support/steel_beam.hpp"
#include "support/world.hpp"
#include "udar/contact/power_law.hpp"
#include "udar/motion/finite.hpp"
#include "udar/structure/striker.hpp"

namespace udar {
namespace {

constexpr double kLength = 2.0;  // of a member [m]
constexpr double kMass = 7850.0 * 5e-3 * kLength;
constexpr std::array kAxes{Place{.x = 1.0}, Place{.y = 1.0}, Place{.z = 1.0}};

/// A face for each pair.
ModelParameters touching(ModelParameters parameters, const std::vector<NodePair>& pairs, double restitution,
                         const std::shared_ptr<const ContactLaw>& law = nullptr) {
  parameters.pairs = pairs;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    Support& face = parameters.supports.emplace_back(Support{.restitution = restitution});
    face.strike = static_cast<PetscInt>(parameters.strikers.size() + i);
    face.contact_law = law;
  }
  return parameters;
}

/// Adds a member from one place to another.
void add_member(NetworkParameters& network, const Place& from, const Place& to, std::size_t elements) {
  const std::size_t first = network.junctions.size();
  for (const Place& place : {from, to}) {
    network.junctions.push_back(test::junction_at(place));
    network.junctions.back().name = "j" + std::to_string(network.junctions.size());
  }
  network.members.push_back(test::member_between(first, first + 1, elements));
}

/// Keeps the state of the nodes at the start and in each row.
class Nodes final : public Observer {
 public:
  Nodes(const MassPoints& points, double interval) : points_{&points}, interval_{interval} {}
  [[nodiscard]] double interval() const override { return interval_; }
  void snapshot(const Snapshot& state) override {
    times.push_back(state.time);
    positions.push_back(node_values(*points_, state.values("mass_position")));
    velocities.push_back(node_values(*points_, state.values("mass_velocity")));
    energies.push_back(state.energy);
  }
  std::vector<double> times;
  std::vector<std::vector<double>> positions;
  std::vector<std::vector<double>> velocities;
  std::vector<EnergyLedger> energies;

 private:
  const MassPoints* points_;
  double interval_;
};

/// A run with rows.
struct Touch {
  explicit Touch(const ModelParameters& parameters, double interval = 1e-3)
      : model{PETSC_COMM_WORLD, parameters}, dynamics{model}, record{model.structure->points(), interval} {
    dynamics.add_observer(record);
    dynamics.add_observer(events);
    dynamics.solve();
  }
  Model model;
  ImpactDynamics dynamics;
  Nodes record;
  struct Events final : Observer {
    [[nodiscard]] double interval() const override { return 0.0; }
    void snapshot(const Snapshot& /*state*/) override {}
    void events(const StepRecords<ImpactRecord>& hits, const StepRecords<RestRecord>& /*stops*/,
                const EventCounts& /*all*/) override {
      impacts.insert(impacts.end(), hits.begin(), hits.end());
    }
    std::vector<ImpactRecord> impacts;
  } events;

  [[nodiscard]] const MassPoints& nodes() const { return model.structure->points().nodes(); }
  /// Over all ranks.
  template <class Value>
  [[nodiscard]] double sum(const Value& value) const {
    double sum = 0.0;
    for (std::size_t point = 0; point < nodes().points(); ++point) {
      sum += value(point);
    }
    MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
    return sum;
  }
  [[nodiscard]] static double along(const Place& a, const Place& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
  /// [kg m/s] Of what stands where `here` says.
  template <class Here>
  [[nodiscard]] double momentum(std::size_t row, const Place& axis, const Here& here) const {
    return sum([&](std::size_t point) {
      return here(nodes().place(point))
                 ? nodes().mass()[point] * along(nodes().axis(point), axis) * record.velocities.at(row)[point]
                 : 0.0;
    });
  }
  [[nodiscard]] double momentum(std::size_t row, const Place& axis) const {
    return momentum(row, axis, [](const Place& /*place*/) { return true; });
  }
  /// How far the node at a place has gone along an axis [m].
  [[nodiscard]] double way(std::size_t row, const Place& place, const Place& axis) const {
    return sum([&](std::size_t point) {
      const Place off{place.x - nodes().place(point).x, place.y - nodes().place(point).y,
                      place.z - nodes().place(point).z};
      return along(off, off) < 1e-12 && along(nodes().axis(point), axis) == 1.0
                 ? record.positions.at(row)[point] - nodes().reference(point)
                 : 0.0;
    });
  }
  [[nodiscard]] std::size_t last() const { return record.times.size() - 1; }
  [[nodiscard]] double drift() const {
    double most = 0.0;
    for (const EnergyLedger& energy : record.energies) {
      most = std::max(most, std::abs(energy.drift()));
    }
    return most;
  }
};

struct Case {
  const char* type;
  const char* tolerance;
};

class PairsBy : public testing::TestWithParam<Case> {
 private:
  test::Option type_{"-ts_type", GetParam().type};
  test::Option tolerance_{"-ts_rtol", GetParam().tolerance};
};
INSTANTIATE_TEST_SUITE_P(All, PairsBy,
                         testing::Values(Case{"chebyshev", "1e-14"}, Case{"impact", "1e-12"}, Case{"rk", "1e-11"}),
                         [](const auto& tested) { return std::string{tested.param.type}; });

/// Two free beams across each other, the upper one falls on the lower one.
NetworkParameters crossing() {
  NetworkParameters cross{.sections = {test::steel_section()}, .junctions = {}, .members = {}};
  add_member(cross, {.x = 0.0}, {.x = kLength}, 6);
  add_member(cross, {.x = 1.0, .y = 0.3, .z = -0.5}, {.x = 1.0, .y = 0.3, .z = 1.5}, 8);
  return cross;
}
constexpr Place kUnder{.x = 1.0};
constexpr Place kOver{.x = 1.0, .y = 0.3};
const Region kUpper{.from = {.x = -9.0, .y = 0.2, .z = -9.0}, .to = {.x = 9.0, .y = 0.4, .z = 9.0}};
bool in_upper(const Place& place) { return kUpper.holds(place); }

/// They turn and drift together, and the upper one comes down besides.
ModelParameters crossing_model() {
  return {.network = crossing(),
          .filter = {.filter_frequency = 1500.0},
          .gravity = 3.0,
          .initial = {.height = 0.7,
                      .velocity = 0.5,
                      .velocity_x = 0.2,
                      .velocity_z = -0.6,
                      .spin = {.x = 0.8, .y = 0.3, .z = 1.1},
                      .parts = {{.region = kUpper, .velocity = {.x = 0.3, .y = -2.0, .z = 0.1}}}}};
}

TEST_P(PairsBy, CrossingBeamsKeepMomentumAndEnergy) {
  constexpr double kEnd = 0.05;
  constexpr double kGap = 1e-3;
  const test::Option end{"-ts_max_time", "0.05"};
  for (const double restitution : {1.0, 0.4, 0.0}) {
    const Touch both{touching(crossing_model(), {{.from = kUnder, .to = kOver, .gap = kGap}}, restitution)};
    for (const Place& axis : kAxes) {
      const double given = -3.0 * kEnd * 2.0 * kMass * axis.y;
      EXPECT_NEAR(both.momentum(both.last(), axis), both.momentum(0, axis) + given, 1e-12 * 2.0 * kMass) << restitution;
    }
    EXPECT_LT(both.drift(), 1e-9) << restitution;
    for (std::size_t row = 0; row <= both.last(); ++row) {
      EXPECT_GE(both.way(row, kOver, kUp) - both.way(row, kUnder, kUp) + kGap, -1e-12) << row;
    }
    // What the pair gives the upper beam, gravity aside.
    const double got = both.momentum(both.last(), kUp, in_upper) - both.momentum(0, kUp, in_upper) + 3.0 * kEnd * kMass;
    const double error = std::string_view{GetParam().type} == "rk" ? 1e-5 : 1e-9;
    EXPECT_NEAR(both.dynamics.support_impulses()[0], got, error * kMass) << restitution;
    EXPECT_GT(got, 0.5 * kMass) << restitution;
  }
}

/// The velocity of the one beside the other turns round, times e, by an impulse on the reduced mass; whichever of the
/// two is the first, and whichever way the normal looks.
TEST_P(PairsBy, FirstImpactIsThatOfBothMasses) {
  const test::Option end{"-ts_max_time", "0.001"};
  constexpr double kLower = kMass / 6.0;
  constexpr double kUpperMass = kMass / 8.0;
  constexpr double kReduced = kLower * kUpperMass / (kLower + kUpperMass);
  for (const double restitution : {0.0, 0.5, 1.0}) {
    for (const bool turned : {false, true}) {
      const NodePair pair = turned ? NodePair{.from = kOver, .to = kUnder, .normal = {.y = -1.0}, .gap = 1e-3}
                                   : NodePair{.from = kUnder, .to = kOver, .gap = 1e-3};
      const Touch hit{touching(crossing_model(), {pair}, restitution)};
      std::array<double, 4> first{};  // how many, the first one's velocities and impulse
      if (!hit.events.impacts.empty()) {
        const ImpactRecord& impact = hit.events.impacts.front();
        first = {1.0, impact.velocity_before, impact.velocity_after, impact.impulse};
      }
      MPI_Allreduce(MPI_IN_PLACE, first.data(), 4, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
      EXPECT_EQ(first[0], 1.0);
      EXPECT_NEAR(first[1], -2.0, 1e-12);  // nothing bends before: they only come together
      EXPECT_NEAR(first[2], 2.0 * restitution, 1e-12);
      EXPECT_NEAR(first[3], 2.0 * (1.0 + restitution) * kReduced, 1e-12 * kMass);
    }
  }
}

/// Two bars in a row, along an axis, that fly at each other.
ModelParameters bars(const Place& axis, double gap, double of_first, double of_second) {
  const auto at = [&](double along) { return Place{.x = along * axis.x, .y = along * axis.y, .z = along * axis.z}; };
  const auto beside = [](double low, double high, const Place& way) {
    return Region{.from = {.x = way.x > 0.0 ? low : -1.0, .y = way.y > 0.0 ? low : -1.0, .z = way.z > 0.0 ? low : -1.0},
                  .to = {.x = way.x > 0.0 ? high : 1.0, .y = way.y > 0.0 ? high : 1.0, .z = way.z > 0.0 ? high : 1.0}};
  };
  NetworkParameters two{.sections = {test::steel_section()}, .junctions = {}, .members = {}};
  add_member(two, at(-kLength), at(0.0), 8);
  add_member(two, at(gap), at(gap + kLength), 8);
  ModelParameters model{.network = std::move(two), .filter = {.filter_frequency = 2e4}, .gravity = 0.0};
  model.initial = {.height = 0.0,
                   .parts = {{.region = beside(-kLength, 0.0, axis), .velocity = of_first * axis},
                             {.region = beside(gap, gap + kLength, axis), .velocity = of_second * axis}}};
  return model;
}

/// Of two bars that mirror each other each moves as if a wall stood between them, by restitution and by a law, which
/// both press half as much.
TEST_P(PairsBy, MirroredBarsMeetAsAtAWall) {
  const test::Option end{"-ts_max_time", "0.003"};
  constexpr double kGap = 1e-3;
  constexpr double kStiffness = 4e9;  // [N/m^1.5]
  const bool knows_laws = std::string_view{GetParam().type} == "impact";
  for (const Place& axis : kAxes) {
    for (const double restitution : {1.0, 0.3, 0.0, -1.0}) {
      const bool by_law = restitution < 0.0;
      if (by_law && !knows_laws) {
        continue;
      }
      const auto law_of = [&](double stiffness) {
        return by_law ? std::make_shared<PowerLaw>(PowerLaw::Parameters{.stiffness = stiffness}) : nullptr;
      };
      const double e = by_law ? 1.0 : restitution;
      const ModelParameters two = bars(axis, kGap, 1.0, -1.0);
      const Touch pair{touching(two, {{.to = kGap * axis, .normal = axis, .gap = kGap}}, e, law_of(kStiffness))};
      ModelParameters one = bars(axis, kGap, 1.0, -1.0);
      one.network->junctions.resize(2);
      one.network->members.resize(1);
      one.supports = {{.position = -0.5 * kLength * axis.x,
                       .width = 10.0,
                       .height = 0.5 * kGap,
                       .restitution = e,
                       .side = SupportSide::above,
                       .normal = axis,
                       .contact_law = law_of(std::pow(2.0, 1.5) * kStiffness)}};
      one.supports[0].x = one.supports[0].y = one.supports[0].z = {-1e-6, 1e-6};
      const Touch wall{one};
      ASSERT_EQ(pair.last(), wall.last());
      for (std::size_t row = 0; row <= pair.last(); ++row) {
        for (const double part : {0.0, 0.5, 1.0}) {
          const double left = pair.way(row, -part * kLength * axis, axis);
          EXPECT_NEAR(left, -pair.way(row, (kGap + part * kLength) * axis, axis), 1e-11) << row;
          EXPECT_NEAR(left, wall.way(row, -part * kLength * axis, axis), 1e-10) << row << ' ' << restitution;
        }
      }
      EXPECT_NEAR(pair.dynamics.support_impulses()[0], std::abs(wall.dynamics.support_impulses()[0]), 1e-8 * kMass);
      EXPECT_GT(pair.dynamics.support_impulses()[0], 0.5 * kMass);
      EXPECT_LT(pair.drift(), 1e-9) << restitution;
    }
  }
}

/// A free mass on a stick without any is a striker.
TEST_P(PairsBy, AFreeMassIsAStriker) {
  const test::Option end{"-ts_max_time", "0.05"};
  constexpr double kStriker = 12.0;
  constexpr double kLight = 1e-9;  // of the density
  NetworkParameters beam{.sections = {test::steel_section(), test::steel_section()}, .junctions = {}, .members = {}};
  add_member(beam, {.x = 0.0}, {.x = kLength}, 6);
  beam.sections[1].name = "stick";
  beam.sections[1].density *= kLight;
  for (const std::size_t junction : {0U, 1U}) {
    beam.junctions[junction].held = {true, true, true, true, false, false};
  }
  const ModelParameters alone{.network = beam, .filter = {.filter_frequency = 1500.0}, .gravity = 5.0};
  add_member(beam, kOver, {.x = 1.0, .y = 1.3}, 1);
  beam.junctions[2].mass = kStriker;
  beam.members[1].section = 1;
  const auto start = [](ModelParameters model) {
    model.initial = {
        .height = 0.0,
        .parts = {{.region = {.from = {.x = 0.0, .y = 0.2, .z = -1.0}, .to = {.x = 2.0, .y = 2.0, .z = 1.0}},
                   .velocity = {.y = -2.0}}}};
    return model;
  };
  ModelParameters with_mass = alone;
  with_mass.network = beam;
  ModelParameters struck = alone;
  struck.strikers = {{.place = kUnder, .mass = kStriker, .gap = 5e-3, .velocity = -2.0}};
  struck.supports = {{.restitution = 0.6}};
  struck.supports[0].strike = 0;
  const Touch pair{touching(start(with_mass), {{.from = kUnder, .to = kOver, .gap = 5e-3}}, 0.6)};
  const Touch striker{start(struck)};
  for (std::size_t row = 0; row <= pair.last(); ++row) {
    for (const double x : {0.0, 1.0 / 3.0, 1.0}) {
      EXPECT_NEAR(pair.way(row, {.x = x}, kUp), striker.way(row, {.x = x}, kUp), 1e-7) << row;
    }
  }
  EXPECT_NEAR(pair.dynamics.support_impulses()[0], striker.dynamics.support_impulses()[0], 1e-5 * kStriker);
  EXPECT_GT(pair.dynamics.support_impulses()[0], 2.0 * kStriker);
  EXPECT_GT(std::abs(pair.way(pair.last(), kUnder, kUp)), 1e-4);
}

/// Both have masses of their own, whatever their unknowns are.
TEST(Pairs, TellNodesApart) {
  const auto structure =
      make_structure(PETSC_COMM_WORLD, touching(crossing_model(), {{.from = kUnder, .to = kOver}}, 1.0));
  const MassPoints& points = structure->points();
  const std::vector<double> masses = node_masses(points);
  for (std::size_t point = 0; point < masses.size(); ++point) {
    EXPECT_NEAR(masses[point], points.nodes().mass()[point], 1e-15 * kMass);
  }
  std::vector<double> values(points.points());
  for (std::size_t point = 0; point < values.size(); ++point) {
    values[point] = std::sin(3.0 + static_cast<double>(point));
  }
  std::vector<double> there = values;
  nodes_to_centres(points, there);
  const std::vector<double> back = node_values(points, there);
  for (std::size_t point = 0; point < values.size(); ++point) {
    EXPECT_NEAR(back[point], values[point], 1e-15);
  }
  each_own(points, [&](const Strike& strike, std::size_t centre, std::size_t gap) {
    EXPECT_TRUE(strike.of_nodes());
    EXPECT_NE(name_of_node(*structure, gap).node, name_of_node(*structure, centre).node);
    EXPECT_DOUBLE_EQ(there[gap], values[gap] - values[centre]);
  });
}

/// A force at either node, along or across the normal, moves that node alone as long as they are apart.
TEST(Pairs, LoadsActOnTheirNode) {
  const test::Option type{"-ts_type", "impact"};
  const test::Option tolerance{"-ts_rtol", "1e-12"};
  const test::Option end{"-ts_max_time", "0.02"};
  for (const bool over : {false, true}) {
    for (const Place& normal : {kUp, Place{.x = 1.0}}) {
      ModelParameters model{.network = crossing(), .filter = {.filter_frequency = 1500.0}, .gravity = 0.0};
      const Place& at = over ? kOver : kUnder;
      model.loads = {{.position = at.x,
                      .table = time_table({0.0, 0.02}, {0.0, 3e3}),
                      .y = at.y,
                      .z = at.z,
                      .direction = {.x = 0.6, .y = 0.8}}};
      model.initial = {.height = 0.0};
      const Touch away{touching(model, {{.from = kUnder, .to = kOver, .normal = normal, .gap = 1.0}}, 1.0)};
      const Touch alone{model};
      for (const Place& axis : kAxes) {
        for (const Place& node : {kUnder, kOver}) {
          EXPECT_NEAR(away.way(away.last(), node, axis), alone.way(alone.last(), node, axis), 1e-11);
        }
      }
      EXPECT_GT(alone.way(alone.last(), at, kUp), 1e-4);
      EXPECT_GT(alone.way(alone.last(), at, kAxes[0]), 1e-4);
    }
  }
}

TEST(Pairs, RefuseWhatCannotBe) {
  const auto refused = [](const std::vector<NodePair>& pairs, std::string_view because,
                          std::vector<Support> supports = {}) {
    ModelParameters model = crossing_model();
    model.network->junctions[0].held = {true, true, true, false, false, false};
    model.supports = std::move(supports);
    const std::string message =
        test::failure_of<InputError>([&] { const Model all{PETSC_COMM_WORLD, touching(model, pairs, 1.0)}; });
    EXPECT_NE(message.find(because), std::string::npos) << message;
  };
  refused({{.from = kUnder, .to = kOver, .gap = -1e-3}}, "pair gap");
  refused({{.from = kUnder, .to = {.x = 3.0}}}, "pair to place");
  refused({{.from = kUnder, .to = {.x = 1.01}}}, "another node");
  refused({{.from = {}, .to = kOver}}, "this one is held");
  refused({{.from = kUnder, .to = kOver, .normal = {.x = 0.6, .y = 0.8}}}, "pair normal");
  refused({{.from = kUnder, .to = kOver}, {.from = {.x = 1.0, .y = 0.3, .z = 0.25}, .to = kUnder}},
          "a node of its own");
  Support floor = Support::floor(-1.0, 1.0);
  refused({{.from = kUnder, .to = kOver}}, "no support may touch", {floor});
}

}  // namespace
}  // namespace udar
