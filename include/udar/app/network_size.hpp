#pragma once
/// @file
/// A network in a few numbers, for people.

#include <cstddef>
#include <string>

#include "udar/structure/network.hpp"

namespace udar::app {

/// @brief How much of what there is, and where.
struct NetworkSize {
  std::size_t junctions = 0;
  std::size_t members = 0;
  std::size_t elements = 0;
  std::size_t unequal = 0;  ///< members of unequal elements
  double shortest = 0.0;    ///< element [m]
  std::string extent;       ///< "x 0 to 5 m, y 0 to 0 m, z -1 to 2 m", of the junctions
};

/// @note Not collective.
[[nodiscard]] NetworkSize size_of(const Network& network);

}  // namespace udar::app
