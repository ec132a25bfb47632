#pragma once
/// @file
/// Which of a structure's nodes and cells have rows in the files.

#include <cstddef>
#include <span>
#include <vector>

#include "udar/io/output_choice.hpp"
#include "udar/structure/field.hpp"
#include "udar/structure/mass_points.hpp"

namespace udar::io {

/// @brief What is chosen of this rank's nodes and cells, ascending, and how that hangs together: corners count the
/// chosen nodes of all ranks.
struct ShownRows {
  std::vector<std::size_t> nodes;
  std::vector<std::size_t> cells;  ///< of a piece of several the first
  Topology topology;
};

/// @param a_point of each of this rank's nodes one of its points
/// @note Collective. @throws InputError if no cell is chosen, or cells that are no lines are to be strided over
[[nodiscard]] ShownRows choose_rows(const MassPoints& points, const Topology& topology,
                                    std::span<const std::size_t> a_point, const RowChoice& choice);

}  // namespace udar::io
