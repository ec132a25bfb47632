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

/// @brief Newton's law v+ = -e v-, with e = e0 up to the yield speed v_y and e0 (v / v_y)^(-1/4) above it.
/// Source: K. L. Johnson, Contact Mechanics, Cambridge 1985, section 11.5
struct ImpactLaw {
  double restitution = 1.0;                                      ///< e0, from 0 to 1
  double yield_speed = std::numeric_limits<double>::infinity();  ///< v_y [m/s]; infinite: e does not fall

  /// e of a mass that arrives at a speed > 0, in the unit of `yield_speed`.
  [[nodiscard]] double ratio(double speed) const {
    const double over = yield_speed / speed;
    return over < 1.0 ? restitution * std::sqrt(std::sqrt(over)) : restitution;
  }
  /// @brief Velocity afterwards, away from the support. @param arriving < 0: towards it
  [[nodiscard]] double after(double arriving) const { return -ratio(-arriving) * arriving; }
  /// The same law for speeds in other units: metres per step if a step takes so many seconds.
  [[nodiscard]] ImpactLaw per_step(double step) const {
    return {.restitution = restitution, .yield_speed = yield_speed * step};
  }
};

/// @brief The impact law, and rest where the next hop would be lower than `hop_tolerance`, or where neither
/// velocity nor acceleration leads away.
/// @param hop_tolerance [m], >= 0
/// Source: docs/theory.md, "Impact, rest and release"
[[nodiscard]] ContactOutcome resolve_contact(const TouchingMass& mass, const ImpactLaw& law, double hop_tolerance);

}  // namespace udar
