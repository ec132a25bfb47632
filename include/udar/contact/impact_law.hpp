#pragma once
/// @file
/// What happens to a mass that is on its support.

#include <cstdint>

namespace udar {

/// @brief A mass on its support, seen from the support: positive velocity and acceleration lead away from it.
struct TouchingMass {
  double velocity = 0.0;      ///< [m/s]
  double acceleration = 0.0;  ///< by the filter spring, [m/s^2]; negative: it presses on the support
  double mass = 0.0;          ///< [kg]
};

/// @brief The outcome for that mass.
struct ContactOutcome {
  double velocity = 0.0;     ///< afterwards [m/s], >= 0
  double energy_loss = 0.0;  ///< [J], >= 0
  bool impact = false;       ///< it arrived with a velocity towards the support
  bool rests = false;        ///< it stays on the support
};

/// @brief Newton's law v+ = -e v-, and rest where the next hop would be lower than `hop_tolerance`.
/// @param restitution   e, from 0 to 1
/// @param hop_tolerance [m], >= 0
/// Source: docs/theory.md, "Impact, rest and release"
[[nodiscard]] ContactOutcome resolve_contact(const TouchingMass& mass, double restitution, double hop_tolerance);

}  // namespace udar
