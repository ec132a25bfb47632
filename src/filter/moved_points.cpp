#include "udar/filter/moved_points.hpp"

#include <algorithm>
#include <utility>

#include "udar/filter/filtered_structure.hpp"
#include "udar/numerics/positive_inverse.hpp"
#include "udar/petsc/error.hpp"
#include "udar/structure/held_motion.hpp"

namespace udar {
namespace {

/// Sums of others' arrays. @param share of each
std::vector<double> combined(const std::vector<std::vector<double>>& arrays, std::span<const double> share) {
  std::vector<double> sum(arrays.front().size(), 0.0);
  for (std::size_t k = 0; k < arrays.size(); ++k) {
    for (std::size_t i = 0; i < sum.size(); ++i) {
      sum[i] += share[k] * arrays[k][i];
    }
  }
  return sum;
}

}  // namespace

MovedPoints::MovedPoints(FilteredStructure& released, std::span<const std::size_t> points) {
  const std::size_t size = points.size();
  const std::size_t count = released.mass().size();
  const std::vector<double> none(count, 0.0);
  // A force of 1 N on each: where it takes the line.
  std::vector<std::vector<double>> line(size, std::vector<double>(count));
  std::vector<std::vector<double>> internal(size,
                                            std::vector<double>(count * released.filter_operator().internal_numbers()));
  std::vector<double> compliance(size * size, 0.0);
  for (std::size_t k = 0; k < size; ++k) {
    std::vector<double> force(count, 0.0);
    if (points[k] != MovedPoint::kElsewhere) {
      force[points[k]] = 1.0;
    }
    released.solve(none, force, line[k], internal[k]);
    for (std::size_t other = 0; other < size; ++other) {
      compliance[other * size + k] = points[other] != MovedPoint::kElsewhere ? line[k][points[other]] : 0.0;
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, compliance.data(), static_cast<int>(compliance.size()), MPI_DOUBLE, MPI_SUM,
                released.points().comm());
  stiffness_ = std::move(compliance);
  if (!invert_positive(stiffness_, size)) {
    throw SolveError{"places that move by themselves depend on each other: one of them cannot move alone"};
  }
  for (std::size_t k = 0; k < size; ++k) {
    const bool here = points[k] != MovedPoint::kElsewhere;
    const std::span<const double> share = std::span{stiffness_}.subspan(k * size, size);
    shapes_.push_back({.point = here ? points[k] : 0,
                       .here = here,
                       .line = combined(line, share),
                       .internal = combined(internal, share)});
    for (std::size_t other = 0; other < size; ++other) {
      if (points[other] != MovedPoint::kElsewhere) {
        shapes_.back().line[points[other]] = other == k ? 1.0 : 0.0;
      }
    }
  }
}

std::span<const FilterColumn> MovedPoints::at_rest(std::size_t points, std::span<const FilterColumn> columns) {
  columns_.assign(columns.begin(), columns.end());
  displacement_.resize(std::max(displacement_.size(), columns.size()));
  for (std::size_t c = 0; c < columns.size(); ++c) {
    displacement_[c].assign(columns[c].displacement, columns[c].displacement + points);
    for (const Shape& shape : shapes_) {
      if (shape.here) {
        displacement_[c][shape.point] = 0.0;
      }
    }
    columns_[c].displacement = displacement_[c].data();
  }
  return columns_;
}

void MovedPoints::apply(MPI_Comm comm, std::size_t points, std::size_t internal_numbers,
                        std::span<const FilterColumn> columns) const {
  std::vector<double> moved(columns.size() * shapes_.size(), 0.0);
  for (std::size_t c = 0; c < columns.size(); ++c) {
    for (std::size_t k = 0; k < shapes_.size(); ++k) {
      if (shapes_[k].here && columns[c].force != nullptr) {
        moved[c * shapes_.size() + k] = columns[c].force[shapes_[k].point];
      }
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, moved.data(), static_cast<int>(moved.size()), MPI_DOUBLE, MPI_SUM, comm);
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const FilterColumn& column = columns[c];
    for (std::size_t k = 0; k < shapes_.size(); ++k) {
      const double by = moved[c * shapes_.size() + k];
      for (std::size_t i = 0; by != 0.0 && i < points; ++i) {
        column.stretch[i] += by * shapes_[k].line[i];
      }
      for (std::size_t i = 0; by != 0.0 && column.internal != nullptr && i < points * internal_numbers; ++i) {
        column.internal[i] += by * shapes_[k].internal[i];
      }
    }
    for (std::size_t k = 0; k < shapes_.size(); ++k) {
      if (shapes_[k].here) {
        column.stretch[shapes_[k].point] = moved[c * shapes_.size() + k] - column.displacement[shapes_[k].point];
      }
    }
  }
}

}  // namespace udar
