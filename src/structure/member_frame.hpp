#pragma once
/// @file
/// Members in global axes: where they are, which way they point, the stiffness of their elements.

#include <array>
#include <cstddef>
#include <vector>

#include "udar/structure/network.hpp"

namespace udar {

/// Directions this close are one: sine of the angle between them.
inline constexpr double kParallel = 1e-6;

/// @brief Where a member's end is: at its junction, or at the end of the rigid arm from there.
[[nodiscard]] Place end_place(const NetworkParameters& network, const Member& member, std::size_t end);
/// @brief From a member's first end to its second [m].
[[nodiscard]] Place span_of(const NetworkParameters& network, const Member& member);
/// @brief Where a member's inner nodes stand, as shares of the way from its first end to its second.
[[nodiscard]] std::vector<double> node_shares(const Member& member);
/// @brief The axes of a member of some length whose orientation is not along it.
[[nodiscard]] Axes axes_of(const NetworkParameters& network, const Member& member);
/// @brief Whether a member's y axis is not to be had from its orientation.
[[nodiscard]] bool orientation_is_parallel(const NetworkParameters& network, const Member& member);

/// @brief One element of a member between two nodes, or between node and junction.
struct FrameElement {
  /// Displacements along global axes and rotations about them, of the first node, then of the second.
  using Matrix = std::array<std::array<double, 12>, 12>;

  double length = 0.0;                       ///< [m]
  std::array<Place, 2> arm{};                ///< from its nodes to its ends [m]
  std::array<std::array<double, 3>, 2> joint{///< of its ends, as `MemberEnd::joint`
                                             {{MemberEnd::kRigid, MemberEnd::kRigid, MemberEnd::kRigid},
                                              {MemberEnd::kRigid, MemberEnd::kRigid, MemberEnd::kRigid}}};
  bool twists = true;  ///< false: without its stiffness of torsion

  /// @brief The stiffness: a sum of squares of natural deformations, which no rigid motion has; symmetric to the bit.
  [[nodiscard]] Matrix stiffness(const MemberSection& section, const Axes& axes) const;
};

/// @brief The stiffness with the rotations of both nodes about axes of their own.
[[nodiscard]] FrameElement::Matrix turned_rotations(const FrameElement::Matrix& matrix, const Axes& first,
                                                    const Axes& second);

/// @brief Element i of a member; joints and arms at its ends are those of the member.
[[nodiscard]] FrameElement element_of(const Member& member, double element_length, std::size_t element);

/// @brief Stiffness of torsion of a length with its joints at both ends [N m/rad].
[[nodiscard]] double torsion_of(const MemberSection& section, double length, double first_joint, double second_joint);

/// @brief What a displacement or rotation at an end of an element is compared with: EA/h [N/m], (EI + GJ)/h [N m/rad].
[[nodiscard]] double scale_of(const MemberSection& section, double length, bool rotation);

}  // namespace udar
