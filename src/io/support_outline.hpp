#pragma once
/// @file
/// Planes of supports, for pictures.

#include <array>
#include <cstddef>

#include "udar/io/layout.hpp"
#include "udar/structure/mass_points.hpp"

namespace udar::io {

inline constexpr std::size_t kCorners = 4;

/// @brief The part of a support in space, a plane, that is next to a structure, or to the box of it that the plane
/// holds. @return its corners, in order around the normal
[[nodiscard]] std::array<Place, kCorners> outline_of(const RunLayout::Support& support, const Region& around);

}  // namespace udar::io
