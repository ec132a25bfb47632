#include "udar/filter/framed_columns.hpp"

#include <algorithm>

namespace udar {
namespace {

/// Numbers of points along their nodes' own axes, in place, as those along x, y, z.
void turn(std::span<const NodeFrame> frames, double* values) {
  for (const auto& [points, axes] : frames) {
    const auto& [a, b, c] = axes;
    const std::array<double, 3> own{values[points[0]], values[points[1]], values[points[2]]};
    values[points[0]] = a.x * own[0] + b.x * own[1] + c.x * own[2];
    values[points[1]] = a.y * own[0] + b.y * own[1] + c.y * own[2];
    values[points[2]] = a.z * own[0] + b.z * own[1] + c.z * own[2];
  }
}

/// The way back.
void turn_back(std::span<const NodeFrame> frames, double* values) {
  for (const auto& [points, axes] : frames) {
    const std::array<double, 3> along{values[points[0]], values[points[1]], values[points[2]]};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto& [x, y, z] = axes[k];
      values[points[k]] = x * along[0] + y * along[1] + z * along[2];
    }
  }
}

}  // namespace

std::span<const FilterColumn> FramedColumns::of_unknowns(std::span<const FilterColumn> columns) {
  columns_.assign(columns.begin(), columns.end());
  const auto turned = [&](std::size_t which, std::size_t c, const double* given) -> const double* {
    if (given == nullptr) {
      return nullptr;
    }
    values_.at(which).resize(std::max(values_.at(which).size(), columns.size()));
    std::vector<double>& values = values_.at(which)[c];
    values.assign(given, given + points_->coordinates());
    turn(points_->frames(), values.data());
    return values.data();
  };
  for (std::size_t c = 0; c < columns.size(); ++c) {
    columns_[c].displacement = turned(0, c, columns[c].displacement);
    columns_[c].force = turned(1, c, columns[c].force);
  }
  return columns_;
}

void FramedColumns::stretches_of_points(std::span<const FilterColumn> columns) const {
  for (const FilterColumn& column : columns) {
    turn_back(points_->frames(), column.stretch);
  }
}

}  // namespace udar
