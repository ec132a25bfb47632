#pragma once
/// @file
/// The internal forces of a bending line.

#include <array>

#include "udar/structure/field.hpp"

namespace udar {

/// @brief Bending moment EI w'' at the points; shear force dM/dx in the element right of each, 0 where there is none.
inline constexpr std::array kBendingFields{
    FieldInfo{.name = "moment", .unit = "N m", .extremes = true, .label = "bending moment"},
    FieldInfo{.name = "shear", .unit = "N", .where = Where::cells, .extremes = true, .label = "shear force"}};

}  // namespace udar
