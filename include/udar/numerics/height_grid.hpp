#pragma once
/// @file
/// A height over x and z, given at the points of a grid.

#include <optional>
#include <span>
#include <vector>

namespace udar {

/// @brief A height at the points of a rectangular grid, and a surface with continuous slopes through them: cubic
/// between two points along x and along z, with the slope at each of the parabola through it and its neighbours. It is
/// that surface itself where the heights are those of a parabola, and bilinear on two points along each axis.
class HeightGrid {
 public:
  /// @brief The surface at a place.
  struct Surface {
    double height = 0.0;   ///< [m]
    double along_x = 0.0;  ///< slope dh/dx [-]
    double along_z = 0.0;  ///< slope dh/dz [-]
  };

  /// @param x, z two or more each, strictly ascending [m]
  /// @param height of all x at the first z, then at the next [m]; not a number: there is none
  /// @throws InputError if these do not fit
  HeightGrid(std::vector<double> x, std::vector<double> z, std::vector<double> height);

  /// None beside the grid, or where one of the heights it is made of is none.
  [[nodiscard]] std::optional<Surface> at(double x, double z) const;

  [[nodiscard]] std::span<const double> x() const noexcept { return x_; }
  [[nodiscard]] std::span<const double> z() const noexcept { return z_; }
  [[nodiscard]] std::span<const double> height() const noexcept { return height_; }
  [[nodiscard]] double highest() const;  ///< of the heights that are given [m]

 private:
  std::vector<double> x_;
  std::vector<double> z_;
  std::vector<double> height_;
};

}  // namespace udar
