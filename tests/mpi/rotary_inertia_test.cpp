// ranks: 1 2 3; size: short
/// @file
/// Rotary inertia of members about their axes: torsional frequencies, both solvers, rigid motions, turned copies.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "support/small_frame.hpp"
#include "support/world.hpp"
#include "udar/filter/filtered_structure.hpp"
#include "udar/filter/modes.hpp"
#include "udar/petsc/scoped_options.hpp"
#include "udar/structure/initial_state.hpp"
#include "udar/structure/junction_rotations.hpp"

namespace udar {
namespace {

using test::jagged_spacing;
using test::small_house;
using test::steel_section;
using test::Turn;
using test::turned_beam;

constexpr Turn kTilt{.about_z = 0.3, .about_x = 0.7};
constexpr double kFilter = 2000.0;  // [rad/s]

NetworkParameters rotary(NetworkParameters network) {
  network.rotary_inertia = true;
  return network;
}

/// A network and a solver: members condensed, or the assembled frame by CHOLMOD, on several ranks by MUMPS.
struct Solved {
  Network network;
  std::unique_ptr<FilteredStructure> line;

  Solved(const NetworkParameters& given, bool assembled, MPI_Comm comm = PETSC_COMM_WORLD) : network{comm, given} {
    const petsc::ScopedOptions scoped{assembled ? petsc::Options{{"-filter_pc_type", "cholesky"}} : petsc::Options{}};
    line = std::make_unique<FilteredStructure>(network,
                                               FilterParameters{.filter_frequency = kFilter, .check_interval = 1});
  }
};

/// Sum over all ranks.
void add_up(std::vector<double>& values) {
  MPI_Allreduce(MPI_IN_PLACE, values.data(), static_cast<int>(values.size()), MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
}

/// The rigid motion of all points.
std::vector<double> rigid(const MassPoints& points, const Place& shift, const Place& turn) {
  std::vector<double> motion;
  for (std::size_t i = 0; i < points.points(); ++i) {
    const Place at = points.place(i);
    const Place moved{.x = shift.x + turn.y * at.z - turn.z * at.y,
                      .y = shift.y + turn.z * at.x - turn.x * at.z,
                      .z = shift.z + turn.x * at.y - turn.y * at.x};
    const Place along = points.axis(i);
    const Place about = points.turning(i);
    motion.push_back(along.x * moved.x + along.y * moved.y + along.z * moved.z + about.x * turn.x + about.y * turn.y +
                     about.z * turn.z);
  }
  return motion;
}

/// Of each node, 12 numbers: vectors of what points that move have, then of those that turn, of two quantities.
std::vector<double> vectors(const Network& network, const std::vector<double>& first,
                            const std::vector<double>& second) {
  const MassPoints& points = network.points();
  const Topology topology = network.topology();
  std::vector<double> all(12 * network.total_nodes(), 0.0);
  for (std::size_t i = 0; i < points.points(); ++i) {
    const auto node = static_cast<std::size_t>(topology.node_number[topology.node[i]]);
    std::size_t at = 12 * node;
    for (const std::vector<double>* values : {&first, &second}) {
      for (const Place& axis : {points.axis(i), points.turning(i)}) {
        all[at++] += axis.x * (*values)[i];
        all[at++] += axis.y * (*values)[i];
        all[at++] += axis.z * (*values)[i];
      }
    }
  }
  add_up(all);
  return all;
}

/// A motion, forces and moments that depend on nodes' numbers alone, along turned axes, and the stretch, by node.
/// @param fields of elements, of this rank, if they are wanted
std::vector<double> answer_by_node(Solved& solved, const Turn& turn, bool loaded,
                                   std::vector<double>* fields = nullptr) {
  const MassPoints& points = solved.network.points();
  const Topology topology = solved.network.topology();
  std::vector<double> given;
  std::vector<double> force;
  for (std::size_t i = 0; i < points.points(); ++i) {
    const auto n = static_cast<double>(topology.node_number[topology.node[i]]);
    const auto along = [&](const Place& vector, const Place& axis) {
      const Place v = turn(vector);
      return v.x * axis.x + v.y * axis.y + v.z * axis.z;
    };
    given.push_back(along({1e-3 * std::sin(n), 1e-3 * std::cos(2.0 * n), 2e-4 * n}, points.axis(i)) +
                    along({2e-2 * std::cos(n), 1e-2 * std::sin(3.0 * n), 1e-3 * n}, points.turning(i)));
    force.push_back(along({100.0 * std::cos(n), 30.0, 50.0 * std::sin(3.0 * n)}, points.axis(i)) +
                    along({10.0 * std::sin(n), 5.0, 4.0 * std::cos(n)}, points.turning(i)));
    given.back() = points.fixed(i) ? 0.0 : given.back();
  }
  std::vector<double> stretch(points.points());
  std::vector<double> internal(2 * points.points());
  solved.line->solve(given, loaded ? std::span<const double>{force} : std::span<const double>{}, stretch, internal);
  if (fields != nullptr) {
    const FilterOperator& frame = solved.line->filter_operator();
    fields->assign(frame.internal_places() * frame.internal_fields().size(), 0.0);
    frame.internal_values(internal, *fields);
  }
  return vectors(solved.network, stretch, internal);
}

void expect_near(const std::vector<double>& found, const std::vector<double>& expected, double tolerance) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t kind = 0; kind < 4; ++kind) {
    double size = 0.0;
    double wrong = 0.0;
    for (std::size_t i = 0; i < found.size(); ++i) {
      if (i % 12 / 3 == kind) {
        size = std::max(size, std::abs(expected[i]));
        wrong = std::max(wrong, std::abs(found[i] - expected[i]));
      }
    }
    EXPECT_LE(wrong, tolerance * size) << "kind " << kind << ", of " << size;
  }
}

/// A house of all that there is, held and sprung in rotations, too.
NetworkParameters held_house(const Turn& turn = kTilt) {
  NetworkParameters house = rotary(small_house(turn));
  house.junctions[0].held = {true, true, true, true, false, true};
  house.junctions[3].stiffness = {1e5, 0.0, 2e5, 0.0, 3e4, 0.0};
  house.junctions[6].held = {false, false, false, false, true, false};
  house.members[4].ends[0].joint = {3e5, MemberEnd::kRigid, MemberEnd::kRigid};
  house.members[5].ends[0].joint[0] = 0.0;
  house.members[6].ends[0].joint[0] = 0.0;  // between two hinges of torsion
  house.members[6].ends[1].joint[0] = 0.0;
  house.members[8].ends[1].joint[0] = 0.0;
  return house;
}

/// A shaft; frequencies of the lumped model are known in closed form. Source: Przemieniecki, Theory of Matrix
/// Structural Analysis, ch. 12.
TEST(RotaryInertia, GivesTheTorsionalFrequenciesOfAShaft) {
  const MemberSection steel = steel_section();
  const double speed = std::sqrt(steel.torsion() / steel.polar());
  constexpr double kLength = 4.0;
  for (const bool clamped : {true, false}) {
    for (const std::size_t elements : {6U, 48U}) {
      NetworkParameters beam = rotary(turned_beam(kLength, elements, kTilt));
      beam.junctions[0].held.fill(clamped);
      // On three ranks there are three junctions.
      beam.junctions.push_back({.name = "aside", .place = {.x = -5.0}});
      beam.junctions.push_back({.name = "there", .place = {.x = -5.0, .y = 1.0}});
      beam.members.push_back(test::member_between(2, 3, 2));
      Solved solved{beam, false};
      const MassPoints& points = solved.network.points();
      const auto n = static_cast<double>(elements);
      const Place axis = kTilt({.x = 1.0});
      for (std::size_t k = 1; k <= 3; ++k) {
        const double share = (clamped ? static_cast<double>(k) - 0.5 : static_cast<double>(k)) * std::numbers::pi;
        std::vector<double> shape(points.points(), 0.0);
        std::vector<double> stretch(points.points());
        for (std::size_t i = 0; i < shape.size(); ++i) {
          const Place at = points.place(i);
          const Place about = points.turning(i);
          const double sense = about.x * axis.x + about.y * axis.y + about.z * axis.z;
          if (std::abs(std::abs(sense) - 1.0) < 1e-9) {
            const double s = std::hypot(at.x, at.y, at.z) / kLength;
            shape[i] = at.x < -4.0 ? 0.0 : sense * (clamped ? std::sin(share * s) : std::cos(share * s));
          }
        }
        solved.line->solve(shape, {}, stretch, {});
        const double lumped = 2.0 * n * speed / kLength * std::sin(0.5 * share / n);
        const double filtered = kFilter * kFilter * lumped * lumped / (kFilter * kFilter + lumped * lumped);
        for (std::size_t i = 0; i < shape.size(); ++i) {
          EXPECT_NEAR(-kFilter * kFilter * stretch[i], filtered * shape[i], 1e-11 * kFilter * kFilter)
              << elements << " elements, mode " << k << ", point " << i;
        }
        // The second order of linear elements.
        const double exact = share * speed / kLength;
        EXPECT_NEAR(lumped / exact, 1.0 - std::pow(share / n, 2) / 24.0, std::pow(share / n, 4) / 1900.0);
      }
    }
  }
}

TEST(RotaryInertia, ModesOfAShaftBeginWithTorsion) {
  const MemberSection steel = steel_section();
  NetworkParameters beam = rotary(turned_beam(4.0, 32, kTilt));
  beam.junctions[0].held.fill(true);
  beam.junctions.insert(beam.junctions.begin() + 1, {.name = "middle", .place = kTilt({.x = 2.0})});
  beam.members = {test::member_between(0, 1, 16), test::member_between(1, 2, 16)};
  Solved solved{beam, false};
  const std::vector<Mode> modes = lowest_modes(*solved.line, 12);
  const double c = std::sqrt(steel.torsion() / steel.polar());
  const double lumped = 64.0 * c / 4.0 * std::sin(std::numbers::pi / 128.0);
  EXPECT_TRUE(
      std::ranges::any_of(modes, [&](const Mode& mode) { return std::abs(mode.frequency - lumped) < 1e-7 * lumped; }))
      << "none of them near " << lumped;
}

TEST(RotaryInertia, CondensedMembersAreTheAssembledFrame) {
  std::vector<std::pair<std::string, NetworkParameters>> all{{"house", rotary(small_house(kTilt))},
                                                             {"held", held_house()}};
  NetworkParameters uneven = held_house();
  for (Member& member : uneven.members) {
    if (member.elements > 1) {
      member.elements = member.elements == 4 ? 40 : 5;
      member.spacing = jagged_spacing(member.elements);
    }
  }
  all.emplace_back("unequal elements, cut", uneven);
  NetworkParameters lengthy = held_house();
  for (Member& member : lengthy.members) {
    member.elements = member.elements > 1 ? 40 : 1;
  }
  all.emplace_back("cut", lengthy);
  for (const auto& [name, given] : all) {
    SCOPED_TRACE(name);
    Solved condensed{given, false};
    Solved assembled{given, true};
    for (const bool loaded : {false, true}) {
      std::vector<double> forces;
      std::vector<double> found;
      const std::vector<double> expected = answer_by_node(assembled, kTilt, loaded, &forces);
      // Of the assembled frame (w_max / wf)^2 eps, w_max of its shortest element.
      const double tolerance = given.members[0].elements == 4 ? 1e-12 : 1e-10;
      expect_near(answer_by_node(condensed, kTilt, loaded, &found), expected, tolerance);
      const std::size_t places = condensed.line->filter_operator().internal_places();
      for (std::size_t field = 0; field * places < forces.size(); ++field) {
        double size = 0.0;
        double wrong = 0.0;
        for (std::size_t i = field * places; i < (field + 1) * places; ++i) {
          size = std::max(size, std::abs(forces[i]));
          wrong = std::max(wrong, std::abs(forces[i] - found[i]));
        }
        EXPECT_LE(wrong, 100.0 * tolerance * size) << "field " << field;  // differences of displacements
      }
    }
  }
}

TEST(RotaryInertia, RigidMotionsAreFreeOfStrainAndCarryTheirEnergy) {
  const NetworkParameters house = rotary(small_house(kTilt));
  const Place turn{.x = 0.3, .y = -0.2, .z = 0.5};
  for (const bool assembled : {false, true}) {
    Solved solved{house, assembled};
    const MassPoints& points = solved.network.points();
    std::vector<double> motion = rigid(points, {.x = 1.0, .y = 2.0, .z = -1.0}, turn);
    std::vector<double> stretch(motion.size());
    std::vector<double> internal(2 * motion.size());
    solved.line->solve(motion, {}, stretch, internal);
    for (const double away : stretch) {
      EXPECT_NEAR(away, 0.0, assembled ? 1e-12 : 1e-13);  // of displacements of metres
    }
  }
  // J w^2 / 2 of each half element about its member's axis besides that of the masses.
  Solved solved{house, false};
  const MassPoints& points = solved.network.points();
  const MassState state = initial_masses(points, {.spin = turn});
  double energy = 0.0;
  for (std::size_t i = 0; i < points.points(); ++i) {
    energy +=
        points.direction(i) == Direction::other ? 0.5 * points.mass()[i] * state.velocity[i] * state.velocity[i] : 0.0;
  }
  MPI_Allreduce(MPI_IN_PLACE, &energy, 1, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
  double expected = 0.0;
  for (std::size_t m = 0; m < house.members.size(); ++m) {
    const MemberKind& kind = solved.network.kinds()[solved.network.kind(m)];
    const std::array<double, 3>& axis = solved.network.axes(m)[0];
    const double own = axis[0] * turn.x + axis[1] * turn.y + axis[2] * turn.z;
    expected += 0.5 * house.sections[kind.section].polar() * kind.element_length * static_cast<double>(kind.elements) *
                own * own;
  }
  EXPECT_NEAR(energy, expected, 1e-12 * expected);
}

/// What filter springs do to the masses has neither force nor moment about the origin where nothing holds.
TEST(RotaryInertia, SpringsDoNotTurnTheWhole) {
  Solved solved{rotary(small_house(kTilt)), false};
  const MassPoints& points = solved.network.points();
  std::vector<double> given;
  for (std::size_t i = 0; i < points.points(); ++i) {
    const auto n = static_cast<double>(points.number(i));
    given.push_back((points.direction(i) == Direction::other ? 1e-2 : 1e-3) * std::sin(2.3 * n));
  }
  std::vector<double> stretch(given.size());
  solved.line->solve(given, {}, stretch, {});
  std::vector<double> sums(7, 0.0);
  for (std::size_t i = 0; i < given.size(); ++i) {
    const double pull = points.mass()[i] * stretch[i];
    const Place at = points.place(i);
    const auto [x, y, z] = points.axis(i);
    const Place about = points.turning(i);
    const std::array<double, 6> share{
        x, y, z, at.y * z - at.z * y + about.x, at.z * x - at.x * z + about.y, at.x * y - at.y * x + about.z};
    for (std::size_t k = 0; k < 6; ++k) {
      sums[k] += pull * share.at(k);
    }
    sums[6] += std::abs(pull);
  }
  add_up(sums);
  for (std::size_t k = 0; k < 6; ++k) {
    EXPECT_NEAR(sums[k], 0.0, 1e-12 * sums[6]) << k;
  }
}

TEST(RotaryInertia, TurnedCopyGivesTheTurnedAnswer) {
  const auto turned_back = [](std::vector<double> values, const Turn& turn) {
    const std::array axes{turn({.x = 1.0}), turn({.y = 1.0}), turn({.z = 1.0})};
    for (std::size_t i = 0; i < values.size(); i += 3) {
      const std::array given{values[i], values[i + 1], values[i + 2]};
      for (std::size_t k = 0; k < 3; ++k) {
        values[i + k] = axes[k].x * given[0] + axes[k].y * given[1] + axes[k].z * given[2];
      }
    }
    return values;
  };
  Solved plain{rotary(small_house()), false};
  Solved turned{rotary(small_house(kTilt)), false};
  const std::vector<double> expected = answer_by_node(plain, {}, true);
  expect_near(turned_back(answer_by_node(turned, kTilt, true), kTilt), expected, 1e-11);
}

TEST(RotaryInertia, GivesTheSameOnAnyRanks) {
  NetworkParameters house = held_house();
  for (Member& member : house.members) {
    member.elements = member.elements > 2 ? 24 : member.elements;
  }
  Solved dealt{house, false};
  std::vector<double> alone(12 * dealt.network.total_nodes(), 0.0);
  if (test::world_rank() == 0) {
    Solved single{house, false, PETSC_COMM_SELF};
    // Sums over the world: other ranks add nothing.
    alone = answer_by_node(single, kTilt, true);
  } else {
    add_up(alone);
  }
  expect_near(answer_by_node(dealt, kTilt, true), alone, 1e-12);
}

TEST(RotaryInertia, OfOneMemberAtAJunctionHasOneAxisAndOfSeveralMore) {
  const Network network{PETSC_COMM_WORLD, held_house()};
  EXPECT_EQ(network.rotations(0).count, 1U);  // about y alone, the others are held
  EXPECT_EQ(network.rotations(5).count, 3U);
  NetworkParameters angle = rotary(turned_beam(2.0, 4));
  angle.junctions.push_back({.name = "corner", .place = {.x = 2.0, .z = 1.5}});
  angle.members.push_back(test::member_between(1, 2, 3));
  const Network corner{PETSC_COMM_WORLD, angle};
  EXPECT_EQ(corner.rotations(0).count, 1U);
  EXPECT_EQ(corner.rotations(1).count, 2U);
  EXPECT_TRUE(corner.rotation_springs().empty());
  PetscInt all = 0;
  const auto own = static_cast<PetscInt>(corner.turning_points());
  MPI_Allreduce(&own, &all, 1, MPIU_INT, MPI_SUM, PETSC_COMM_WORLD);
  EXPECT_EQ(all, 1 + 2 + 1 + 3 + 2);
}

}  // namespace
}  // namespace udar
