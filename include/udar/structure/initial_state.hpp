#pragma once
/// @file
/// How the beam starts.

#include <vector>

#include "udar/structure/beam_chain.hpp"

namespace udar {

/// @brief The reference axis and the motion at t = 0; held ends start at rest on the axis.
struct InitialState {
  double height = 0.0;            ///< of the axis at mid-length above y = 0 [m]
  double slope = 0.0;             ///< of the axis [-]
  double velocity = 0.0;          ///< of all masses, y up [m/s]
  double angular_velocity = 0.0;  ///< about mid-length, counter-clockwise [rad/s]
  /// A shape added to the axis, linear between its points, constant beyond them; may be empty.
  struct Shape {
    std::vector<double> x;         ///< [m], strictly ascending
    std::vector<double> offset;    ///< [m]
    std::vector<double> velocity;  ///< [m/s], empty: none
  };
  Shape shape{};

  /// Height of the reference axis at x [m].
  [[nodiscard]] double axis(double x, double beam_length) const { return height + slope * (x - 0.5 * beam_length); }
};

/// @brief Ym and Vm of this rank's nodes at t = 0.
struct MassState {
  std::vector<double> position;  ///< [m]
  std::vector<double> velocity;  ///< [m/s]
};
[[nodiscard]] MassState initial_masses(const BeamChain& beam, const InitialState& initial);

}  // namespace udar
