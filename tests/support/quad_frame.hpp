#pragma once
/// @file
/// A network's filter solve as an assembled frame of Hermite elements in 113 bits.

#include <vector>

#include "udar/structure/network.hpp"

namespace udar::test {

/// @brief The stretch Yc - Ym [m] of a network that a rank has whole, and the rotations of its line [rad]: three and
/// three of each node along and about x, y, z; junctions first, then the inner nodes of each member.
/// @param displacement [m] and force [N], three of each node; forces may be empty
/// Axes and element lengths are the network's own, so that nothing but the solve is compared.
[[nodiscard]] std::vector<double> quad_stretch(const Network& network, double filter_frequency,
                                               const std::vector<double>& displacement,
                                               const std::vector<double>& force);

}  // namespace udar::test
