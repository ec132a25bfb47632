#pragma once
/// @file
/// Obstacles that are boxes.

#include <span>
#include <vector>

#include "udar/contact/support.hpp"

namespace udar {

/// @brief The faces of a box that some node faces, as supports. A face is touched by nodes that stand in front of it,
/// within its edges; who stands askew of the box touches nothing.
/// @param like of law and friction @param nodes where these stand as long as nothing strains the structure [m]
/// @throws InputError naming the box if it is none, if a node stands in it, or if none stands in front of a face
[[nodiscard]] std::vector<Support> box_faces(const Region& box, const Support& like, std::span<const Place> nodes);

}  // namespace udar
