#pragma once
/// @file
/// Where a network stands and how it is turned.

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "udar/structure/network.hpp"
#include "udar/structure/striker.hpp"

namespace udar {

/// @brief Turns a network about the origin, about x, then y, then z, and moves it. Members' own axes and arms turn with
/// it; what holds junctions and springs to the ground stay along x, y and z.
/// @param angles about x, y, z [rad] @param shift [m]
void place_network(NetworkParameters& network, const Place& angles, const Place& shift);

/// @brief Where all nodes stand, junctions first, then the inner nodes of each member [m].
[[nodiscard]] std::vector<Place> node_places(const NetworkParameters& network);

/// @brief The nodes of pairs, for `NetworkParameters::together`; the first of those equally near.
[[nodiscard]] std::vector<std::array<std::size_t, 2>> paired_nodes(const NetworkParameters& network,
                                                                   std::span<const NodePair> pairs);

}  // namespace udar
