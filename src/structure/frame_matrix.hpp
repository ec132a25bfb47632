#pragma once
/// @file
/// The stiffness of a network, element by element.

#include "udar/petsc/handle.hpp"
#include "udar/structure/network.hpp"

namespace udar {

/// @brief What `Network::stiffness` gives. @note Collective.
[[nodiscard]] petsc::Matrix frame_matrix(const Network& network);

}  // namespace udar
