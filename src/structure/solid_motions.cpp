#include "udar/structure/solid_motions.hpp"

#include <mpi.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "structure/place_algebra.hpp"

namespace udar {
namespace {

using Shape = std::vector<double>;

/// a' M b @note Collective.
double mass_product(const MassPoints& points, const Shape& a, const Shape& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < points.mass().size(); ++i) {
    sum += points.mass()[i] * a[i] * b[i];
  }
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, points.comm());
  return sum;
}

/// Of the box around all points [m]. @note Collective.
Place middle_of(const MassPoints& points) {
  std::array<double, 6> ends{};  // the first of each pair negative, so that one reduction finds all
  ends.fill(-std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < points.points(); ++i) {
    const std::array<double, 3> place = values_of(points.place(i));
    for (std::size_t k = 0; k < 3; ++k) {
      ends.at(2 * k) = std::max(ends.at(2 * k), -place.at(k));
      ends.at(2 * k + 1) = std::max(ends.at(2 * k + 1), place.at(k));
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, ends.data(), static_cast<int>(ends.size()), MPI_DOUBLE, MPI_MAX, points.comm());
  return 0.5 * Place{.x = ends[1] - ends[0], .y = ends[3] - ends[2], .z = ends[5] - ends[4]};
}

/// Along x, y, z, then about x, y, z through the middle; of a fixed point none.
std::vector<Shape> unit_motions(const MassPoints& points) {
  constexpr std::array kAxes{Place{.x = 1.0}, Place{.y = 1.0}, Place{.z = 1.0}};
  const Place middle = middle_of(points);
  const double reach = 0.5 * points.largest_extent();
  std::vector<Shape> motions;
  for (const bool turning : {false, true}) {
    for (const Place& axis : kAxes) {
      Shape& motion = motions.emplace_back(points.points());
      for (std::size_t i = 0; i < motion.size(); ++i) {
        const Place moved = turning ? cross(axis, (1.0 / reach) * (points.place(i) - middle)) : axis;
        if (points.direction(i) == Direction::other) {
          motion[i] = turning ? dot(points.turning(i), axis) / reach : 0.0;
        } else {
          motion[i] = points.fixed(i) ? 0.0 : dot(points.axis(i), moved);
        }
      }
    }
  }
  return motions;
}

}  // namespace

/// One after the other beside those before, twice against rounding; without what is nothing then.
std::vector<std::vector<double>> solid_motions(const MassPoints& points) {
  constexpr double kNothing = 1e-24;  // of a square: rounding of places
  std::vector<Shape> made;
  for (Shape& motion : unit_motions(points)) {
    const double before = mass_product(points, motion, motion);
    for (std::size_t pass = 0; pass < 2 && before > 0.0; ++pass) {
      for (const Shape& other : made) {
        const double share = mass_product(points, other, motion);
        for (std::size_t i = 0; i < motion.size(); ++i) {
          motion[i] += -share * other[i];
        }
      }
    }
    const double square = mass_product(points, motion, motion);
    if (square > kNothing * before) {
      for (double& value : motion) {
        value /= std::sqrt(square);
      }
      made.push_back(std::move(motion));
    }
  }
  return made;
}

}  // namespace udar
