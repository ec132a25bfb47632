#pragma once
/// @file
/// Cross-sections of a beam.

namespace udar {

/// @brief What a cross-section contributes to a beam bending in its plane.
struct Section {
  double area = 0.0;               ///< A [m^2]
  double inertia = 0.0;            ///< second moment of area I [m^4]
  double shear_coefficient = 0.0;  ///< Timoshenko's k [-]; shear stiffness is k G A
  double outer_fibre = 0.0;        ///< c, largest distance from the neutral axis [m]; 0: not known
};

/// Solid circle of the given radius [m].
/// @param poisson_ratio enters the shear coefficient only; Source: Cowper, J. Appl. Mech. 33 (1966) 335
[[nodiscard]] Section circle_section(double radius, double poisson_ratio);

/// Circular tube, outer and inner radius [m]. Source of the shear coefficient: Cowper (1966)
[[nodiscard]] Section tube_section(double outer_radius, double inner_radius, double poisson_ratio);

/// Rectangle, width across and height in the plane of bending [m]. Source of the shear coefficient: Cowper (1966)
[[nodiscard]] Section rectangle_section(double width, double height, double poisson_ratio);

}  // namespace udar
