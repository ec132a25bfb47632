// ranks: 1 2; size: short
/// @file
/// Frequencies of a frame against those of CalculiX, another program (tests/verification/calculix_frame.py).

#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <numbers>
#include <vector>

#include "support/small_frame.hpp"
#include "udar/filter/modes.hpp"
#include "udar/structure/member_shape.hpp"
#include "udar/structure/network.hpp"

namespace udar {
namespace {

/// Four clamped columns, four rails, an arm; squares, Timoshenko.
NetworkParameters space_frame(std::size_t elements, double factor) {
  NetworkParameters frame;
  for (const double side : {0.1, 0.08}) {
    MemberSection section{.name = "square", .youngs_modulus = 2.1e11, .shear_modulus = 2.1e11 / 2.6, .density = 7850.0};
    give_shape(section, {.kind = MemberShape::Kind::rectangle, .width = factor * side, .height = factor * side}, true);
    // A quadratic solid of one element across does not warp.
    section.torsion_constant = section.inertia[0] + section.inertia[1];
    frame.sections.push_back(section);
  }
  for (const double y : {0.0, 3.0}) {
    for (const auto& [x, z] : {std::array{0.0, 0.0}, {4.0, 0.0}, {4.0, 3.0}, {0.0, 3.0}}) {
      frame.junctions.push_back(test::junction_at({.x = x, .y = y, .z = z}));
      frame.junctions.back().held.fill(y == 0.0);
    }
  }
  frame.junctions.push_back(test::junction_at({.x = 5.5, .y = 3.0}));
  const auto add = [&](std::size_t from, std::size_t to, std::size_t section) {
    frame.members.push_back(test::member_between(from, to, elements));
    frame.members.back().section = section;
  };
  for (std::size_t i = 0; i < 4; ++i) {
    add(i, i + 4, 0);
    add(4 + i, 4 + (i + 1) % 4, 1);
  }
  add(5, 8, 1);
  return frame;
}

/// CalculiX 2.20, B32R of 40 and 80 elements a member [Hz], and what it goes to: its error halves with the elements.
struct CalculixFrame {
  double factor;  // of the sections' sides
  std::array<double, 6> coarse;
  std::array<double, 6> fine;
  double tolerance;  // its solids are stiffer than beams at junctions and feet, by some thickness over length
};
constexpr std::array kReferences{
    CalculixFrame{.factor = 1.0,
                  .coarse = {6.016252, 6.223861, 7.705789, 10.019140, 15.826280, 19.272450},
                  .fine = {6.009355, 6.216521, 7.698054, 10.007900, 15.822170, 19.254720},
                  .tolerance = 1.5e-3},
    CalculixFrame{.factor = 0.25,
                  .coarse = {1.504729, 1.556804, 1.927449, 2.505467, 3.961222, 4.823336},
                  .fine = {1.502826, 1.554767, 1.925298, 2.502409, 3.960113, 4.818512},
                  .tolerance = 4e-4}};

TEST(Calculix, HasTheFrequenciesOfTheFrame) {
  for (const auto& [factor, coarse, fine, tolerance] : kReferences) {
    const Network network{PETSC_COMM_WORLD, space_frame(80, factor)};
    const std::vector<Mode> modes = exact_modes(network, {.filter_frequency = 100.0}, 6);
    ASSERT_EQ(modes.size(), 6U);
    for (std::size_t i = 0; i < modes.size(); ++i) {
      const double theirs = 2.0 * fine.at(i) - coarse.at(i);
      EXPECT_NEAR(modes[i].frequency / (2.0 * std::numbers::pi), theirs, tolerance * theirs) << factor << ", " << i;
    }
  }
}

}  // namespace
}  // namespace udar
