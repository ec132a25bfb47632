#pragma once
/// @file
/// What arcs on springs and those on laws of contact have in common.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "udar/local/arcs.hpp"
#include "udar/numerics/power_series.hpp"

namespace udar::local {

// Where an arc would have no length and must have one: far below what any force could do to the mass.
inline constexpr double kMoment = 1e-8;

inline double side_of(std::size_t stop) { return stop == 0 ? 1.0 : -1.0; }

/// Slower than this it stands on the stop, but for rounding.
inline bool stands(const Problem& problem, double speed) {
  return std::abs(speed) <= problem.angle * problem.pull_resolution;
}

/// P in powers of the time since tau.
inline std::array<double, kMostTerms> line_from(const Problem& problem, double tau) {
  std::array<double, kMostTerms> line = problem.line;
  power_series::shift(line.data(), problem.terms, tau);
  return line;
}

/// Place of a stop in powers of the time since tau.
inline std::array<double, kMostTerms> path_from(const Stop& stop, double tau) {
  std::array<double, kMostTerms> path{stop.at};
  if (stop.moves) {
    std::ranges::copy(stop.path, path.begin() + 1);
    power_series::shift(path.data(), 4, tau);
  }
  return path;
}

/// Gap of a stop on an arc, in powers of the time since its start.
inline void fill_gap(const Problem& problem, const Mass& mass, std::size_t stop, FreeArc& arc) {
  const Stop& support = problem.stops[stop];
  const double side = side_of(stop);
  for (std::size_t k = 0; k < arc.powers; ++k) {
    arc.gap[k] = side * arc.series[k];
  }
  arc.gap[0] = side * (mass.place - support.at);
  if (support.moves) {
    const auto path = path_from(support, mass.tau);
    for (std::size_t k = 0; k < 4; ++k) {
      arc.gap[k] = side * (arc.series[k] - path[k]);
    }
  }
}

/// When something happens at a stop; negative: nothing does.
struct StopEvent {
  double at = -1.0;
  bool opens = false;
  LawEnd end = LawEnd::none;  ///< of a piece of a law
};

}  // namespace udar::local
