#pragma once
/// @file
/// Cross-sections of members from their shapes, graded elements, and networks that are regular.

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "udar/structure/network.hpp"

namespace udar {

/// @brief The outline of a cross-section.
struct MemberShape {
  enum class Kind : std::uint8_t { circle, tube, rectangle };
  Kind kind = Kind::circle;
  double radius = 0.0;        ///< outer one of circle and tube [m]
  double inner_radius = 0.0;  ///< of a tube [m], below the outer one
  double width = 0.0;         ///< of a rectangle, along the member's z axis [m]
  double height = 0.0;        ///< of a rectangle, along its y axis [m]
};

/// @brief Gives a section whose material is known the area, inertias, torsion constant and radius of a shape.
/// @param shear whether members give way to shear, by Cowper's factors (J. Appl. Mech. 33, 1966, 335)
/// Source of the rectangle's torsion constant: Timoshenko and Goodier, Theory of Elasticity, 3rd ed., section 109, to
/// rounding
void give_shape(MemberSection& section, const MemberShape& shape, bool shear);

/// @brief `Member::spacing` in a geometric progression. @param ratio of the last to the first, > 0; 1: empty
[[nodiscard]] std::vector<double> graded_spacing(std::size_t elements, double ratio);

/// @brief Junctions in rows along x, y and z, each joined with its neighbours by a member along the axis.
struct RegularNetwork {
  std::array<std::size_t, 3> junctions{1, 1, 1};  ///< along x, y, z; a grillage has one along y
  std::array<double, 3> spacing{1.0, 1.0, 1.0};   ///< of junctions along x, y, z [m]
  std::size_t elements = 1;                       ///< of a member
  double grading = 1.0;                           ///< how many times as long the last of them is as the first [-]
  MemberSection section{};
};

/// @brief From the origin along the axes. Junctions "i j k" by their numbers along x, y, z, x fastest; members along x
/// first, then along y, then along z.
[[nodiscard]] NetworkParameters regular_network(const RegularNetwork& regular);

}  // namespace udar
