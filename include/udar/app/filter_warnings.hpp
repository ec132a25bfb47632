#pragma once
/// @file
/// How far the filter distorts what a run is going to show.

#include <vector>

#include "udar/app/case.hpp"
#include "udar/filter/modes.hpp"

namespace udar::app {

/// @brief How far the filter springs under a support give way when the beam falls on them.
struct SupportSprings {
  double stiffness = 0.0;      ///< wf^2 times the masses that the supports below can touch [N/m]; 0 without supports
  double drop = 0.0;           ///< smallest initial gap [m]
  double predicted_sag = 0.0;  ///< of a rigid beam on these springs, m g / k + sqrt((m g / k)^2 + v^2 m / k) [m]
};
/// @note Collective.
[[nodiscard]] SupportSprings support_springs(const FilteredStructure& line, const Case& input);

/// @brief Prints a warning for each way in which the filter distorts the answer by more than 10 %.
/// @note Collective; printed by rank 0 on standard error.
void print_warnings(const Case& input, const FilteredStructure& line, const std::vector<Mode>& modes,
                    const SupportSprings& springs);

}  // namespace udar::app
