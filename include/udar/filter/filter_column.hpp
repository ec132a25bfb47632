#pragma once
/// @file
/// What a solve with the filter takes and gives.

namespace udar {

/// @brief One column of a batch of solves; arrays begin at the first local point.
///
/// Either the masses' displacement with or without forces on the structure (stretch and perhaps internal forces are
/// wanted), or a right-hand side of the scaled operator (its unknowns are wanted).
struct FilterColumn {
  const double* displacement = nullptr;     ///< Ym minus the stress-free place [m]
  const double* force = nullptr;            ///< F [N], null: none
  const double* kink = nullptr;             ///< plastic rotations of a beam in the mixed form [rad], null: none
  double* stretch = nullptr;                ///< Yc - Ym [m]
  double* internal = nullptr;               ///< internal forces, of a beam EI w'' [N m]; null: not wanted
  const double* right_hand_side = nullptr;  ///< of the operator, in its own unknowns
  double* unknowns = nullptr;               ///< of the operator
};

}  // namespace udar
