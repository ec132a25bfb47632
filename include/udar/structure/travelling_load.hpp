#pragma once
/// @file
/// Forces that travel along a beam.

#include <memory>
#include <span>
#include <vector>

#include "udar/structure/time_table.hpp"

namespace udar {

/// @brief Forces one behind the other that travel along a straight beam at one speed, as the axles of a train do.
struct TravellingLoad {
  std::vector<double> offset;  ///< how far each is behind the one that enters at `start` [m], >= 0
  std::vector<double> force;   ///< [N], y up, as many
  double speed = 0.0;          ///< [m/s], not 0; negative: from the right end to the left
  double start = 0.0;          ///< when an offset of 0 enters the beam [s]
};

/// @brief What travelling forces are on the nodes: a table for each [N]. A force between two nodes is dealt to both, so
/// that force and moment are kept; at constant speed each share is linear in time. Where a force enters the beam, and
/// where it leaves, it jumps.
/// @param x of all nodes from left to right, strictly ascending [m]
/// @throws InputError if numbers are not finite, the speed is 0, or there are too many rows
[[nodiscard]] std::vector<std::shared_ptr<const TimeTable>> node_tables(const TravellingLoad& load,
                                                                        std::span<const double> x);

}  // namespace udar
