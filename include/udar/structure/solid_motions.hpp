#pragma once
/// @file
/// How a structure moves as one solid.

#include <vector>

#include "udar/structure/mass_points.hpp"

namespace udar {

/// @brief Combinations of moving along and turning about three axes, small angles, M-orthonormal; of a beam at most
/// two, of a structure in space up to six.
///
/// What is held does not move with the rest: whether a combination strains the structure is not asked here.
/// @return shapes at the local coordinates [kg^(-1/2)], phi' M phi = 1 over all ranks
/// @note Collective; some tens of small reductions.
[[nodiscard]] std::vector<std::vector<double>> solid_motions(const MassPoints& points);

}  // namespace udar
