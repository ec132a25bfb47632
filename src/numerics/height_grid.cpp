#include "udar/numerics/height_grid.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <utility>

#include "udar/petsc/error.hpp"

namespace udar {
namespace {

constexpr double kBeyond = 1e-9;  // of the grid's length: places typed with ten digits still are on its edge

/// What makes the value at a place on an axis, and the derivative there, of the values at some points side by side.
struct Stencil {
  std::size_t first = 0;
  std::size_t count = 0;
  std::array<double, 4> value{};
  std::array<double, 4> slope{};
};

/// Adds a factor times the slope at a point, of the parabola through the three points that are next to it.
void add_slope(std::span<const double> axis, std::size_t point, double factor, std::size_t first,
               std::array<double, 4>& weights) {
  const std::size_t points = std::min<std::size_t>(axis.size(), 3);
  const std::size_t from = std::min(point > 0 ? point - 1 : 0, axis.size() - points);
  for (std::size_t i = from; i < from + points; ++i) {
    double slope = 0.0;  // of the polynomial that is 1 at point i and 0 at the others
    for (std::size_t k = from; k < from + points; ++k) {
      double product = k == i ? 0.0 : 1.0 / (axis[i] - axis[k]);
      for (std::size_t j = from; j < from + points; ++j) {
        product *= j == i || j == k ? 1.0 : (axis[point] - axis[j]) / (axis[i] - axis[j]);
      }
      slope += product;
    }
    weights.at(i - first) += factor * slope;
  }
}

std::optional<Stencil> stencil_at(std::span<const double> axis, double at) {
  const double beyond = kBeyond * (axis.back() - axis.front());
  if (!(at >= axis.front() - beyond && at <= axis.back() + beyond)) {
    return std::nullopt;
  }
  const auto after = static_cast<std::size_t>(std::ranges::upper_bound(axis, at) - axis.begin());
  const std::size_t right = std::clamp<std::size_t>(after, 1, axis.size() - 1);
  const std::size_t left = right - 1;
  Stencil stencil{.first = left > 0 ? left - 1 : 0};
  stencil.count = std::min(right + 2, axis.size()) - stencil.first;
  const double length = axis[right] - axis[left];
  const double s = std::clamp((at - axis[left]) / length, 0.0, 1.0);
  // Hermite's cubics of 0 <= s <= 1, for the values at both ends and the slopes there.
  const double rise = s * s * (3.0 - 2.0 * s);
  const double rise_slope = 6.0 * s * (1.0 - s) / length;
  stencil.value.at(left - stencil.first) += 1.0 - rise;
  stencil.value.at(right - stencil.first) += rise;
  stencil.slope.at(left - stencil.first) -= rise_slope;
  stencil.slope.at(right - stencil.first) += rise_slope;
  add_slope(axis, left, length * s * (1.0 - s) * (1.0 - s), stencil.first, stencil.value);
  add_slope(axis, right, -length * s * s * (1.0 - s), stencil.first, stencil.value);
  add_slope(axis, left, (1.0 - s) * (1.0 - 3.0 * s), stencil.first, stencil.slope);
  add_slope(axis, right, s * (3.0 * s - 2.0), stencil.first, stencil.slope);
  return stencil;
}

bool is_axis(const std::vector<double>& axis) {
  return axis.size() >= 2 && std::ranges::all_of(axis, [](double value) { return std::isfinite(value); }) &&
         std::ranges::adjacent_find(axis, std::ranges::greater_equal{}) == axis.end();
}

}  // namespace

HeightGrid::HeightGrid(std::vector<double> x, std::vector<double> z, std::vector<double> height)
    : x_{std::move(x)}, z_{std::move(z)}, height_{std::move(height)} {
  if (!is_axis(x_) || !is_axis(z_) || height_.size() != x_.size() * z_.size() ||
      std::ranges::any_of(height_, [](double value) { return std::isinf(value); })) {
    throw InputError{"height grid: expected two or more places along x and z, ascending, and a height for each pair"};
  }
}

std::optional<HeightGrid::Surface> HeightGrid::at(double x, double z) const {
  const auto across = stencil_at(x_, x);
  const auto along = stencil_at(z_, z);
  if (!across || !along) {
    return std::nullopt;
  }
  Surface surface;
  for (std::size_t j = 0; j < along->count; ++j) {
    double height = 0.0;
    double slope = 0.0;
    for (std::size_t i = 0; i < across->count; ++i) {
      const double given = height_[(along->first + j) * x_.size() + across->first + i];
      height += across->value.at(i) * given;
      slope += across->slope.at(i) * given;
    }
    surface.height += along->value.at(j) * height;
    surface.along_x += along->value.at(j) * slope;
    surface.along_z += along->slope.at(j) * height;
  }
  return std::isnan(surface.height) ? std::nullopt : std::optional{surface};
}

double HeightGrid::highest() const {
  double highest = -std::numeric_limits<double>::infinity();
  for (const double height : height_) {
    highest = std::max(highest, height);  // one that is not a number changes nothing
  }
  return highest;
}

}  // namespace udar
