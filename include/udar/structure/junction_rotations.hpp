#pragma once
/// @file
/// Rotary inertia of a network's junctions, and the axes in which their rotations are unknowns.

#include <array>
#include <cstddef>
#include <vector>

#include "udar/structure/network.hpp"

namespace udar {

/// @brief Of each junction: the inertia of half an element of each member there about that member's axis.
/// @param axes of each member @param kinds of members @param kind of each member @throws SolveError as
/// `symmetric_eigen`
[[nodiscard]] std::vector<JunctionRotations> rotations_of_junctions(const NetworkParameters& network,
                                                                    const std::vector<Axes>& axes,
                                                                    const std::vector<MemberKind>& kinds,
                                                                    const std::vector<std::size_t>& kind);

/// @brief The tensor of inertia in global axes, by rows [kg m^2].
[[nodiscard]] Axes inertia_of(const JunctionRotations& rotations);

/// @brief Components of a vector in global axes along given ones, and the way back.
[[nodiscard]] std::array<double, 3> along(const Axes& axes, const std::array<double, 3>& global);
[[nodiscard]] std::array<double, 3> from_along(const Axes& axes, const std::array<double, 3>& own);

}  // namespace udar
