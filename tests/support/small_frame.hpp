#pragma once
/// @file
/// Networks of few members.

#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "udar/structure/network.hpp"
#include "udar/structure/section.hpp"

namespace udar::test {

/// Steel, with two bending planes that differ. @param shear factors of both planes; 0: Euler-Bernoulli
inline MemberSection steel_section(std::array<double, 2> shear = {0.0, 0.0}) {
  return {.name = "bar",
          .youngs_modulus = 2.1e11,
          .shear_modulus = 8.1e10,
          .density = 7850.0,
          .area = 5e-3,
          .inertia = {4.2e-6, 1.1e-6},
          .torsion_constant = 2.7e-6,
          .shear_factor = shear};
}

/// Of example 01: solid circle of radius 0.1 m.
inline MemberSection round_section() {
  const Section circle = circle_section(0.1, 0.3);
  return {.name = "circle",
          .youngs_modulus = 2.1e11,
          .shear_modulus = 8.1e10,
          .density = 7850.0,
          .area = circle.area,
          .inertia = {circle.inertia, circle.inertia},
          .torsion_constant = 2.0 * circle.inertia};
}

inline Member member_between(std::size_t from, std::size_t to, std::size_t elements) {
  Member member;
  member.ends[0].junction = from;
  member.ends[1].junction = to;
  member.elements = elements;
  return member;
}

inline Junction junction_at(const Place& place) {
  Junction junction;
  junction.place = place;
  return junction;
}

/// Proper rotation of a place: about z, then about x.
struct Turn {
  double about_z = 0.0;  // [rad]
  double about_x = 0.0;

  [[nodiscard]] Place operator()(const Place& a) const {
    const double x = std::cos(about_z) * a.x - std::sin(about_z) * a.y;
    const double y = std::sin(about_z) * a.x + std::cos(about_z) * a.y;
    return {.x = x,
            .y = std::cos(about_x) * y - std::sin(about_x) * a.z,
            .z = std::sin(about_x) * y + std::cos(about_x) * a.z};
  }
};

/// Lengths of elements that differ up to eight times, in no order.
inline std::vector<double> jagged_spacing(std::size_t elements) {
  std::vector<double> spacing;
  spacing.reserve(elements);
  for (std::size_t i = 0; i < elements; ++i) {
    spacing.push_back(std::exp2(1.5 * std::sin(2.4 * static_cast<double>(i))));
  }
  return spacing;
}

/// One member from the origin along a turned x axis, its y axis along the turned y axis.
inline NetworkParameters turned_beam(double length, std::size_t elements, const Turn& turn = {},
                                     const MemberSection& section = steel_section()) {
  NetworkParameters beam{.sections = {section},
                         .junctions = {{.name = "root"}, {.name = "tip", .place = turn({.x = length})}},
                         .members = {member_between(0, 1, elements)}};
  beam.members[0].orientation = turn({.y = 1.0});
  return beam;
}

/// A house of eight junctions with members of several kinds, a point mass, an offset, hinges and a soft joint, turned.
inline NetworkParameters small_house(const Turn& turn = {}) {
  NetworkParameters house{.sections = {steel_section(), steel_section({0.8, 0.6})}, .junctions = {}, .members = {}};
  house.sections[1].area = 2e-3;
  for (const double y : {0.0, 2.0}) {
    for (const auto& [x, z] : {std::pair{0.0, 0.0}, {3.0, 0.2}, {3.2, 2.5}, {0.0, 2.0}}) {
      house.junctions.push_back(
          {.name = std::string{"j"}.append(std::to_string(house.junctions.size())), .place = turn({x, y, z})});
    }
  }
  const auto add = [&](std::size_t from, std::size_t to, std::size_t elements, std::size_t section) {
    house.members.push_back(member_between(from, to, elements));
    house.members.back().section = section;
    house.members.back().orientation = turn({0.3, 0.7, 0.9});
  };
  for (std::size_t i = 0; i < 4; ++i) {
    add(i, i + 4, 4, 0);
    add(4 + i, 4 + (i + 1) % 4, 3, 1);
  }
  add(0, 1, 1, 0);
  add(1, 6, 2, 1);
  house.junctions[5].mass = 20.0;
  house.members[1].ends[0].offset = turn({0.0, 0.1, 0.05});
  house.members[2].ends[1].joint = {MemberEnd::kRigid, 0.0, MemberEnd::kRigid};
  house.members[3].ends[0].joint = {MemberEnd::kRigid, 2e5, 1e5};
  house.members.back().ends[0].joint = {MemberEnd::kRigid, 0.0, 0.0};
  house.members.back().ends[1].joint = {0.0, 0.0, 0.0};
  return house;
}

}  // namespace udar::test
