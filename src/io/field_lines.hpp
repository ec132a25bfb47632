#pragma once
/// @file
/// Height fields as lines, for pictures.

#include <cstddef>
#include <vector>

#include "udar/numerics/height_grid.hpp"
#include "udar/structure/mass_points.hpp"

namespace udar::io {

/// Some of the columns and rows of a field, along x and z, its ends among them.
struct FieldGrid {
  std::vector<std::size_t> columns;
  std::vector<std::size_t> rows;
};

/// @brief What of a field is next to a structure, at most some dozens each way.
[[nodiscard]] FieldGrid grid_of(const HeightGrid& field, const Region& around);

/// @brief Lines over a field along x and along z, those of `grid_of`; places without a height part them. @param base
/// what is added to the heights [m]
[[nodiscard]] std::vector<std::vector<Place>> field_lines(const HeightGrid& field, double base, const Region& around);

}  // namespace udar::io
