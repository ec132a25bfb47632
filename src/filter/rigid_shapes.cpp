#include "udar/filter/rigid_shapes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include "udar/filter/modes.hpp"
#include "udar/structure/solid_motions.hpp"

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
  std::vector<TriedMotion> motions;
  for (PointValues& shape : solid_motions(line.points())) {
    motions.push_back({.shape = std::move(shape), .stretch = PointValues(line.mass().size())});
  }
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
