#pragma once
/// @file
/// What depends on the step's length alone: the maps and bounds of a mass's motion over it.

#include <cstddef>

#include "udar/local/dense_map.hpp"

namespace udar {

/// @brief The oscillator of a mass over a step. @see local::Problem
struct StepScale {
  double angle = 0.0;    ///< wf h
  double drag = 0.0;     ///< [1/step]
  double damping = 0.0;  ///< what drives is the line and this times its rate [step]
};

/// @param terms 2 to 5 @param until tau at which the map ends; its moments mean something at 1 only
[[nodiscard]] DenseMap dense_map(const StepScale& scale, std::size_t terms, double until = 1.0);

/// @brief The line's answer to a change of the masses, in units of that change, is between 1 (low modes) and `least`
/// (high ones, or corrected ones): a sweep is exact for the `share` of it.
struct LineAnswer {
  double share = 0.8;
  double least = 0.0;
};

/// @brief Sets gain and contraction of a map: with W what a line that takes on all of a change makes of it, a sweep by
/// (1 - share W)^-1 leaves (answer - share) W (1 - share W)^-1 of an error.
void set_gain(DenseMap& map, const StepScale& scale, std::size_t terms, const LineAnswer& answer);

/// @brief Bounds of the motion.
[[nodiscard]] ResponseBounds response_bounds(const StepScale& scale, std::size_t terms);

}  // namespace udar
