#pragma once
/// @file
/// What happens to a mass that is on its support.

#include <cmath>
#include <limits>

namespace udar {

/// @brief A mass on its support, seen from the support: positive velocity and acceleration lead away from it.
struct TouchingMass {
  double velocity = 0.0;      ///< [m/s]
  double acceleration = 0.0;  ///< by the filter spring, [m/s^2]; negative: it presses on the support
  double resolution = 0.0;    ///< of the acceleration [m/s^2]: what is not above it does not pull the mass off
  double mass = 0.0;          ///< [kg]
};

/// @brief The outcome for that mass.
struct ContactOutcome {
  double velocity = 0.0;     ///< afterwards [m/s], >= 0
  double energy_loss = 0.0;  ///< [J], >= 0
  bool impact = false;       ///< it arrived with a velocity towards the support
  bool rests = false;        ///< it stays on the support
};

/// @brief e0 up to the yield speed, e0 (v / v_y)^(-1/4) above it.
/// @param speed v of the mass towards its support [m/s], > 0, or in the unit of `yield_speed`
/// Source: K. L. Johnson, Contact Mechanics, Cambridge 1985, section 11.5
[[nodiscard]] inline double falling_restitution(double restitution, double yield_speed, double speed) {
  const double ratio = yield_speed / speed;
  return ratio < 1.0 ? restitution * std::sqrt(std::sqrt(ratio)) : restitution;
}

/// @brief Newton's law v+ = -e v-, and rest where the next hop would be lower than `hop_tolerance`, or where neither
/// velocity nor acceleration leads away.
/// @param restitution   e0, from 0 to 1
/// @param yield_speed   of `falling_restitution` [m/s]; infinite: e does not fall
/// @param hop_tolerance [m], >= 0
/// Source: docs/theory.md, "Impact, rest and release"
[[nodiscard]] ContactOutcome resolve_contact(const TouchingMass& mass, double restitution, double hop_tolerance,
                                             double yield_speed = std::numeric_limits<double>::infinity());

}  // namespace udar
