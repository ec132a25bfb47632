#pragma once
/// @file
/// The filter as named values.

#include "udar/filter/filtered_structure.hpp"
#include "udar/structure/description.hpp"

namespace udar {

/// @brief All of the filter that shapes the motion.
void describe(Description& all, const FilterParameters& filter);

}  // namespace udar
