#pragma once
/// @file
/// Many masses that meet a stop once at most, side by side in the lanes of the processor.

#include <array>
#include <cstddef>
#include <limits>

#include "udar/local/local_motion.hpp"

namespace udar::local {

inline constexpr std::size_t kLanes = 8;
using Lanes = std::array<double, kLanes>;
[[nodiscard]] constexpr Lanes filled(double value) {
  Lanes lanes{};
  lanes.fill(value);
  return lanes;
}

/// @brief Problems of one step, and their outcomes. @see Problem, Outcome
struct alignas(64) Batch {
  std::array<Lanes, kMostTerms> line{};  ///< P by its Legendre coefficients [m]
  Lanes velocity{};                      ///< [m per step]
  Lanes at{};                            ///< the stop: displacement at which the mass touches, off it at the start [m]
  Lanes side{};                          ///< +1 stop below, -1 above
  Lanes restitution{};
  Lanes yield_speed = filled(std::numeric_limits<double>::infinity());  ///< [m per step]

  Lanes simple{};  ///< 0: not solved here, `advance` must
  std::array<Lanes, kMostTerms> moments{};
  Lanes displacement{};
  Lanes end_velocity{};
  Lanes impact{};  ///< tau; 2: none
  Lanes before{};  ///< velocity before the impact [m per step]
  Lanes after{};   ///< and after it
  Lanes rests{};   ///< 1: rests from the impact to the end
};

/// @brief Solves what has one stop, one impact at most and no rest that ends: as `advance`, but for round-off.
/// @param angle, terms, powers, hop_tolerance as in `Problem`
void advance(Batch& batch, double angle, std::size_t terms, std::size_t powers, double hop_tolerance);

}  // namespace udar::local
