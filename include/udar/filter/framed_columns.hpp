#pragma once
/// @file
/// Columns of nodes whose points move along axes of their own, as the structure's unknowns have them.

#include <array>
#include <span>
#include <vector>

#include "udar/filter/filter_column.hpp"
#include "udar/structure/mass_points.hpp"

namespace udar {

/// @brief Turns displacements and forces into the axes of the unknowns, and stretches back. Internal numbers are always
/// those of the structure.
class FramedColumns {
 public:
  /// @param points must live as long
  explicit FramedColumns(const MassPoints& points) : points_{&points} {}

  [[nodiscard]] bool none() const noexcept { return points_->frames().empty(); }
  /// The same columns with displacement and force as the unknowns have them, valid until the next call.
  [[nodiscard]] std::span<const FilterColumn> of_unknowns(std::span<const FilterColumn> columns);
  /// Turns stretches of the unknowns into those of the points, in place.
  void stretches_of_points(std::span<const FilterColumn> columns) const;

 private:
  const MassPoints* points_;
  std::vector<FilterColumn> columns_;
  std::array<std::vector<std::vector<double>>, 2> values_;  // displacements and forces, by column
};

}  // namespace udar
