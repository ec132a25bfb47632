#pragma once
/// @file
/// What `-udar_view` shows: the case as it was understood, and what was built of it.

#include <vector>

#include "udar/app/case.hpp"
#include "udar/app/filter_warnings.hpp"
#include "udar/filter/modes.hpp"

namespace udar::app {

/// @brief Prints the parameters of the case by the names that restart files have them by, sizes, places and stiffness
/// of what was built, and the lowest modes, one line each. @note Collective; printed by rank 0.
void print_view(const Case& input, FilteredStructure& line, const std::vector<Mode>& modes,
                const SupportSprings& springs);

}  // namespace udar::app
