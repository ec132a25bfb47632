#pragma once
/// @file
/// Height fields as lines, for pictures.

#include <vector>

#include "udar/numerics/height_grid.hpp"
#include "udar/structure/mass_points.hpp"

namespace udar::io {

/// @brief Lines over a field along x and along z, as far as it is next to a structure, at most some dozens each way;
/// places without a height part them. @param base what is added to the heights [m]
[[nodiscard]] std::vector<std::vector<Place>> field_lines(const HeightGrid& field, double base, const Region& around);

}  // namespace udar::io
