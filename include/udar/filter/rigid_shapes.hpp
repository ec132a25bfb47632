#pragma once
/// @file
/// The motions of a structure that strain nothing.

#include <vector>

#include "udar/filter/filtered_structure.hpp"

namespace udar {

/// @brief What of moving along and turning about three axes strains nothing: M-orthonormal combinations of them, of a
/// beam at most two, of what is free in space six, fewer of what is held or stands in a line.
///
/// Parts that nothing connects, and links of a mechanism, have more such motions than those of the whole:
/// `modes_beside` finds these, of frequency 0.
/// @return shapes at the local points [kg^(-1/2)], phi' M phi = 1 over all ranks
/// @note Collective; a line solve for each motion that moves a point, and some tens of small reductions.
[[nodiscard]] std::vector<std::vector<double>> rigid_shapes(FilteredStructure& line);

}  // namespace udar
