#pragma once
/// @file
/// How stiffly a structure ties its points together.

#include <cstddef>
#include <span>
#include <vector>

#include "udar/filter/filtered_structure.hpp"

namespace udar {

/// @brief How much of a point's displacement the structure takes on at once at that point, all others held by their
/// filter springs: wf^2 m ((wf^2 M + C)^-1) of the point, between 0 and 1; estimates are from above.
///
/// Of a chain dx / 2 l on an even Winkler bed of decay length l = (4 EI / rhoA wf^2)^(1/4), four times that at an end.
/// Else by a solve for each point, up to 256 of them over all ranks; of more by some 256 of them, the same on any
/// number of ranks, all points having four times the largest.
/// @param points local, those asked for @return one value each
/// @note Collective.
[[nodiscard]] std::vector<float> own_shares(FilteredStructure& structure, std::span<const std::size_t> points);

}  // namespace udar
