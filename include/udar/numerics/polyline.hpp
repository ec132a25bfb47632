#pragma once
/// @file
/// Values given at points, linear between them.

#include <span>

namespace udar {

/// @brief Linear between the points, constant beyond them; zero without points.
/// @param x strictly ascending @param y as many
[[nodiscard]] double interpolate(std::span<const double> x, std::span<const double> y, double at);

}  // namespace udar
