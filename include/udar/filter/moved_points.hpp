#pragma once
/// @file
/// Coordinates of a structure that something holds and moves.

#include <mpi.h>

#include <cstddef>
#include <span>
#include <vector>

#include "udar/filter/filter_column.hpp"

namespace udar {

class FilteredStructure;

/// @brief Adds to a solve, in which held coordinates stay where they are, what their motion does to the line; the force
/// that a column has at such a coordinate is its displacement [m]. Source: docs/theory.md, "Motion of held places"
class MovedPoints {
 public:
  /// What one of them does to the line if it moves by 1 m and no mass does.
  struct Shape {
    std::size_t point = 0;         ///< local, of this rank if `here`
    bool here = false;             ///< whether this rank has it
    std::vector<double> line;      ///< Yc [-], local points
    std::vector<double> internal;  ///< internal forces of each [1/m]
  };

  MovedPoints() = default;
  /// @param released the same structure with nothing that holds these coordinates @param points of all ranks in one
  /// order: local, or none of this rank's, `MovedPoint::kElsewhere`
  /// @note Collective: a solve for each. @throws SolveError if one of them is not free to move there
  MovedPoints(FilteredStructure& released, std::span<const std::size_t> points);

  [[nodiscard]] bool empty() const noexcept { return shapes_.empty(); }
  [[nodiscard]] std::span<const Shape> shapes() const noexcept { return shapes_; }
  /// Force on one of them, by rows, that holds them while one by one they move by 1 m and no mass does [N/m]; equal on
  /// every rank.
  [[nodiscard]] std::span<const double> stiffness() const noexcept { return stiffness_; }

  /// @brief The same columns with masses at these coordinates where they are held. @param points local ones of all
  /// @return valid until the next call
  [[nodiscard]] std::span<const FilterColumn> at_rest(std::size_t points, std::span<const FilterColumn> columns);
  /// @param columns as given to `at_rest`, their results solved by it
  /// @note Collective: one reduction of as many numbers a column as there are coordinates.
  void apply(MPI_Comm comm, std::size_t points, std::size_t internal_numbers,
             std::span<const FilterColumn> columns) const;

 private:
  std::vector<Shape> shapes_;
  std::vector<double> stiffness_;
  std::vector<FilterColumn> columns_;              // at rest
  std::vector<std::vector<double>> displacement_;  // theirs
};

}  // namespace udar
