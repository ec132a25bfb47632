// ranks: 1 2; size: medium
/// @file
/// The modal integrator on networks: motions without strain, frequencies that several modes share, internal forces of a
/// given line; a straight beam as a network lands where the beam does; energy over landings.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "support/modal_fall.hpp"
#include "support/small_frame.hpp"
#include "support/world.hpp"
#include "udar/filter/network_operator.hpp"
#include "udar/filter/rigid_shapes.hpp"
#include "udar/modal/exact_phases.hpp"
#include "udar/modal/modal_model.hpp"
#include "udar/petsc/array.hpp"

namespace udar {
namespace {

constexpr test::Turn kTurn{.about_z = 0.3, .about_x = 0.7};

double largest(MPI_Comm comm, const std::vector<double>& values) {
  double size = 0.0;
  for (const double value : values) {
    size = std::max(size, std::abs(value));
  }
  MPI_Allreduce(MPI_IN_PLACE, &size, 1, MPI_DOUBLE, MPI_MAX, comm);
  return size;
}

NetworkParameters held(NetworkParameters network, std::size_t junctions) {
  for (std::size_t i = 0; i < junctions; ++i) {
    network.junctions[i].held = {true, true, true, false, false, false};
  }
  return network;
}

TEST(NetworkModal, FindsTheMotionsWithoutStrain) {
  struct Try {
    NetworkParameters network;
    std::size_t motions = 0;
  };
  for (const auto& [parameters, motions] :
       {Try{test::small_house(kTurn), 6}, Try{test::turned_beam(10.0, 8, kTurn), 5},
        Try{held(test::small_house(kTurn), 1), 3}, Try{held(test::small_house(kTurn), 2), 1},
        Try{held(test::small_house(kTurn), 3), 0}, Try{held(test::turned_beam(10.0, 8, kTurn), 1), 2}}) {
    const Network network{PETSC_COMM_WORLD, parameters};
    FilteredStructure line{network, {.filter_frequency = 300.0}};
    const std::vector<std::vector<double>> shapes = rigid_shapes(line);
    ASSERT_EQ(shapes.size(), motions);
    std::vector<double> products(motions * motions, 0.0);
    for (std::size_t a = 0; a < motions; ++a) {
      std::vector<double> stretch(line.mass().size());
      line.solve(shapes[a], {}, stretch, {});
      // What a solve rounds by.
      EXPECT_LT(largest(network.comm(), stretch), 1e-11 * largest(network.comm(), shapes[a]));
      for (std::size_t b = 0; b < motions; ++b) {
        for (std::size_t i = 0; i < stretch.size(); ++i) {
          products[a * motions + b] += line.mass()[i] * shapes[a][i] * shapes[b][i];
        }
      }
    }
    MPI_Allreduce(MPI_IN_PLACE, products.data(), static_cast<int>(products.size()), MPI_DOUBLE, MPI_SUM,
                  network.comm());
    for (std::size_t k = 0; k < products.size(); ++k) {
      EXPECT_NEAR(products[k], k / motions == k % motions ? 1.0 : 0.0, 1e-13);
    }
  }
}

/// Two beams that nothing connects, one of them turned.
NetworkParameters two_beams() {
  NetworkParameters both = test::turned_beam(10.0, 12, {}, test::round_section());
  NetworkParameters other = test::turned_beam(7.0, 12, kTurn, test::steel_section());
  both.sections.push_back(other.sections[0]);
  for (Junction& junction : other.junctions) {
    junction.name += " of the other";
    junction.place.z += 3.0;
    both.junctions.push_back(junction);
  }
  other.members[0].section = 1;
  other.members[0].ends[0].junction = 2;
  other.members[0].ends[1].junction = 3;
  both.members.push_back(other.members[0]);
  return both;
}

TEST(NetworkModal, TakesAllModesOfAFrequencyOrNone) {
  // Of a round beam every bending mode is there twice; axial ones come once.
  const Network network{PETSC_COMM_WORLD, test::turned_beam(10.0, 40, kTurn, test::round_section())};
  const BeamChain beam{PETSC_COMM_WORLD, test::steel_beam(40)};
  const ModalBasis of_beam{beam, {}, 8};
  for (const PetscInt count : {6, 9, 10, 14}) {
    const ModalBasis basis{network, {}, count};
    ASSERT_EQ(basis.modes(), static_cast<std::size_t>(count + 1 - count % 2)) << count;
    for (std::size_t m = 0; m < basis.modes(); ++m) {
      const double expected = m < 5 ? 0.0 : of_beam.frequency()[2 + (m - 5) / 2];
      EXPECT_NEAR(basis.frequency()[m], expected, 1e-9 * expected) << m;
    }
  }
  const Network two{PETSC_COMM_WORLD, two_beams()};
  const ModalBasis basis{two, {}, 14};
  EXPECT_EQ(std::ranges::count(basis.frequency(), 0.0), 10);
  EXPECT_GE(basis.modes(), 14U);
}

TEST(NetworkModal, InternalForcesFollowFromPlaces) {
  // Rotations without mass are those on which the assembled frame makes no moment.
  for (const NetworkParameters& parameters :
       {test::small_house(kTurn), test::turned_beam(10.0, 700, kTurn), held(test::small_house(kTurn), 2)}) {
    const Network network{PETSC_COMM_WORLD, parameters};
    NetworkOperator filter{network, 2e4};
    const std::size_t points = network.points().points();
    std::vector<double> displacement(points);
    for (std::size_t i = 0; i < points; ++i) {
      const Place at = network.points().place(i);
      displacement[i] = network.points().fixed(i)
                            ? 0.0
                            : 1e-3 * std::sin(1.3 * at.x + 2.0 * at.y - 0.5 * at.z +
                                              static_cast<double>(network.points().number(i) % 3));
    }
    std::vector<double> internal(2 * points);
    filter.internal_of({.displacement = displacement.data(), .internal = internal.data()});
    petsc::Vector motion;
    petsc::Vector force;
    UDAR_CALL(MatCreateVecs(network.stiffness(), motion.put(), force.put()));
    const auto moments = [&](bool turned) {
      {
        const petsc::WriteArray values{motion};
        std::ranges::copy(displacement, values.values());
        for (std::size_t i = 0; i < points; ++i) {
          values.values()[points + i] = turned ? internal[i] : 0.0;
        }
      }
      UDAR_CALL(MatMult(network.stiffness(), motion, force));
      const petsc::ReadArray values{force};
      return std::vector<double>(values.values() + points, values.values() + 2 * points);
    };
    // The assembled product rounds by EI / h^2 times displacements.
    EXPECT_LT(largest(network.comm(), moments(true)), 1e-9 * largest(network.comm(), moments(false)));
  }
}

/// When a reduced model lands after flights of 0.1 s, and its energy.
struct Course {
  std::vector<double> landings;  // [s]
  double before = 0.0;           // [J]
  double after = 0.0;
};

Course course_of(const ModalModel& model, double speed, std::span<const double> up, double until) {
  ExactPhases motion{model.reduced()};
  std::vector<double> velocity(up.begin(), up.end());
  for (double& value : velocity) {
    value *= -speed;
  }
  motion.start(model.project(0.0, std::vector<double>(up.size(), 0.0), velocity), model.drive());
  const auto energy = [&] { return modal_energy(model.reduced(), model.drive(), motion.now()).total(); };
  Course course{.landings = {}, .before = energy()};
  double left = 0.0;
  while (motion.now().time < until) {
    motion.advance(until);
    std::vector<ModalContact> contacts = motion.contacts();
    std::ranges::sort(contacts, {}, &ModalContact::from);
    for (const ModalContact& contact : contacts) {
      if (contact.from > left + 0.1) {
        course.landings.push_back(contact.from);
      }
      left = std::max(left, contact.until);
    }
  }
  course.after = energy();
  return course;
}

/// Of each local point its share of a motion upwards.
std::vector<double> upwards(const MassPoints& points) {
  std::vector<double> up(points.points());
  for (std::size_t i = 0; i < up.size(); ++i) {
    up[i] = points.axis(i).y;
  }
  return up;
}

TEST(NetworkModal, AStraightBeamLandsWhereTheBeamDoes) {
  // 16 modes of a beam; of a round bar in space these, those across, and three along it below the last of them.
  constexpr PetscInt kElements = 40;
  const test::ModalFall chain{kElements, test::two_points(kElements, 2e8), {.modes = 16}};
  const Network network{PETSC_COMM_WORLD, test::turned_beam(10.0, kElements, {}, test::round_section())};
  const Loads weight{network.points(), test::kGravity, {}};
  std::vector<LinePoint> points = test::two_points(kElements, 2e8);
  for (LinePoint& point : points) {
    if (network.member_ranks()[0] == network.rank()) {
      point.node = network.point(network.node(0, static_cast<std::size_t>(point.node)), 1);
    }
    MPI_Bcast(&point.node, 1, MPIU_INT, network.member_ranks()[0], network.comm());
  }
  const std::vector<double> up = upwards(network.points());
  const ModalModel model{network, {}, weight, std::vector<double>(up.size(), 0.0), points, {.modes = 36}};
  ASSERT_EQ(model.reduced().modes(), 36U);
  for (std::size_t i = 0; i < 2; ++i) {
    for (std::size_t j = 0; j < 2; ++j) {
      EXPECT_NEAR(model.reduced().compliance[2 * i + j], chain.model.reduced().compliance[2 * i + j], 1e-9 / 2e8);
    }
  }
  const Course of_chain = course_of(chain.model, test::kFallSpeed, upwards(chain.beam.points()), 1.6);
  const Course of_network = course_of(model, test::kFallSpeed, up, 1.6);
  ASSERT_EQ(of_chain.landings.size(), 2U);
  ASSERT_EQ(of_network.landings.size(), 2U);
  EXPECT_NEAR(of_network.landings[0], of_chain.landings[0], 1e-10);
  EXPECT_NEAR(of_network.landings[1], of_chain.landings[1], 1e-9);
  EXPECT_NEAR(of_network.before, of_chain.before, 1e-11 * of_chain.before);
  EXPECT_NEAR(of_network.after, of_network.before, 1e-12 * of_network.before);
}

TEST(NetworkModal, AFrameKeepsItsEnergyOverLandings) {
  const Network network{PETSC_COMM_WORLD, test::small_house()};
  const Loads weight{network.points(), test::kGravity, {}};
  std::vector<LinePoint> points;
  for (const std::size_t foot : {0U, 1U, 2U, 3U}) {
    points.push_back({.node = network.point(network.junction_node(foot), 1), .compliance = 1.0 / 2e6});
  }
  std::ranges::sort(points, {}, &LinePoint::node);
  const std::vector<double> up = upwards(network.points());
  const ModalModel model{network, {}, weight, std::vector<double>(up.size(), 0.0), points, {.modes = 30}};
  const Course course = course_of(model, 2.0, up, 2.0);
  ASSERT_GE(course.landings.size(), 2U);
  EXPECT_NEAR(course.after, course.before, 1e-12 * course.before);
}

}  // namespace
}  // namespace udar
