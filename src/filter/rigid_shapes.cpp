#include "udar/filter/rigid_shapes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

#include "structure/place_algebra.hpp"
#include "udar/filter/modes.hpp"

namespace udar {
namespace {

using PointValues = std::vector<double>;

/// A motion, and the stretch of the filter springs when the masses move so.
struct TriedMotion {
  PointValues shape;
  PointValues stretch;
};

/// a' M b of some pairs. @note Collective: one reduction.
template <std::size_t Count>
std::array<double, Count> mass_products(const FilteredStructure& line,
                                        const std::array<std::array<const PointValues*, 2>, Count>& pairs) {
  std::array<double, Count> sums{};
  for (std::size_t k = 0; k < Count; ++k) {
    const auto& [a, b] = pairs[k];
    for (std::size_t i = 0; i < line.mass().size(); ++i) {
      sums[k] += line.mass()[i] * (*a)[i] * (*b)[i];
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(Count), MPI_DOUBLE, MPI_SUM, line.points().comm());
  return sums;
}

/// to + factor of
void add_times(PointValues& to, double factor, const PointValues& of) {
  for (std::size_t i = 0; i < to.size(); ++i) {
    to[i] += factor * of[i];
  }
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
std::vector<PointValues> solid_motions(const MassPoints& points) {
  constexpr std::array kAxes{Place{.x = 1.0}, Place{.y = 1.0}, Place{.z = 1.0}};
  const Place middle = middle_of(points);
  const double reach = 0.5 * points.largest_extent();
  std::vector<PointValues> motions;
  for (const bool turning : {false, true}) {
    for (const Place& axis : kAxes) {
      PointValues& motion = motions.emplace_back(points.points());
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

/// One after the other beside those before, twice against rounding; without what is nothing then.
std::vector<TriedMotion> made_orthonormal(const FilteredStructure& line, std::vector<PointValues> motions) {
  constexpr double kNothing = 1e-24;  // of a square: rounding of places
  std::vector<TriedMotion> made;
  for (PointValues& motion : motions) {
    const double before = mass_products<1>(line, {{{&motion, &motion}}})[0];
    for (std::size_t pass = 0; pass < 2 && before > 0.0; ++pass) {
      for (const TriedMotion& other : made) {
        add_times(motion, -mass_products<1>(line, {{{&other.shape, &motion}}})[0], other.shape);
      }
    }
    const double square = mass_products<1>(line, {{{&motion, &motion}}})[0];
    if (square > kNothing * before) {
      for (double& value : motion) {
        value /= std::sqrt(square);
      }
      made.push_back({.shape = std::move(motion), .stretch = PointValues(line.mass().size())});
    }
  }
  return made;
}

void find_stretches(FilteredStructure& line, std::vector<TriedMotion>& motions) {
  std::vector<FilterColumn> columns;
  columns.reserve(motions.size());
  for (TriedMotion& motion : motions) {
    columns.push_back({.displacement = motion.shape.data(), .stretch = motion.stretch.data()});
  }
  if (!columns.empty()) {
    line.solve(columns);
  }
}

/// Turns two motions into combinations whose stretches are at right angles. @param none where both are no stretch
/// @return whether they were not
bool separate(const FilteredStructure& line, TriedMotion& a, TriedMotion& b, double none) {
  constexpr double kRounding = 1e-15;
  const auto [of_a, of_b, mixed] =
      mass_products<3>(line, {{{&a.stretch, &a.stretch}, {&b.stretch, &b.stretch}, {&a.stretch, &b.stretch}}});
  if (of_a + of_b <= none || std::abs(mixed) <= kRounding * std::max(of_a, of_b)) {
    return false;
  }
  const double angle = 0.5 * std::atan2(2.0 * mixed, of_a - of_b);
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  for (PointValues TriedMotion::* part : {&TriedMotion::shape, &TriedMotion::stretch}) {
    PointValues& first = a.*part;
    PointValues& second = b.*part;
    for (std::size_t i = 0; i < first.size(); ++i) {
      const double turned = c * first[i] + s * second[i];
      second[i] = c * second[i] - s * first[i];
      first[i] = turned;
    }
  }
  return true;
}

/// Among all combinations those that stretch least: one-sided Jacobi rotations, which find small stretches beside large
/// ones to their last digits. Source: Demmel, Veselic, SIAM J. Matrix Anal. Appl. 13 (1992) 1204
void separate_all(const FilteredStructure& line, std::vector<TriedMotion>& motions, double none) {
  constexpr int kMostSweeps = 20;
  bool turned = true;
  for (int sweep = 0; sweep < kMostSweeps && turned; ++sweep) {
    turned = false;
    for (std::size_t a = 0; a < motions.size(); ++a) {
      for (std::size_t b = a + 1; b < motions.size(); ++b) {
        turned = separate(line, motions[a], motions[b], none) || turned;
      }
    }
  }
}

}  // namespace

std::vector<std::vector<double>> rigid_shapes(FilteredStructure& line) {
  std::vector<TriedMotion> motions = made_orthonormal(line, solid_motions(line.points()));
  find_stretches(line, motions);
  // The square of what a line solve rounds by; the share of a true mode, over that of the last, is far above.
  constexpr double kRigid = 1e-20;
  const double none = std::max(kRigid, std::pow(zero_share(line), 2.0));
  separate_all(line, motions, none);
  std::vector<std::vector<double>> shapes;
  for (TriedMotion& motion : motions) {
    if (mass_products<1>(line, {{{&motion.stretch, &motion.stretch}}})[0] <= none) {
      shapes.push_back(std::move(motion.shape));
    }
  }
  return shapes;
}

}  // namespace udar
