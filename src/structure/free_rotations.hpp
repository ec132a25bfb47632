#pragma once
/// @file
/// Rotations of junctions that have neither mass nor stiffness.

#include <string>
#include <vector>

#include "udar/structure/network.hpp"

namespace udar {

/// @brief What holds them, and sentences for the user.
struct FreeRotations {
  std::vector<RotationSpring> springs;
  std::vector<std::string> notes;
};

/// @brief Finds the rotations that cost nothing while no mass moves: one at a junction that no member resists, and that
/// of a straight line of members about its own axis. They couple to no force, and a spring holds each.
///
/// With the masses at rest bending and offsets resist at each junction by itself; what they leave there is tied by
/// torsion alone, in a matrix that is small, or empty. The same on every rank.
/// @param network whose kinds and axes are known
/// @throws InputError naming a junction whose rotation is a mechanism of another kind
[[nodiscard]] FreeRotations hold_free_rotations(const Network& network);

}  // namespace udar
