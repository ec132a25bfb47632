#include "structure/node_axes.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>
#include <vector>

#include "structure/place_algebra.hpp"
#include "udar/petsc/error.hpp"

namespace udar {
namespace {

constexpr double kSame = 1e-9;         // of directions
constexpr double kRightAngle = 1e-12;  // what is left of a product

bool along_axis(const Place& normal) {
  return std::max({std::abs(normal.x), std::abs(normal.y), std::abs(normal.z)}) == 1.0;
}

/// The axis, of x, y, z, that is most across, made a right angle.
Place across(const Place& normal) {
  const std::array<double, 3> values = values_of(normal);
  std::size_t least = 0;
  for (std::size_t k = 1; k < 3; ++k) {
    least = std::abs(values.at(k)) < std::abs(values.at(least)) ? k : least;
  }
  std::array<double, 3> unit{};
  unit.at(least) = 1.0;
  const Place off = place_of(unit) - values.at(least) * normal;
  return (1.0 / norm(off)) * off;
}

[[noreturn]] void refuse_beside(const HeightGrid& field, const Place& place) {
  std::ostringstream text;
  text << "support height field: the node at (" << place.x << ", " << place.y << ", " << place.z
       << ") m has no height below or above it, which is not allowed, expected heights over all that the support can "
          "touch (`support width`); these are from x = "
       << field.x().front() << " to " << field.x().back() << ", z = " << field.z().front() << " to " << field.z().back()
       << " m, less gaps";
  throw InputError{text.str()};
}

}  // namespace

std::optional<std::array<Place, 3>> node_axes(std::span<const FacedPlane> planes, const Place& place) {
  std::vector<Place> normals;
  for (const auto& [region, facing] : planes) {
    if (!region.holds(place)) {
      continue;
    }
    const Place normal = facing.at(place);
    if (facing.field && norm(normal) == 0.0) {
      refuse_beside(*facing.field, place);
    }
    if (std::ranges::none_of(normals, [&](const Place& other) { return norm(other - normal) <= kSame; })) {
      normals.push_back(normal);
    }
  }
  if (std::ranges::all_of(normals, along_axis)) {
    return std::nullopt;
  }
  for (std::size_t i = 0; i < normals.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (std::abs(dot(normals[i], normals[j])) > kRightAngle) {
        std::ostringstream text;
        text << "support normal: the node at (" << place.x << ", " << place.y << ", " << place.z
             << ") m faces two planes that are not at right angles, which is not allowed: let widths keep one away";
        throw InputError{text.str()};
      }
    }
  }
  if (normals.size() == 1) {
    normals.push_back(across(normals[0]));
  }
  // Axes are right-handed: a third plane that looks against theirs changes places with the second.
  if (normals.size() == 3 && dot(cross(normals[1], normals[0]), normals[2]) < 0.0) {
    std::swap(normals[1], normals[2]);
  }
  return std::array{normals[1], normals[0], cross(normals[1], normals[0])};
}

}  // namespace udar
