#include "structure/network_checks.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <span>
#include <sstream>

#include "structure/member_frame.hpp"
#include "structure/place_algebra.hpp"
#include "udar/petsc/error.hpp"

namespace udar {
namespace {

/// Of the extent of all junctions: places typed with ten digits that differ by less are one.
constexpr double kSamePlace = 1e-9;

template <class Thing>
std::string name_among(const char* what, const std::vector<Thing>& things, const Thing& thing) {
  std::ostringstream name;
  name << what << ' ';
  if (thing.name.empty()) {
    name << &thing - things.data() << " (counted from 0)";
  } else {
    name << '\'' << thing.name << '\'';
  }
  return name.str();
}

std::string name_of(const NetworkParameters& network, const MemberSection& section) {
  return name_among("section", network.sections, section);
}

std::string text(const Place& place) {
  std::ostringstream text;
  text << '(' << place.x << ", " << place.y << ", " << place.z << ')';
  return text.str();
}

[[noreturn]] void refuse(const std::string& name, const char* quantity, const std::string& value,
                         const std::string& expected) {
  throw InputError{"network " + name + ", " + quantity + ": " + value + " is not allowed, expected " + expected};
}

/// What a number may be.
enum class Range : std::uint8_t { above_zero, from_zero, from_zero_or_rigid };

/// Refuses what is not in its range.
void require(const std::string& name, const char* quantity, double value, Range range, const char* unit) {
  const bool large = range == Range::from_zero_or_rigid || std::isfinite(value);
  if (large && (range == Range::above_zero ? value > 0.0 : value >= 0.0)) {
    return;
  }
  std::ostringstream given;
  given << value;
  refuse(name, quantity, given.str(),
         std::string{range == Range::above_zero  ? "a number > 0 ["
                     : range == Range::from_zero ? "a number >= 0 ["
                                                 : "a number >= 0, or infinity of a rigid joint, ["} +
             unit + "]");
}

void require_finite(const std::string& name, const char* quantity, const Place& place) {
  if (!std::isfinite(place.x) || !std::isfinite(place.y) || !std::isfinite(place.z)) {
    refuse(name, quantity, text(place), "three finite numbers [m]");
  }
}

void require_index(const std::string& name, const char* quantity, std::size_t index, std::size_t count) {
  if (index >= count) {
    refuse(name, quantity, std::to_string(index),
           "a number below " + std::to_string(count) + ", as many as there are, counted from 0");
  }
}

void check(const NetworkParameters& network, const MemberSection& section) {
  const std::string name = name_of(network, section);
  require(name, "Young's modulus", section.youngs_modulus, Range::above_zero, "Pa");
  require(name, "shear modulus", section.shear_modulus, Range::above_zero, "Pa");
  require(name, "density", section.density, Range::above_zero, "kg/m^3");
  require(name, "area", section.area, Range::above_zero, "m^2");
  require(name, "inertia of bending in the plane xy", section.inertia[0], Range::above_zero, "m^4");
  require(name, "inertia of bending in the plane xz", section.inertia[1], Range::above_zero, "m^4");
  require(name, "torsion constant", section.torsion_constant, Range::above_zero, "m^4");
  require(name, "shear factor along y", section.shear_factor[0], Range::from_zero, "1");
  require(name, "shear factor along z", section.shear_factor[1], Range::from_zero, "1");
  require(name, "radius", section.radius, Range::from_zero, "m");
}

void check(const NetworkParameters& network, const Junction& junction) {
  const std::string name = name_of(network, junction);
  require_finite(name, "place", junction.place);
  for (std::size_t freedom = 0; freedom < 6; ++freedom) {
    require(name, freedom < 3 ? "stiffness of a spring" : "stiffness of a spring against rotation",
            junction.stiffness.at(freedom), Range::from_zero, freedom < 3 ? "N/m" : "N m/rad");
  }
  require(name, "mass", junction.mass, Range::from_zero, "kg");
}

/// @param small lengths that are none [m]
void check(const NetworkParameters& network, const Member& member, double small) {
  const std::string name = name_of(network, member);
  require_index(name, "section", member.section, network.sections.size());
  for (const MemberEnd& end : member.ends) {
    require_index(name, "junction", end.junction, network.junctions.size());
    require_finite(name, "offset", end.offset);
    for (const double stiffness : end.joint) {
      require(name, "stiffness of a joint", stiffness, Range::from_zero_or_rigid, "N m/rad");
    }
  }
  require_finite(name, "orientation", member.orientation);
  if (member.elements < 1) {
    refuse(name, "elements", std::to_string(member.elements), "a number >= 1");
  }
  if (!member.spacing.empty() && member.spacing.size() != member.elements) {
    refuse(name, "spacing", "of " + std::to_string(member.spacing.size()) + " elements",
           "one of " + std::to_string(member.elements) + ", as many as it has");
  }
  for (const double length : member.spacing) {
    require(name, "spacing", length, Range::above_zero, "of any unit");
  }
  if (member.ends[0].junction == member.ends[1].junction) {
    throw InputError{"network " + name + ": both ends are at " +
                     name_of(network, network.junctions[member.ends[0].junction]) + ", expected two junctions"};
  }
  if (const double length = norm(span_of(network, member)); !(length > small)) {
    std::ostringstream given;
    given << length;
    refuse(
        name, "length", given.str(),
        "a number > 0 [m], from " + text(end_place(network, member, 0)) + " to " + text(end_place(network, member, 1)));
  }
  if (orientation_is_parallel(network, member)) {
    refuse(name, "orientation", text(member.orientation),
           "a direction that is not that of the member, " + text(span_of(network, member)));
  }
}

/// Numbers that lie together in every one of some coordinates, by sorting one coordinate after another.
struct Clusters {
  std::size_t coordinates = 0;
  std::function<double(std::size_t number, std::size_t coordinate)> value;
  std::function<double(std::size_t coordinate)> apart;  // from here on they do not
  std::function<void(std::span<std::size_t>)> visit;    // two or more

  void find(std::span<std::size_t> numbers, std::size_t coordinate = 0) const {
    if (numbers.size() < 2) {
      return;
    }
    if (coordinate == coordinates) {
      return visit(numbers);
    }
    const auto at = [&](std::size_t number) { return value(number, coordinate); };
    std::ranges::stable_sort(numbers, {}, at);
    std::size_t first = 0;
    for (std::size_t i = 1; i <= numbers.size(); ++i) {
      if (i == numbers.size() || at(numbers[i]) - at(numbers[i - 1]) > apart(coordinate)) {
        find(numbers.subspan(first, i - first), coordinate + 1);
        first = i;
      }
    }
  }
};

std::vector<std::size_t> numbers_up_to(std::size_t count) {
  std::vector<std::size_t> numbers(count);
  std::iota(numbers.begin(), numbers.end(), std::size_t{0});
  return numbers;
}

/// The diagonal of the box around all junctions [m].
double extent_of(const NetworkParameters& network) {
  if (network.junctions.empty()) {
    return 0.0;
  }
  Place least = network.junctions.front().place;
  Place most = least;
  for (const Junction& junction : network.junctions) {
    const Place& at = junction.place;
    least = {.x = std::min(least.x, at.x), .y = std::min(least.y, at.y), .z = std::min(least.z, at.z)};
    most = {.x = std::max(most.x, at.x), .y = std::max(most.y, at.y), .z = std::max(most.z, at.z)};
  }
  return norm(most - least);
}

void require_apart(const NetworkParameters& network, double small) {
  const std::vector<Junction>& junctions = network.junctions;
  std::vector<std::size_t> numbers = numbers_up_to(junctions.size());
  const Clusters clusters{
      .coordinates = 3,
      .value = [&](std::size_t number, std::size_t axis) { return values_of(junctions[number].place).at(axis); },
      .apart = [&](std::size_t /*axis*/) { return small; },
      .visit =
          [&](std::span<std::size_t> together) {
            std::ranges::sort(together);
            throw InputError{"network " + name_of(network, junctions[together[0]]) + " and " +
                             name_of(network, junctions[together[1]]) + " are both at " +
                             text(junctions[together[1]].place) + " [m], expected junctions apart"};
          }};
  clusters.find(numbers);
}

void require_all_used(const NetworkParameters& network) {
  std::vector<bool> used(network.junctions.size(), false);
  for (const Member& member : network.members) {
    used[member.ends[0].junction] = true;
    used[member.ends[1].junction] = true;
  }
  if (const auto unused = std::ranges::find(used, false); unused != used.end()) {
    throw InputError{"network " + name_of(network, network.junctions[static_cast<std::size_t>(unused - used.begin())]) +
                     ": no member ends there, expected one at least"};
  }
}

/// A member as a piece of the infinite line through it.
struct Piece {
  std::array<double, 6> line{};  // its direction, whose first component of some size is positive; the foot of 0 on it
  double from = 0.0;             // along the direction [m]
  double to = 0.0;
};

Piece piece_of(const NetworkParameters& network, const Member& member, const Axes& axes) {
  Place along = place_of(axes[0]);
  const auto leading = std::ranges::find_if(axes[0], [](double value) { return std::abs(value) > kParallel; });
  along = (*leading > 0.0 ? 1.0 : -1.0) * along;
  const Place start = end_place(network, member, 0);
  const Place foot = start - dot(start, along) * along;
  const std::array ends{dot(start, along), dot(end_place(network, member, 1), along)};
  return {.line = {along.x, along.y, along.z, foot.x, foot.y, foot.z},
          .from = std::min(ends[0], ends[1]),
          .to = std::max(ends[0], ends[1])};
}

}  // namespace

std::string name_of(const NetworkParameters& network, const Junction& junction) {
  return name_among("junction", network.junctions, junction);
}

std::string name_of(const NetworkParameters& network, const Member& member) {
  return name_among("member", network.members, member);
}

void check_network(const NetworkParameters& network) {
  if (network.members.empty()) {
    throw InputError{"network: no members, expected one at least"};
  }
  for (const MemberSection& section : network.sections) {
    check(network, section);
  }
  for (const Junction& junction : network.junctions) {
    check(network, junction);
  }
  const double small = kSamePlace * extent_of(network);
  for (const Member& member : network.members) {
    check(network, member, small);
  }
  require_apart(network, small);
  require_all_used(network);
}

std::vector<std::string> overlaps_of(const NetworkParameters& network, const std::vector<Axes>& axes) {
  std::vector<Piece> pieces;
  pieces.reserve(axes.size());
  for (std::size_t member = 0; member < axes.size(); ++member) {
    pieces.push_back(piece_of(network, network.members[member], axes[member]));
  }
  const double small = kParallel * extent_of(network);
  std::size_t count = 0;
  std::string first;
  std::vector<std::size_t> numbers = numbers_up_to(pieces.size());
  const Clusters lines{
      .coordinates = 6,
      .value = [&](std::size_t number, std::size_t coordinate) { return pieces[number].line.at(coordinate); },
      .apart = [&](std::size_t coordinate) { return coordinate < 3 ? kParallel : small; },
      .visit =
          [&](std::span<std::size_t> collinear) {
            std::ranges::stable_sort(collinear, {}, [&](std::size_t number) { return pieces[number].from; });
            std::size_t furthest = collinear.front();
            for (const std::size_t number : collinear.subspan(1)) {
              if (pieces[number].from < pieces[furthest].to - small) {
                first = count == 0 ? name_of(network, network.members[furthest]) + " and " +
                                         name_of(network, network.members[number])
                                   : first;
                ++count;
              }
              furthest = pieces[number].to > pieces[furthest].to ? number : furthest;
            }
          }};
  lines.find(numbers);
  if (count == 0) {
    return {};
  }
  return {"network " + first + " lie on each other along a line" +
          (count == 1 ? std::string{} : ", and " + std::to_string(count - 1) + " more pairs do") +
          "; the stiffness and the mass of both count"};
}

}  // namespace udar
