// ranks: 1 2 3 4; size: medium
/// @file
/// Member condensation against an assembled frame in 113 bits, against the chain, on several ranks, and as a PETSc
/// type.

#include "udar/filter/network_solver.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

#include "support/quad_frame.hpp"
#include "support/small_frame.hpp"
#include "support/steel_beam.hpp"
#include "support/world.hpp"
#include "udar/filter/filtered_structure.hpp"
#include "udar/filter/pc_network.hpp"
#include "udar/petsc/array.hpp"
#include "udar/petsc/error.hpp"
#include "udar/structure/member_shape.hpp"

namespace udar {
namespace {

using test::jagged_spacing;
using test::junction_at;
using test::member_between;
using test::small_house;
using test::steel_section;
using test::Turn;
using test::world_rank;

constexpr Turn kTurn{.about_z = 0.3, .about_x = 0.7};

/// Members along the edges of cubes of 1 m, turned.
NetworkParameters lattice(const std::array<std::size_t, 3>& count, std::size_t elements) {
  NetworkParameters made{.sections = {steel_section()}, .junctions = {}, .members = {}};
  const auto at = [&](std::size_t i, std::size_t j, std::size_t k) { return (k * count[1] + j) * count[0] + i; };
  for (std::size_t k = 0; k < count[2]; ++k) {
    for (std::size_t j = 0; j < count[1]; ++j) {
      for (std::size_t i = 0; i < count[0]; ++i) {
        made.junctions.push_back(
            junction_at(kTurn({static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)})));
        for (const auto& [a, b, c] : {std::array{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}) {
          const std::size_t x = i + static_cast<std::size_t>(a);
          const std::size_t y = j + static_cast<std::size_t>(b);
          const std::size_t z = k + static_cast<std::size_t>(c);
          if (x < count[0] && y < count[1] && z < count[2]) {
            made.members.push_back(member_between(at(i, j, k), at(x, y, z), elements));
          }
        }
      }
    }
  }
  return made;
}

/// Of each node three numbers, whichever ranks have its points.
struct NodeMotion {
  std::vector<double> displacement;
  std::vector<double> force;
};

/// Places of all nodes in the order of their numbers.
std::vector<Place> places_of(const NetworkParameters& given) {
  std::vector<Place> places;
  places.reserve(given.junctions.size());
  for (const Junction& junction : given.junctions) {
    places.push_back(junction.place);
  }
  for (const Member& member : given.members) {
    const Place& a = given.junctions[member.ends[0].junction].place;
    const Place& b = given.junctions[member.ends[1].junction].place;
    const std::vector<double> equal(member.elements, 1.0);
    const std::vector<double>& spacing = member.spacing.empty() ? equal : member.spacing;
    const double whole = std::accumulate(spacing.begin(), spacing.end(), 0.0);
    double s = 0.0;
    for (std::size_t i = 1; i < member.elements; ++i) {
      s += spacing[i - 1] / whole;
      places.push_back({a.x + s * (b.x - a.x), a.y + s * (b.y - a.y), a.z + s * (b.z - a.z)});
    }
  }
  return places;
}

/// Smooth, of a millimetre, far away and turned by .4 rad besides.
NodeMotion smooth_motion(const NetworkParameters& given, bool far, double force) {
  NodeMotion motion;
  for (const Place& p : places_of(given)) {
    motion.displacement.push_back(1e-3 * std::sin(1.3 * p.x + 2.0 * p.y + 0.5 * p.z) + (far ? 1.0 - 0.4 * p.y : 0.0));
    motion.displacement.push_back(1e-3 * std::cos(2.1 * p.x - p.y + 1.5 * p.z) + (far ? 1.0 + 0.4 * p.x : 0.0));
    motion.displacement.push_back(1e-3 * std::sin(0.7 * p.x + 1.7 * p.y - 2.2 * p.z) + (far ? 1.0 : 0.0));
    motion.force.insert(motion.force.end(), {0.3 * force, -force, force * std::sin(p.x)});
  }
  return motion;
}

/// This rank's points of values by node.
std::vector<double> dealt(const Network& network, const std::vector<double>& values) {
  std::vector<double> local;
  local.reserve(network.points().points());
  for (std::size_t point = 0; point < network.points().points(); ++point) {
    local.push_back(values[static_cast<std::size_t>(network.points().number(point))]);
  }
  return local;
}

struct Answer {
  std::vector<double> stretch;  // by node, on every rank
  std::vector<double> rotation;
};

/// @param columns how often the same is solved for at once
Answer solved(const Network& network, double wf, const NodeMotion& motion, std::size_t columns = 1) {
  NetworkSolver solver{network, wf};
  const std::vector<double> displacement = dealt(network, motion.displacement);
  const std::vector<double> force = dealt(network, motion.force);
  const std::size_t points = displacement.size();
  std::vector<std::vector<double>> stretch(columns, std::vector<double>(points));
  std::vector<std::vector<double>> internal(columns, std::vector<double>(2 * points));
  std::vector<FilterColumn> all;
  all.reserve(columns);
  for (std::size_t c = 0; c < columns; ++c) {
    all.push_back({.displacement = displacement.data(),
                   .force = force.data(),
                   .stretch = stretch[c].data(),
                   .internal = internal[c].data()});
  }
  solver.solve(all);
  Answer answer{std::vector<double>(motion.force.size(), 0.0), std::vector<double>(motion.force.size(), 0.0)};
  for (std::size_t point = 0; point < points; ++point) {
    const auto number = static_cast<std::size_t>(network.points().number(point));
    answer.stretch[number] = stretch.back()[point];
    answer.rotation[number] = internal.back()[point];
  }
  for (std::vector<double>* values : {&answer.stretch, &answer.rotation}) {
    MPI_Allreduce(MPI_IN_PLACE, values->data(), static_cast<int>(values->size()), MPI_DOUBLE, MPI_SUM, network.comm());
  }
  return answer;
}

double largest(const std::vector<double>& values) {
  double most = 0.0;
  for (const double value : values) {
    most = std::max(most, std::abs(value));
  }
  return most;
}

double largest_difference(const std::vector<double>& one, const std::vector<double>& other) {
  double most = 0.0;
  for (std::size_t i = 0; i < one.size(); ++i) {
    most = std::max(most, std::abs(one[i] - other[i]));
  }
  return most;
}

/// @param tolerance of the largest stretch
void expect_exact(const NetworkParameters& given, double wf, bool far, double force, double tolerance) {
  const Network alone{PETSC_COMM_SELF, given};
  const NodeMotion motion = smooth_motion(given, far, force);
  const std::vector<double> both = test::quad_stretch(alone, wf, motion.displacement, motion.force);
  std::vector<double> stretch;
  std::vector<double> rotation;
  for (std::size_t i = 0; i < both.size(); ++i) {
    (i % 6 < 3 ? stretch : rotation).push_back(both[i]);
  }
  const Answer answer = solved(Network{PETSC_COMM_WORLD, given}, wf, motion);
  EXPECT_LE(largest_difference(answer.stretch, stretch), tolerance * largest(stretch));
  // Rotations are displacements over an element, which are known to half a unit in the last place.
  double shortest = 1.0;
  for (const MemberKind& kind : alone.kinds()) {
    shortest = std::min(shortest, kind.shortest());
  }
  constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
  EXPECT_LE(largest_difference(answer.rotation, rotation),
            tolerance * largest(rotation) + 2.0 * kEpsilon / shortest * largest(motion.displacement));
}

TEST(NetworkSolver, IsExactWhateverTheMeshAndFilter) {
  for (const std::size_t elements : {1U, 2U, 4U, 16U, 64U, 256U}) {
    const NetworkParameters cube = lattice({2, 2, 2}, elements);
    for (const bool far : {false, true}) {
      SCOPED_TRACE(std::to_string(elements) + " elements" + (far ? ", far" : ""));
      // kappa of the junctions' system: 12 (ell/L)^4 and more
      expect_exact(cube, 30.0, far, 0.0, 1e-10);
      expect_exact(cube, 300.0, far, 0.0, 1e-12);
      expect_exact(cube, 3000.0, far, 0.0, far ? 2e-13 : 1e-14);
    }
  }
}

TEST(NetworkSolver, TakesJointsArmsSpringsMassesAndLoads) {
  NetworkParameters house = small_house(kTurn);
  house.junctions[0].held = {true, true, true, false, true, false};
  house.junctions[3].stiffness = {1e5, 0.0, 2e5, 0.0, 3e4, 0.0};
  expect_exact(house, 300.0, false, 50.0, 1e-12);
  NetworkParameters net = lattice({3, 3, 2}, 3);
  constexpr double kRigid = MemberEnd::kRigid;
  for (std::size_t m = 0; m < net.members.size(); ++m) {
    Member& member = net.members[m];
    member.elements = 1 + m % 4;
    if (m % 5 == 0) {
      member.ends[0].joint = {kRigid, kRigid, 0.0};
    } else if (m % 5 == 1) {
      member.ends[1].joint = {kRigid, 0.0, 0.0};
    } else if (m % 5 == 2) {
      member.ends[0].joint = {1e4, 2e5, 3e4};
    } else if (m % 5 == 3) {
      member.ends[0].joint = {kRigid, 0.0, kRigid};
      member.ends[1].joint = {kRigid, 1e5, 2e4};
    }
  }
  for (const bool far : {false, true}) {
    expect_exact(net, 300.0, far, 50.0, 1e-12);
  }
}

/// Graded by 1 to 4 and 30 to 1, and jagged, beside equal ones.
TEST(NetworkSolver, IsExactWithUnequalElements) {
  for (const std::size_t elements : {2U, 3U, 16U, 64U, 256U}) {
    NetworkParameters cube = lattice({2, 2, 2}, elements);
    for (std::size_t m = 0; m < cube.members.size(); ++m) {
      cube.members[m].spacing = m % 4 == 0   ? std::vector<double>{}
                                : m % 4 == 1 ? graded_spacing(elements, 4.0)
                                : m % 4 == 2 ? graded_spacing(elements, 1.0 / 30.0)
                                             : jagged_spacing(elements);
    }
    EXPECT_EQ(Network(PETSC_COMM_SELF, cube).kinds().size(), 4U);
    for (const bool far : {false, true}) {
      SCOPED_TRACE(std::to_string(elements) + " elements" + (far ? ", far" : ""));
      expect_exact(cube, 30.0, far, 0.0, 1e-10);
      expect_exact(cube, 300.0, far, 1.0, 1e-12);
      expect_exact(cube, 3000.0, far, 0.0, far ? 2e-13 : 1e-14);
    }
  }
}

/// The small house with jagged members, and whatever there is at its junctions.
NetworkParameters jagged_house() {
  NetworkParameters house = small_house(kTurn);
  house.junctions[0].held = {true, false, true, false, true, false};
  house.junctions[3].stiffness = {1e5, 0.0, 2e5, 0.0, 3e4, 0.0};
  for (Member& member : house.members) {
    member.elements += 2;
    member.spacing = jagged_spacing(member.elements);
  }
  return house;
}

TEST(NetworkSolver, TakesJointsAndArmsWithUnequalElements) {
  for (const bool far : {false, true}) {
    expect_exact(jagged_house(), 300.0, far, 50.0, 1e-12);
  }
}

/// Members that are cut into spans, equal ones and a shorter last one, with everything at their ends and forces within;
/// spans much shorter than forces reach.
TEST(NetworkSolver, CutsLongMembersWithoutLosingDigits) {
  for (const bool far : {false, true}) {
    SCOPED_TRACE(far ? "far" : "near");
    expect_exact(lattice({2, 2, 2}, 1024), 300.0, far, 1.0, 1e-12);
    NetworkParameters house = small_house(kTurn);
    house.junctions[0].held = {true, true, true, false, true, false};
    for (Member& member : house.members) {
      member.elements *= 41;
    }
    const Network network{PETSC_COMM_SELF, house};
    for (std::size_t kind = 0; kind < network.kinds().size(); ++kind) {
      EXPECT_EQ(network.packs().cut(kind).spans > 1, network.kinds()[kind].elements > 60) << kind;
    }
    EXPECT_EQ(network.packs().cut_nodes(), 15U);
    expect_exact(house, 300.0, far, 50.0, 1e-12);
  }
}

/// Each unlike all others, so that its spans have tables of their own.
TEST(NetworkSolver, CutsMembersOfUnequalElementsWithoutLosingDigits) {
  NetworkParameters cube = lattice({2, 2, 2}, 300);
  for (std::size_t m = 0; m < cube.members.size(); ++m) {
    cube.members[m].spacing = graded_spacing(300, 0.2 + static_cast<double>(m));
  }
  NetworkParameters house = jagged_house();
  for (Member& member : house.members) {
    member.elements = 41 * member.elements + 3;
    member.spacing = jagged_spacing(member.elements);
  }
  for (const bool far : {false, true}) {
    SCOPED_TRACE(far ? "far" : "near");
    expect_exact(cube, 300.0, far, 1.0, 1e-12);
    expect_exact(house, 300.0, far, 1.0, 1e-12);
  }
  const Network network{PETSC_COMM_SELF, cube};
  for (std::size_t kind = 0; kind < network.kinds().size(); ++kind) {
    EXPECT_EQ(network.packs().cut(kind).spans, 9U) << kind;
  }
  EXPECT_GT(Network(PETSC_COMM_SELF, house).packs().cut_nodes(), 0U);
}

/// Members along one line: their rotation about it is nobody's.
TEST(NetworkSolver, CarriesCollinearMembersThatAreFree) {
  NetworkParameters line{.sections = {steel_section()}, .junctions = {}, .members = {}};
  for (std::size_t j = 0; j < 6; ++j) {
    line.junctions.push_back(junction_at(kTurn({1.5 * static_cast<double>(j), 0.0, 0.0})));
    if (j > 0) {
      line.members.push_back(member_between(j - 1, j, 16));
    }
  }
  expect_exact(line, 300.0, false, 10.0, 1e-12);
}

TEST(NetworkSolver, LeavesATranslationAlone) {
  NetworkParameters net = lattice({3, 2, 2}, 7);
  net.members[2].spacing = jagged_spacing(7);
  NodeMotion motion = smooth_motion(net, false, 0.0);
  for (std::size_t i = 0; i < motion.displacement.size(); ++i) {
    motion.displacement[i] = std::array{1.1, -0.7, 3.3}.at(i % 3);
  }
  const Answer answer = solved(Network{PETSC_COMM_WORLD, net}, 100.0, motion);
  EXPECT_EQ(largest(answer.stretch), 0.0);
  EXPECT_EQ(largest(answer.rotation), 0.0);
}

TEST(NetworkSolver, IsTheSameOnAnyRanksAndForAnyColumns) {
  const NetworkParameters net = lattice({4, 3, 3}, 5);
  const NodeMotion motion = smooth_motion(net, false, 20.0);
  const Answer alone = solved(Network{PETSC_COMM_SELF, net}, 300.0, motion);
  const Network network{PETSC_COMM_WORLD, net};
  for (const std::size_t columns : {1U, 2U, 3U, 4U, 7U}) {
    const Answer together = solved(network, 300.0, motion, columns);
    EXPECT_LE(largest_difference(together.stretch, alone.stretch), 1e-12 * largest(alone.stretch)) << columns;
    EXPECT_LE(largest_difference(together.rotation, alone.rotation), 1e-15) << columns;
  }
}

/// One member along x is the chain, which knows y alone.
TEST(NetworkSolver, OfOneMemberIsTheChain) {
  const NetworkParameters given = test::turned_beam(10.0, 160, {}, test::round_section());
  const BeamChain beam{PETSC_COMM_SELF, test::steel_beam(160)};
  FilteredStructure chain{beam, {.filter_frequency = 100.0}};
  const Network network{PETSC_COMM_SELF, given};
  FilteredStructure line{network, {.filter_frequency = 100.0, .check_interval = 1}};
  ASSERT_NE(line.network(), nullptr);
  const std::vector<Place> places = places_of(given);
  std::vector<double> displacement(beam.points().points());
  const auto shape = [](double x) { return 0.01 * std::sin(0.9 * x) + 0.02 * x; };
  for (std::size_t i = 0; i < displacement.size(); ++i) {
    displacement[i] = shape(beam.points().place(i).x);
  }
  std::vector<double> expected(displacement.size());
  chain.solve(displacement, {}, expected, {});
  std::vector<double> by_node(3 * places.size(), 0.0);
  for (std::size_t i = 0; i < places.size(); ++i) {
    by_node[3 * i + 1] = shape(places[i].x);
  }
  const std::vector<double> local = dealt(network, by_node);
  std::vector<double> stretch(local.size());
  line.solve(local, {}, stretch, {});
  double most = largest(expected);
  for (std::size_t point = 0; point < stretch.size(); ++point) {
    const auto number = static_cast<std::size_t>(network.points().number(point));
    const auto node = static_cast<std::size_t>(std::lround(16.0 * places[number / 3].x));
    EXPECT_NEAR(stretch[point], number % 3 == 1 ? expected[node] : 0.0, 1e-12 * most) << number;
  }
}

/// Of unequal elements it is the chain with a segment for each.
TEST(NetworkSolver, OfOneGradedMemberIsTheChainOfItsElements) {
  constexpr std::size_t kElements = 48;
  constexpr double kLength = 10.0;
  NetworkParameters given = test::turned_beam(kLength, kElements, {}, test::round_section());
  given.members[0].spacing = graded_spacing(kElements, 5.0);
  const Network network{PETSC_COMM_SELF, given};
  BeamParameters segments = test::steel_beam(1);
  for (const double length : network.kinds()[0].lengths) {
    segments.segments.push_back(segments.segments.front());
    segments.segments.back().length = length;
  }
  segments.segments.erase(segments.segments.begin());
  const BeamChain beam{PETSC_COMM_SELF, segments};
  FilteredStructure chain{beam, {.filter_frequency = 100.0}};
  FilteredStructure line{network, {.filter_frequency = 100.0, .check_interval = 1}};
  std::vector<double> displacement(kElements + 1);
  std::vector<double> force(kElements + 1);
  for (std::size_t i = 0; i < displacement.size(); ++i) {
    const double x = beam.points().place(i).x;
    displacement[i] = 0.01 * std::sin(0.9 * x) + 0.02 * x;
    force[i] = 300.0 * std::cos(0.4 * x);
  }
  std::vector<double> expected(displacement.size());
  chain.solve(displacement, force, expected, {});
  std::vector<double> by_node(3 * displacement.size(), 0.0);
  std::vector<double> force_by_node(by_node.size(), 0.0);
  const auto node_of = [](std::size_t number) {  // junctions come first
    return number == 0 ? 0 : number == 1 ? kElements : number - 1;
  };
  for (std::size_t number = 0; number < displacement.size(); ++number) {
    by_node[3 * number + 1] = displacement[node_of(number)];
    force_by_node[3 * number + 1] = force[node_of(number)];
  }
  std::vector<double> stretch(by_node.size());
  line.solve(dealt(network, by_node), dealt(network, force_by_node), stretch, {});
  for (std::size_t point = 0; point < stretch.size(); ++point) {
    const auto number = static_cast<std::size_t>(network.points().number(point));
    const std::size_t node = node_of(number / 3);
    EXPECT_NEAR(network.points().place(point).x, beam.points().place(node).x, 1e-14 * kLength);
    EXPECT_NEAR(network.points().mass()[point], beam.points().mass()[node], 1e-13 * beam.points().mass()[node]);
    EXPECT_NEAR(stretch[point], number % 3 == 1 ? expected[node] : 0.0, 1e-12 * largest(expected)) << number;
  }
}

/// As a preconditioner it is the inverse of the assembled frame, whatever the right-hand side, moments included.
void expect_inverse(const NetworkParameters& house) {
  const Network network{PETSC_COMM_WORLD, house};
  NetworkOperator frame{network, 300.0};
  petsc::LinearSolver solver;
  ASSERT_EQ(register_pc_network(), 0);
  UDAR_CALL(KSPCreate(PETSC_COMM_WORLD, solver.put()));
  UDAR_CALL(KSPSetOperators(solver, frame.op(), frame.op()));
  UDAR_CALL(KSPSetType(solver, KSPPREONLY));
  PC preconditioner = nullptr;
  UDAR_CALL(KSPGetPC(solver, &preconditioner));
  UDAR_CALL(PCSetType(preconditioner, kPcNetwork));
  petsc::Vector right;
  petsc::Vector solution;
  petsc::Vector residual;
  UDAR_CALL(MatCreateVecs(frame.op(), right.put(), solution.put()));
  UDAR_CALL(VecDuplicate(right, residual.put()));
  {
    const petsc::WriteArray values{right};
    for (std::size_t i = 0; i < frame.unknowns(); ++i) {
      values.values()[i] = std::sin(3.0 * static_cast<double>(i) + static_cast<double>(world_rank()));
    }
  }
  UDAR_CALL(KSPSolve(solver, right, solution));
  UDAR_CALL(MatMult(frame.matrix(), solution, residual));
  UDAR_CALL(VecAXPY(residual, -1.0, right));
  double wrong = 0.0;
  double size = 0.0;
  UDAR_CALL(VecNorm(residual, NORM_INFINITY, &wrong));
  UDAR_CALL(VecNorm(solution, NORM_INFINITY, &size));
  EXPECT_GT(size, 0.0);
  EXPECT_LE(wrong, 1e-12 * frame.norm() * size);
}

TEST(NetworkSolver, InvertsTheAssembledFrame) {
  NetworkParameters house = small_house(kTurn);
  house.junctions[0].held = {true, false, true, false, true, false};
  house.junctions[3].stiffness = {1e5, 0.0, 2e5, 0.0, 3e4, 0.0};
  expect_inverse(house);
  expect_inverse(jagged_house());
}

/// The product by elements is that of the assembled frame, of whatever there is; right-hand sides and a bound, too.
void expect_product(const NetworkParameters& house) {
  const Network network{PETSC_COMM_WORLD, house};
  NetworkOperator frame{network, 300.0};
  petsc::Vector given;
  petsc::Vector by_elements;
  petsc::Vector by_matrix;
  UDAR_CALL(MatCreateVecs(frame.op(), given.put(), by_elements.put()));
  UDAR_CALL(VecDuplicate(given, by_matrix.put()));
  double size = 0.0;
  double wrong = 0.0;
  const auto difference = [&] {
    UDAR_CALL(VecNorm(by_matrix, NORM_INFINITY, &size));
    UDAR_CALL(VecAXPY(by_matrix, -1.0, by_elements));
    UDAR_CALL(VecNorm(by_matrix, NORM_INFINITY, &wrong));
  };
  {
    const petsc::WriteArray values{given};
    for (std::size_t i = 0; i < frame.unknowns(); ++i) {
      values.values()[i] = std::sin(3.0 * static_cast<double>(i) + static_cast<double>(world_rank()));
    }
  }
  UDAR_CALL(MatMult(frame.op(), given, by_elements));
  UDAR_CALL(MatMult(frame.matrix(), given, by_matrix));
  difference();
  EXPECT_LE(wrong, 1e-14 * size);
  double exact = 0.0;
  UDAR_CALL(MatNorm(frame.matrix(), NORM_INFINITY, &exact));
  EXPECT_GE(frame.norm(), exact * (1.0 - 1e-14));
  EXPECT_LE(frame.norm(), 4.0 * exact);
  // wf^2 M u less the right-hand side of u is the product with u.
  const std::vector<double> displacement = dealt(network, smooth_motion(house, false, 0.0).displacement);
  {
    const petsc::WriteArray values{given};
    std::fill_n(values.values(), frame.unknowns(), 0.0);
    for (std::size_t i = 0; i < displacement.size(); ++i) {
      values.values()[i] = network.points().fixed(i) ? 0.0 : displacement[i] / frame.scale()[i];
    }
  }
  UDAR_CALL(MatMult(frame.matrix(), given, by_matrix));
  {
    const petsc::WriteArray values{by_elements};
    frame.right_hand_side({.displacement = displacement.data()}, {values.values(), frame.unknowns()});
    for (std::size_t i = 0; i < frame.unknowns(); ++i) {
      const bool point = i < displacement.size();
      const double ground =
          point && !network.points().fixed(i) ? 9e4 * frame.mass()[i] * frame.scale()[i] * displacement[i] : 0.0;
      values.values()[i] = ground - values.values()[i];
    }
  }
  difference();
  EXPECT_LE(wrong, 1e-13 * size);
}

TEST(NetworkOperator, IsTheAssembledFrame) {
  NetworkParameters house = small_house(kTurn);
  house.junctions[0].held = {true, false, true, false, true, false};
  house.junctions[3].stiffness = {1e5, 0.0, 2e5, 0.0, 3e4, 0.0};
  house.junctions[4].stiffness = {0.0, 3e6, 0.0, 1e4, 0.0, 0.0};
  expect_product(house);
  expect_product(jagged_house());
}

/// Energy and forces of a stretched and bent net, and what the filter's check says of it.
TEST(NetworkSolver, PassesTheResidualCheckAndTheBalanceOfForces) {
  NetworkParameters net = lattice({3, 3, 2}, 6);
  for (std::size_t m = 0; m < net.members.size(); m += 2) {
    net.members[m].spacing = graded_spacing(6, 3.0);
  }
  const Network network{PETSC_COMM_WORLD, net};
  FilteredStructure line{network, {.filter_frequency = 200.0, .check_interval = 1}};
  const NodeMotion motion = smooth_motion(net, false, 0.0);
  const std::vector<double> displacement = dealt(network, motion.displacement);
  std::vector<double> stretch(displacement.size());
  std::vector<double> internal(2 * displacement.size());
  line.solve(displacement, {}, stretch, internal);
  EXPECT_LT(line.worst_residual(), 1e-13);
  // Twice the energy is the work of the elastic forces -wf^2 m d along Yc.
  double work = 0.0;
  for (std::size_t i = 0; i < stretch.size(); ++i) {
    work -= 4e4 * line.mass()[i] * stretch[i] * (displacement[i] + stretch[i]);
  }
  double energy = line.filter_operator().strain_energy({}, internal);
  for (double* sum : {&work, &energy}) {
    MPI_Allreduce(MPI_IN_PLACE, sum, 1, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
  }
  EXPECT_GT(energy, 0.0);
  EXPECT_NEAR(2.0 * energy, work, 1e-11 * energy);
}

/// A clamped member under forces at its free end, on filter springs that carry 2e-5 of them.
TEST(NetworkSolver, GivesTheForcesOfMembers) {
  constexpr double kAlong = 700.0;
  constexpr double kUp = 40.0;
  constexpr double kAcross = 25.0;
  const double length = 2.0;
  NetworkParameters given = test::turned_beam(length, 5);
  given.junctions[0].held.fill(true);
  const Network network{PETSC_COMM_SELF, given};
  FilteredStructure line{network, {.filter_frequency = 0.5, .check_interval = 1}};
  std::vector<double> by_node(3 * network.total_nodes(), 0.0);
  by_node[3] = kAlong;  // at junction 1
  by_node[4] = kUp;
  by_node[5] = kAcross;
  const std::vector<double> force = dealt(network, by_node);
  const std::vector<double> still(force.size(), 0.0);
  std::vector<double> stretch(force.size());
  std::vector<double> internal(2 * force.size());
  line.solve(still, force, stretch, internal);
  const FilterOperator& filter = line.filter_operator();
  std::vector<double> values(filter.internal_fields().size() * force.size());
  filter.internal_values(internal, values);
  const auto field = [&](std::size_t number, std::size_t element) { return values[number * force.size() + element]; };
  constexpr double kSprings = 1e-4;  // what they carry, and more
  for (std::size_t element = 0; element < 5; ++element) {
    const double arm = length * (1.0 - static_cast<double>(element) / 5.0);  // of its first end
    EXPECT_NEAR(field(0, element), kAlong, kSprings * kAlong);
    EXPECT_NEAR(field(1, element), kUp, kSprings * kUp);
    EXPECT_NEAR(field(2, element), kAcross, kSprings * kAcross);
    EXPECT_NEAR(field(3, element), 0.0, 1e-9);
    EXPECT_NEAR(field(4, element), -kAcross * arm, kSprings * kAcross * arm);
    EXPECT_NEAR(field(5, element), kUp * arm, kSprings * kUp * arm);
  }
}

/// Eight junctions, each joined with each by one element: more elements than points.
TEST(NetworkSolver, ForcesOfManyShortMembersAreInEquilibrium) {
  constexpr std::size_t kJunctions = 8;
  NetworkParameters given{.sections = {steel_section()}, .junctions = {}, .members = {}};
  for (std::size_t i = 0; i < kJunctions; ++i) {
    const auto t = static_cast<double>(i);
    given.junctions.push_back(junction_at({.x = t, .y = t * t / 7.0, .z = t * t * t / 49.0}));  // no three in a line
    for (std::size_t j = 0; j < i; ++j) {
      given.members.push_back(member_between(j, i, 1));
    }
  }
  const Network network{PETSC_COMM_SELF, given};
  constexpr double kFrequency = 100.0;
  FilteredStructure line{network, {.filter_frequency = kFrequency, .check_interval = 1}};
  std::vector<double> force(3 * kJunctions);
  for (std::size_t i = 0; i < force.size(); ++i) {
    force[i] = 1e4 * std::cos(3.0 * static_cast<double>(i));
  }
  const std::vector<double> still(force.size(), 0.0);
  std::vector<double> stretch(force.size());
  std::vector<double> internal(2 * force.size());
  line.solve(still, force, stretch, internal);
  const FilterOperator& filter = line.filter_operator();
  const std::size_t places = filter.internal_places();
  ASSERT_EQ(places, given.members.size());
  ASSERT_GT(places, force.size());
  std::vector<double> values(filter.internal_fields().size() * places);
  filter.internal_values(internal, values);
  std::vector<double> rest(force.size());  // of the forces, less what springs and members take
  for (std::size_t point = 0; point < rest.size(); ++point) {
    rest[point] = force[point] - kFrequency * kFrequency * network.points().mass()[point] * stretch[point];
  }
  for (std::size_t cell = 0; cell < places; ++cell) {
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t end = 0; end < 2; ++end) {
        const Network::Node node = network.junction_node(given.members[cell].ends.at(end).junction);
        for (std::size_t axis = 0; axis < 3; ++axis) {
          rest[static_cast<std::size_t>(network.point(node, axis))] -=
              (end == 0 ? -1.0 : 1.0) * network.axes(cell).at(k).at(axis) * values[k * places + cell];
        }
      }
    }
  }
  for (const double left : rest) {
    EXPECT_NEAR(left, 0.0, 1e-9 * 1e4);  // of sums of seven members' forces, shear of 6 EI w / h^2 by cancellation
  }
}

}  // namespace
}  // namespace udar
