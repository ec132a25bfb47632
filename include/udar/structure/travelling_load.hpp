#pragma once
/// @file
/// Forces and masses that travel along a beam.

#include <cmath>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "udar/structure/time_table.hpp"

namespace udar {

/// @brief Forces one behind the other that travel along a straight beam at one speed, as the axles of a train do, and
/// masses that the beam carries there.
struct TravellingLoad {
  std::vector<double> offset;       ///< how far each is behind the one that enters at `start` [m], >= 0
  std::vector<double> force;        ///< [N], y up, as many
  double speed = 0.0;               ///< [m/s], not 0; negative: from the right end to the left
  double start = 0.0;               ///< when an offset of 0 enters the beam [s]
  std::vector<double> mass{};       ///< [kg], >= 0, whose weight is not in `force`; as many, or empty: none
  std::vector<double> stiffness{};  ///< of the spring that each mass stands on [N/m], 0: none; as many, or empty: none

  [[nodiscard]] double mass_of(std::size_t axle) const { return mass.empty() ? 0.0 : mass[axle]; }
  [[nodiscard]] double stiffness_of(std::size_t axle) const { return stiffness.empty() ? 0.0 : stiffness[axle]; }
};

/// When an axle has gone so far from where the first one is at the start [s]. @param way [m]
[[nodiscard]] inline double arrival_of(double start, double way, double speed) { return start + way / std::abs(speed); }

/// @throws InputError if numbers are not finite, the speed is 0, a mass or a stiffness is negative, or there are too
/// many axles for so many nodes
void require_sound(const TravellingLoad& load, std::size_t nodes);

/// @brief What travelling forces are on the nodes: a table for each [N]. A force between two nodes is dealt to both, so
/// that force and moment are kept; at constant speed each share is linear in time. Where a force enters the beam, and
/// where it leaves, it jumps.
/// @param x of all nodes from left to right, strictly ascending [m]
/// @throws InputError as `require_sound`
[[nodiscard]] std::vector<std::shared_ptr<const TimeTable>> node_tables(const TravellingLoad& load,
                                                                        std::span<const double> x);

}  // namespace udar
