#include "udar/filter/framed_columns.hpp"

#include <algorithm>

namespace udar {
namespace {

std::array<double, 3> values_of(const Place& axis) { return {axis.x, axis.y, axis.z}; }

/// Numbers of points from their nodes' own axes to x, y, z, or back.
void turn(std::span<const NodeFrame> frames, bool back, double* values) {
  for (const auto& [points, axes] : frames) {
    std::array<double, 3> turned{};
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t i = 0; i < 3; ++i) {
        turned.at(back ? k : i) += values_of(axes.at(k)).at(i) * values[points.at(back ? i : k)];
      }
    }
    for (std::size_t k = 0; k < 3; ++k) {
      values[points.at(k)] = turned.at(k);
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
    turn(points_->frames(), false, values.data());
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
    turn(points_->frames(), true, column.stretch);
  }
}

}  // namespace udar
