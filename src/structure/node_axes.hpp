#pragma once
/// @file
/// The axes of nodes that face planes.

#include <array>
#include <optional>
#include <span>

#include "udar/structure/network.hpp"

namespace udar {

/// @brief Axes of a node at a place, in the order of its points along x, y, z, the second the normal of the first plane
/// it faces; none where all of these are along x, y or z.
/// @throws InputError naming the place if two planes are not at right angles, so that no axes serve both, or if a field
/// has no height there
[[nodiscard]] std::optional<std::array<Place, 3>> node_axes(std::span<const FacedPlane> planes, const Place& place);

}  // namespace udar
