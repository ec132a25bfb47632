#pragma once
/// @file
/// How the beam starts.

#include <cstddef>
#include <optional>
#include <vector>

#include "udar/structure/mass_points.hpp"

namespace udar {

/// @brief The reference axis and the motion at t = 0; fixed points start at rest on the axis, unless they are moved.
struct InitialState {
  double height = 0.0;            ///< of the axis at mid-length above y = 0 [m]
  double slope = 0.0;             ///< of the axis [-]
  double velocity = 0.0;          ///< of all masses, y up [m/s]
  double angular_velocity = 0.0;  ///< about mid-length and y = 0 of its own axes, or the pivot, counter-clockwise
                                  ///< [rad/s]
  double velocity_x = 0.0;        ///< of all masses that move in space [m/s]
  double velocity_z = 0.0;        ///< the same
  Place spin{};                   ///< about the centre of mass, or the pivot, along x, y, z [rad/s], of what moves in
                                  ///< space
  std::optional<Place> pivot{};   ///< about which the structure turns as a rigid body, in its own axes [m]
  /// A shape added to the axis, linear between its points, constant beyond them; may be empty.
  struct Shape {
    std::vector<double> x;         ///< [m], strictly ascending
    std::vector<double> offset;    ///< [m]
    std::vector<double> velocity;  ///< [m/s], empty: none
  };
  Shape shape{};
  /// Masses within a region in the structure's own axes, and the velocity that they have besides [m/s].
  struct Part {
    Region region{};
    Place velocity{};
  };
  std::vector<Part> parts{};
  /// A local point that something holds and moves, from the axis and from rest.
  struct Held {
    std::size_t point;
    double displacement;  ///< [m]
    double velocity;      ///< [m/s]
  };
  std::vector<Held> held{};

  [[nodiscard]] bool spins() const noexcept { return spin.x != 0.0 || spin.y != 0.0 || spin.z != 0.0; }
  /// Height of the reference axis at x, over where the structure stands in its own axes [m].
  [[nodiscard]] double axis(double x, const Extent& extent) const { return height + slope * (x - extent.middle()); }
};

/// @brief Ym and Vm of this rank's nodes at t = 0.
struct MassState {
  std::vector<double> position;  ///< [m]
  std::vector<double> velocity;  ///< [m/s]
};
/// @brief Where nothing strains the structure [m], one value per local point; 0 where it does not move along y.
[[nodiscard]] std::vector<double> reference_axis(const MassPoints& points, const InitialState& initial);
/// @note Collective with a spin, and with masses that travel, which start on the masses below them.
[[nodiscard]] MassState initial_masses(const MassPoints& points, const InitialState& initial);
/// @brief Refuses a shape of points that move along x or z, too.
/// @note Collective. @throws InputError on all ranks
void refuse_shape(const MassPoints& points, const InitialState& initial);
/// @brief Refuses a rotation about a pivot that would move what is held.
/// @note Collective. @throws InputError on all ranks
void refuse_torn(const MassPoints& points, const InitialState& initial);

}  // namespace udar
