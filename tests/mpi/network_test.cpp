// ranks: 1 2 3; size: short
/// @file
/// Networks on several ranks: the same structure, its rigid motions, its turned copies.

#include "udar/structure/network.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "support/small_frame.hpp"
#include "support/steel_beam.hpp"
#include "support/world.hpp"
#include "udar/filter/filtered_structure.hpp"
#include "udar/petsc/array.hpp"
#include "udar/petsc/error.hpp"
#include "udar/structure/matrix_file.hpp"

namespace udar {
namespace {

using test::small_house;
using test::Turn;
using test::turned_beam;
using test::world_rank;
using test::world_size;

constexpr Turn kTurnedHouse{.about_z = 0.7, .about_x = -0.4};

/// Node and freedom of each of this rank's rows.
std::map<PetscInt, std::pair<std::int64_t, std::size_t>> meaning_of_rows(const Network& network) {
  std::map<PetscInt, std::pair<std::int64_t, std::size_t>> meaning;
  for (std::size_t local = 0; local < network.nodes(); ++local) {
    const Network::Node node{.rank = network.rank(), .local = local};
    for (std::size_t freedom = 0; freedom < 6; ++freedom) {
      // The node's number, from that of its point along y.
      const std::int64_t number = network.points().number(local);
      EXPECT_EQ(number % 3, 1);
      meaning[network.row(node, freedom)] = {number / 3, freedom};
    }
  }
  return meaning;
}

/// All entries by nodes and freedoms on rank 0, whichever ranks have them.
std::map<std::array<std::int64_t, 4>, double> entries_of(const Network& network) {
  const auto own = meaning_of_rows(network);
  const auto rows = 6 * network.total_nodes();
  std::vector<std::int64_t> meaning(rows, 0);
  for (const auto& [row, of] : own) {
    meaning[static_cast<std::size_t>(row)] = 6 * of.first + static_cast<std::int64_t>(of.second);
  }
  MPI_Allreduce(MPI_IN_PLACE, meaning.data(), static_cast<int>(rows), MPI_INT64_T, MPI_SUM, network.comm());
  std::map<std::array<std::int64_t, 4>, double> entries;
  for (const MatrixEntry& entry : gathered_entries(network.stiffness())) {
    const std::int64_t row = meaning[static_cast<std::size_t>(entry.row)];
    const std::int64_t column = meaning[static_cast<std::size_t>(entry.column)];
    entries[{row / 6, row % 6, column / 6, column % 6}] = entry.value;
  }
  return entries;
}

TEST(Network, HasTheSameStiffnessOnAnyRanks) {
  NetworkParameters house = small_house(kTurnedHouse);
  house.junctions[0].held = {true, true, true, false, true, false};
  house.junctions[3].stiffness = {1e5, 0.0, 2e5, 0.0, 3e4, 0.0};
  const Network dealt{PETSC_COMM_WORLD, house};
  const Network alone{PETSC_COMM_SELF, house};
  EXPECT_EQ(dealt.total_nodes(), alone.total_nodes());
  const auto expected = entries_of(alone);
  const auto found = entries_of(dealt);
  if (world_rank() == 0) {
    ASSERT_EQ(found.size(), expected.size());
    double largest = 0.0;
    for (const auto& [place, value] : expected) {
      largest = std::max(largest, std::abs(value));
    }
    for (const auto& [place, value] : expected) {
      ASSERT_TRUE(found.contains(place));
      EXPECT_NEAR(found.at(place), value, 1e-15 * largest);  // sums in another order
      const auto transposed = expected.find({place[2], place[3], place[0], place[1]});
      ASSERT_NE(transposed, expected.end());
      EXPECT_NEAR(transposed->second, value, 1e-15 * largest);
    }
  }
  Description first;
  Description second;
  dealt.describe(first);
  alone.describe(second);
  EXPECT_EQ(first.parameters(), second.parameters());
}

TEST(Network, DealsJunctionsAndMembers) {
  const Network network{PETSC_COMM_WORLD, small_house()};
  const NetworkParameters& house = network.parameters();
  std::vector<int> junctions(static_cast<std::size_t>(world_size()), 0);
  for (const int rank : network.junction_ranks()) {
    ++junctions.at(static_cast<std::size_t>(rank));
  }
  EXPECT_GT(std::ranges::min(junctions), 0);
  for (std::size_t member = 0; member < house.members.size(); ++member) {
    const int rank = network.member_ranks()[member];
    EXPECT_TRUE(rank == network.junction_ranks()[house.members[member].ends[0].junction] ||
                rank == network.junction_ranks()[house.members[member].ends[1].junction]);
  }
  std::vector<int> ranks = network.junction_ranks();
  ranks.insert(ranks.end(), network.member_ranks().begin(), network.member_ranks().end());
  std::vector<int> of_first = ranks;
  MPI_Bcast(of_first.data(), static_cast<int>(of_first.size()), MPI_INT, 0, PETSC_COMM_WORLD);
  EXPECT_EQ(ranks, of_first);
  EXPECT_EQ(network.points().total(), 3 * static_cast<PetscInt>(network.total_nodes()));
  // Each line of the picture joins two neighbours.
  const Topology topology = network.topology();
  PetscInt cells = topology.cells();
  MPI_Allreduce(MPI_IN_PLACE, &cells, 1, MPIU_INT, MPI_SUM, PETSC_COMM_WORLD);
  std::size_t elements = 0;
  for (const Member& member : house.members) {
    elements += member.elements;
  }
  EXPECT_EQ(cells, static_cast<PetscInt>(elements));
  for (const PetscInt corner : topology.corners) {
    EXPECT_TRUE(corner >= 0 && corner < static_cast<PetscInt>(network.total_nodes()));
  }
  // Its nodes are the three points at one place that move along three axes.
  ASSERT_EQ(topology.node.size(), network.points().points());
  ASSERT_EQ(topology.node_number.size(), network.nodes());
  for (std::size_t point = 0; point < topology.node.size(); ++point) {
    const Place axis = network.points().axis(point);
    const std::int64_t along = axis.x == 1.0 ? 0 : axis.y == 1.0 ? 1 : 2;
    EXPECT_EQ(network.points().number(point), 3 * topology.node_number[topology.node[point]] + along);
  }
  ASSERT_EQ(topology.member.size(), topology.radius.size());
  for (std::size_t cell = 0; cell < topology.member.size(); ++cell) {
    const Member& member = house.members.at(static_cast<std::size_t>(topology.member[cell]));
    EXPECT_EQ(topology.radius[cell], house.sections[member.section].tube_radius());
  }
}

/// A row of junctions in no order along it: METIS cuts it once between two ranks, their order often.
TEST(Network, DealsJunctionsByMetisOrInTheirOrder) {
  constexpr std::size_t kCount = 60;
  NetworkParameters row{.sections = {test::steel_section()}, .junctions = {}, .members = {}};
  const auto at = [](std::size_t place) { return 7 * place % kCount; };
  row.junctions.resize(kCount);
  for (std::size_t place = 0; place < kCount; ++place) {
    row.junctions[at(place)] = test::junction_at({.x = static_cast<double>(place)});
    if (place > 0) {
      row.members.push_back(test::member_between(at(place - 1), at(place), 3));
    }
  }
  const auto cut = [&row](NetworkPartition partition) {
    row.partition = partition;
    const Network network{PETSC_COMM_WORLD, row};
    const std::vector<int>& ranks = network.junction_ranks();
    for (int rank = 0; rank < world_size(); ++rank) {
      EXPECT_NEAR(static_cast<double>(std::ranges::count(ranks, rank)), 60.0 / world_size(), 3.0);
    }
    EXPECT_EQ(std::ranges::is_sorted(ranks), partition == NetworkPartition::contiguous || world_size() == 1);
    return std::ranges::count_if(row.members, [&ranks](const Member& member) {
      return ranks[member.ends[0].junction] != ranks[member.ends[1].junction];
    });
  };
  EXPECT_EQ(cut(NetworkPartition::metis), world_size() - 1);
  if (world_size() > 1) {
    EXPECT_GT(cut(NetworkPartition::contiguous), world_size());
  }
}

TEST(Network, RefusesMoreRanksThanJunctions) {
  if (world_size() == 3) {
    EXPECT_EQ(test::failure_of<InputError>([] { const Network network{PETSC_COMM_WORLD, turned_beam(1.0, 9)}; }),
              "network: 2 junctions are not allowed on 3 ranks, expected one a rank at least");
  }
}

/// No force in any rigid motion, whatever members, joints and arms there are.
TEST(Network, RigidMotionsCostNothing) {
  const Network network{PETSC_COMM_WORLD, small_house(kTurnedHouse)};
  petsc::Vector motion;
  petsc::Vector force;
  UDAR_CALL(MatCreateVecs(network.stiffness(), motion.put(), force.put()));
  double stiffest = 0.0;
  UDAR_CALL(MatNorm(network.stiffness(), NORM_INFINITY, &stiffest));
  for (std::size_t rigid = 0; rigid < 6; ++rigid) {
    std::array<double, 6> rate{};
    rate.at(rigid) = 1.0;
    {
      const petsc::WriteArray values{motion};
      PetscInt begin = 0;
      UDAR_CALL(VecGetOwnershipRange(motion, &begin, nullptr));
      for (std::size_t local = 0; local < network.nodes(); ++local) {
        const auto [x, y, z] = network.points().place(local);
        const std::array<double, 6> moved{rate[0] + rate[4] * z - rate[5] * y,
                                          rate[1] + rate[5] * x - rate[3] * z,
                                          rate[2] + rate[3] * y - rate[4] * x,
                                          rate[3],
                                          rate[4],
                                          rate[5]};
        for (std::size_t freedom = 0; freedom < 6; ++freedom) {
          values.values()[network.row({.rank = network.rank(), .local = local}, freedom) - begin] = moved.at(freedom);
        }
      }
    }
    UDAR_CALL(MatMult(network.stiffness(), motion, force));
    double largest = 0.0;
    UDAR_CALL(VecNorm(force, NORM_INFINITY, &largest));
    EXPECT_LT(largest, 1e-14 * stiffest) << "motion " << rigid;
  }
}

/// Displacement of each node by its number, along turned axes; the stretch that answers, turned back, of all nodes.
std::vector<double> stretch_by_node(const Turn& turn) {
  const Network network{PETSC_COMM_WORLD, small_house(turn)};
  FilteredStructure line{network, {.filter_frequency = 150.0, .check_interval = 1}};
  const MassPoints& points = network.points();
  std::vector<double> given(points.coordinates());
  std::vector<double> force(points.coordinates());
  std::vector<double> stretch(points.coordinates());
  const auto at = [&](std::size_t local, std::size_t axis) {
    return static_cast<std::size_t>(network.point({.rank = network.rank(), .local = local}, axis) - points.begin());
  };
  for (std::size_t local = 0; local < network.nodes(); ++local) {
    const std::int64_t node = points.number(local) / 3;
    const auto number = static_cast<double>(node);
    const Place moved = turn({2.0 + std::sin(number), std::cos(2.0 * number), 0.1 * number});
    const Place pushed = turn({10.0 * std::cos(number), 0.0, 5.0 * std::sin(3.0 * number)});
    for (const auto& [axis, u, f] :
         {std::tuple{0U, moved.x, pushed.x}, {1U, moved.y, pushed.y}, {2U, moved.z, pushed.z}}) {
      given[at(local, axis)] = u;
      force[at(local, axis)] = f;
    }
  }
  line.solve(given, force, stretch, {});
  const Place x = turn({.x = 1.0});
  const Place y = turn({.y = 1.0});
  const Place z = turn({.z = 1.0});
  std::vector<double> all(3 * network.total_nodes(), 0.0);
  for (std::size_t local = 0; local < network.nodes(); ++local) {
    const auto node = static_cast<std::size_t>(points.number(local) / 3);
    const Place d{.x = stretch[at(local, 0)], .y = stretch[at(local, 1)], .z = stretch[at(local, 2)]};
    all[3 * node] = d.x * x.x + d.y * x.y + d.z * x.z;
    all[3 * node + 1] = d.x * y.x + d.y * y.y + d.z * y.z;
    all[3 * node + 2] = d.x * z.x + d.y * z.y + d.z * z.z;
  }
  MPI_Allreduce(MPI_IN_PLACE, all.data(), static_cast<int>(all.size()), MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
  return all;
}

TEST(Network, TurnedCopyGivesTheTurnedAnswer) {
  const std::vector<double> expected = stretch_by_node({});
  const std::vector<double> found = stretch_by_node(kTurnedHouse);
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_NEAR(found[i], expected[i], 1e-9) << "node " << i / 3;  // of order one; (w_max / wf)^2 eps
  }
}

/// A translation along one axis stretches no filter spring, to the bit.
TEST(Network, TranslationStretchesNothing) {
  const Network network{PETSC_COMM_WORLD, small_house(kTurnedHouse)};
  FilteredStructure line{network, {.filter_frequency = 50.0}};
  const MassPoints& points = network.points();
  std::vector<double> given;
  given.reserve(points.points());
  for (std::size_t point = 0; point < points.points(); ++point) {
    given.push_back(points.direction(point) == Direction::y   ? -1.7
                    : points.direction(point) == Direction::x ? 0.3
                                                              : 0.0);
  }
  std::vector<double> stretch(given.size(), 1.0);
  line.solve(given, {}, stretch, {});
  for (const double value : stretch) {
    EXPECT_EQ(value, 0.0);
  }
}

/// Along x, in pieces, bent along y: the same stretch as the beam's own line.
TEST(Network, StraightLineOfMembersIsTheBeam) {
  const double wf = 100.0;
  constexpr std::size_t kMembers = 5;
  constexpr std::size_t kElements = 40;
  NetworkParameters parameters{.sections = {test::round_section()}, .junctions = {{}}, .members = {}};
  for (std::size_t i = 0; i < kMembers; ++i) {
    parameters.junctions.push_back(test::junction_at({.x = 10.0 * static_cast<double>(i + 1) / kMembers}));
    parameters.members.push_back(test::member_between(i, i + 1, kElements / kMembers));
  }
  const auto displacement = [](double x) { return 3.0 + 0.2 * x + 0.01 * std::sin(0.7 * x); };
  const BeamChain beam{PETSC_COMM_WORLD, test::steel_beam(kElements)};
  FilteredStructure line{beam, {.filter_frequency = wf}};
  std::vector<double> of_beam(kElements + 1, 0.0);
  {
    std::vector<double> given;
    for (PetscInt node = beam.begin(); node < beam.end(); ++node) {
      given.push_back(displacement(beam.position(node)));
    }
    std::vector<double> stretch(given.size());
    line.solve(given, {}, stretch, {});
    std::ranges::copy(stretch, of_beam.begin() + beam.begin());
    MPI_Allreduce(MPI_IN_PLACE, of_beam.data(), static_cast<int>(of_beam.size()), MPI_DOUBLE, MPI_SUM,
                  PETSC_COMM_WORLD);
  }
  const Network network{PETSC_COMM_WORLD, parameters};
  EXPECT_NEAR(network.points().total_mass(), beam.total_mass(), 1e-12 * beam.total_mass());
  FilteredStructure other{network, {.filter_frequency = wf}};
  const MassPoints& points = network.points();
  std::vector<double> given;
  given.reserve(points.points());
  for (std::size_t point = 0; point < points.points(); ++point) {
    given.push_back(points.direction(point) == Direction::y ? displacement(points.place(point).x) : 0.0);
  }
  std::vector<double> stretch(given.size());
  other.solve(given, {}, stretch, {});
  for (std::size_t point = 0; point < stretch.size(); ++point) {
    const auto node = static_cast<std::size_t>(std::lround(points.place(point).x * kElements / 10.0));
    const double expected = points.direction(point) == Direction::y ? of_beam.at(node) : 0.0;
    EXPECT_NEAR(stretch[point], expected, 1e-9 * 0.01) << "node " << node;
  }
}

}  // namespace
}  // namespace udar
