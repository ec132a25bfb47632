#pragma once
/// @file
/// The nodes along a straight beam.

#include <vector>

#include "udar/structure/mass_points.hpp"

namespace udar {

/// @brief The places of all ranks' nodes from left to right, strictly ascending [m].
/// @param quantity that asks for one beam, such as "load axles" @note Collective.
/// @throws InputError naming it unless the structure is one straight beam without gaps
[[nodiscard]] std::vector<double> beam_nodes(const MassPoints& points, const char* quantity);

}  // namespace udar
