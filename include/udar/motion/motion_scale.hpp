#pragma once
/// @file
/// How large a motion is: what the tolerances of integration and contact are relative to.

#include <algorithm>
#include <span>

#include "udar/contact/support.hpp"
#include "udar/motion/equations.hpp"
#include "udar/structure/initial_state.hpp"

namespace udar {

/// @brief How large the motion is; tolerances relative to it cost no steps where something crosses zero.
struct MotionScale {
  double length = 1.0;    ///< [m]
  double velocity = 1.0;  ///< [m/s]

  /// @brief Takes note of a speed that the masses have reached [m/s]. A scale that is right within ten will do: only
  /// a motion far larger than foreseen changes it.
  /// @param frequency no frequency of the masses is higher [rad/s] @return whether it changed
  bool grow(double speed, double frequency) {
    constexpr double kWithin = 0.1;
    if (!(kWithin * speed > velocity)) {
      return false;
    }
    velocity = kWithin * speed;
    length = std::max(length, velocity / frequency);
    return true;
  }
};

/// @brief The scale of the motion to come: speeds and offsets from the axis at the start, the fall to the supports, the
/// sag under gravity, supports that move, and loads up to the end of the run. What builds up slowly is left to `grow`.
/// Source: docs/theory.md, "The scale of the motion"
/// @param runs nodes under supports, whoever touches @param end of the run [s]
/// @note Collective: at most two line solves, the line free.
/// @throws InputError naming the option that asks for places too far away to resolve the beam in double precision
[[nodiscard]] MotionScale motion_scale(Equations& equations, const InitialState& initial,
                                       std::span<const ContactSet> sets, double end);

}  // namespace udar
