#pragma once
/// @file
/// The masses that touch nothing, over one step: one small linear map for all of them.

#include <array>
#include <cstddef>

#include "udar/dynamics/local_motion.hpp"

namespace udar {

using local::kMostTerms;
using Square = std::array<std::array<double, kMostTerms>, kMostTerms>;

/// The mass without impacts over a step of one `angle`: z = speed s(tau) + sum_j p_j w_j(tau).
struct DenseMap {
  std::array<double, kMostTerms> start{};  // moments of s
  Square line{};                           // moments of w_j: [moment][j]
  double place_of_start = 0.0;             // s(1)
  double speed_of_start = 0.0;             // s'(1)
  std::array<double, kMostTerms> place{};  // w_j(1)
  std::array<double, kMostTerms> speed{};  // w_j'(1)
  Square gain{};                           // (1 - share line)^-1
};

/// @brief Where a block of nodes has its values.
struct Rows {
  std::array<double*, kMostTerms> moment;  // u: what the line was solved for; out: the next
  std::array<double*, kMostTerms> line;    // d: stretch of the line; out: p
  std::array<const double*, 2> steady;     // what forces add to p_0 and p_1
  const double* velocity;                  // at the start [m/s]
  const double* position;
  const double* axis;  // u_0 counts from it, else from the position at the start
  double* place;       // at the end
  double* speed;
};

/// @brief Largest values of the block: change of a moment, last Legendre term and the one before.
struct Largest {
  double change = 0.0;
  double last = 0.0;
  double before = 0.0;
};

/// @brief Maps `count` masses: p from moments and stretches, the next moments, place and speed at the end.
///
/// Predicting, `line` already is p, and the moments are what it makes of them. Values must be finite.
/// @param terms 2 to 5 @param step [s]
void map_masses(std::size_t terms, bool predict, const Rows& rows, std::size_t count, const DenseMap& map, double step,
                Largest& largest);

}  // namespace udar
