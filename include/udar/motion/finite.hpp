#pragma once
/// @file
/// Whether a motion is still one of numbers, and where it is not.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "udar/motion/equations.hpp"
#include "udar/structure/structure.hpp"

namespace udar {

/// @brief A node as a user knows it.
struct NodeName {
  std::int64_t node = 0;  ///< its number in the user's model, as in the files
  double x = 0.0;         ///< [m]
};

/// The node of a local point. @note Not collective; it may look through the whole topology.
[[nodiscard]] NodeName name_of_node(const Structure& structure, std::size_t point);

/// The first of `values` that is infinite or not a number; their count if there is none.
[[nodiscard]] std::size_t first_not_finite(std::span<const double> values) noexcept;

/// @brief Ends a run whose masses have left the numbers.
/// @param position Ym [m] @param velocity Vm [m/s], of the local nodes @param since when they were still finite [s]
/// @note Collective: one reduction. @throws SolveError naming the first node of the lowest rank
void require_finite(const Equations& equations, std::span<const double> position, std::span<const double> velocity,
                    double since);

}  // namespace udar
