#pragma once
/// @file
/// Stiffness and mass of a beam as matrices, for other programs and for `ImportedStructure`.

#include <string>

#include "udar/structure/beam_chain.hpp"

namespace udar {

/// @brief Entries of a Hermite element's stiffness in (w, theta) at its left and right end:
/// side (w w), cross (w theta), diagonal and coupling (theta theta); all zero of an element that is not there.
struct HermiteElement {
  double side = 0.0;      ///< [N/m]
  double cross = 0.0;     ///< [N]
  double diagonal = 0.0;  ///< [N m]
  double coupling = 0.0;  ///< [N m]
};

/// Ratio 12 EI / (kGA h^2) of bending to shear stiffness.
[[nodiscard]] double shear_ratio(const BeamElement& element);
/// @param tension [N], as a string's: it acts on displacements alone
[[nodiscard]] HermiteElement hermite_element(const BeamElement& element, double tension);

/// @brief Writes PREFIX-stiffness.mtx, PREFIX-mass.mtx and PREFIX-points.csv: displacement and rotation of each node
/// that can move, one after the other, with lumped masses at the displacements and none at the rotations.
///
/// The Hermite form and not the mixed one, as its matrix is a stiffness: positive definite but for rigid motions.
/// @note Collective; rank 0 writes. @throws FileError on all ranks if a file cannot be written
void write_beam_matrices(const BeamChain& beam, const std::string& prefix);

}  // namespace udar
