#pragma once
/// @file
/// The masses that touch nothing, over one step: one small linear map for all of them.

#include <array>
#include <cstddef>
#include <cstdint>

#include "udar/numerics/legendre.hpp"

namespace udar {

/// What a sweep changes of a mass: its moments and, where the line's rate drives it, its place at the end.
inline constexpr std::size_t kMostUnknowns = kMostTerms + 1;
using Gain = std::array<std::array<double, kMostUnknowns>, kMostUnknowns>;

/// The mass without impacts over a step of one `angle`: z = speed s(tau) + sum_j p_j w_j(tau).
struct DenseMap {
  std::array<double, kMostTerms> start{};  // moments of s
  LegendreMatrix line{};                   // moments of w_j: [moment][j]
  double place_of_start = 0.0;             // s(1)
  double speed_of_start = 0.0;             // s'(1)
  std::array<double, kMostTerms> place{};  // w_j(1)
  std::array<double, kMostTerms> speed{};  // w_j'(1)
  Gain gain{};                             // (1 - share W)^-1 of what a sweep changes
  double contraction = 0.0;                // of the sweeps of masses that touch nothing
};

/// @brief Bernstein coefficients of z over the step bound it from both sides; what lies beyond their degree is added.
inline constexpr std::size_t kBounds = 9;
struct ResponseBounds {
  std::array<double, kBounds> start{};  // of s
  std::array<std::array<double, kBounds>, kMostTerms> line{};
  double rest_of_start = 0.0;
  std::array<double, kMostTerms> rest_of_line{};
};

/// @brief Bounds over the step, one per mass [m]: of its displacement if it touches nothing, and of the line's from the
/// mass's position at the start.
struct BlockBounds {
  double* low;
  double* high;
  double* line_low;
  double* line_high;
};

/// @brief Where a block of nodes has its values.
struct BlockRows {
  std::array<double*, kMostUnknowns> moment;    // u: what the line was solved for; out: the next
  std::array<double*, kMostTerms> line;         // d: stretch of the line; out: p
  std::array<const double*, kMostTerms> drive;  // p, and what the line's rate adds, where that is known before
  std::array<const double*, 2> steady;          // what forces add to p_0 and p_1
  bool damped;                                  // the line's rate drives: the place at the end is unknown, too
  const double* velocity;                       // at the start [m/s]
  const double* position;
  const double* axis;  // u_0 counts from it, else from the position at the start
  const double* free;  // 0 where the change does not count, else 1
  double* place;       // at the end
  double* speed;
};

/// @brief SweepMaxima values of the block: change of a moment and of one of the velocity, last Legendre term of what
/// drives and the one before.
struct SweepMaxima {
  double change = 0.0;
  double rate = 0.0;
  double last = 0.0;
  double before = 0.0;
  bool finite = true;  ///< all ends
};

/// @brief Legendre coefficient of a rate over a step by those of the place before it, and the change of place [per
/// step].
template <std::size_t Count>
[[nodiscard]] constexpr double rate_term(std::size_t j, const std::array<double, Count>& place, double change) {
  double sum = change;  // of z L_j from end to end, less the integral of z L_j'
  for (std::size_t k = j; k-- > 0;) {
    sum -= (j - k) % 2 == 1 ? 2.0 * place[k] : 0.0;
  }
  return static_cast<double>(2 * j + 1) * sum;
}

/// @brief Maps `count` masses: p from moments and stretches, the next moments, place and speed at the end.
///
/// Predicting or damped, `drive` is known, and predicting the moments are what it makes of them. What is not finite
/// spreads, and is noted.
/// @param terms 2 to 5 @param step [s]
void map_masses(std::size_t terms, bool predict, const BlockRows& rows, std::size_t count, const DenseMap& map,
                double step, SweepMaxima& largest);

/// @brief Legendre coefficients in another interval, in place: line[j] <- sum_(k >= j) change[j][k] line[k].
void change_basis(std::size_t terms, const std::array<double*, kMostTerms>& line, std::size_t count,
                  const LegendreMatrix& change);

/// @brief Bounds of `count` masses; `rows` as for `map_masses`, before it.
void bound_masses(std::size_t terms, bool predict, const BlockRows& rows, std::size_t count,
                  const ResponseBounds& reach, double step, const BlockBounds& bounds);

/// @brief When a mass is near its support: a distance to both [m].
struct NearSupport {
  double side = 1.0;
  double height = 0.0;
  const double* heights = nullptr;  // of each mass, added to `height`; null: none
  double together = 0.0;
};

/// @brief Marks the masses that may meet a support, by bounds of their displacements [m], or rest: everything but not
/// zero.
void mark_near(const NearSupport& of, std::size_t count, const double* position, const double* bound,
               const std::int32_t* resting, std::uint8_t* near);

/// @brief A bound from below of `side` times the line's position over the step, for all of `count` nodes [m].
/// @param rows line (p) and position @param heights what to count from [m]; null: zero
/// @param bernstein [coefficient][Legendre term]
[[nodiscard]] double lowest_line(std::size_t terms, const BlockRows& rows, std::size_t count, double side,
                                 const double* heights, const LegendreMatrix& bernstein);

}  // namespace udar
