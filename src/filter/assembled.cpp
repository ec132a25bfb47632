#include "udar/filter/assembled.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "udar/petsc/array.hpp"
#include "udar/petsc/error.hpp"
#include "udar/structure/matrix_file.hpp"

namespace udar {

AssembledOperator::AssembledOperator(Mat stiffness, const MassPoints& points, double filter_frequency)
    : ScaledOperator{points.comm(), points, filter_frequency} {
  collect(stiffness);
  petsc::Vector diagonal;
  PetscInt count = 0;
  UDAR_CALL(VecDuplicate(given_, diagonal.put()));
  UDAR_CALL(MatGetDiagonal(stiffness, diagonal));
  UDAR_CALL(VecGetLocalSize(diagonal, &count));
  {
    const petsc::ReadArray values{diagonal};
    set_scale({values.values(), static_cast<std::size_t>(count)});
  }
  matrix_ = assembled(stiffness);
}

/// What the product with displacements of the points needs.
void AssembledOperator::collect(Mat stiffness) {
  UDAR_CALL(MatCreateVecs(stiffness, given_.put(), nullptr));
  UDAR_CALL(VecSet(given_, 0.0));
  PetscInt begin = 0;
  PetscInt end = 0;
  UDAR_CALL(MatGetOwnershipRange(stiffness, &begin, &end));
  const petsc::Vector is_point = [&] {
    petsc::Vector vector;
    UDAR_CALL(VecDuplicate(given_, vector.put()));
    const petsc::WriteArray values{vector};
    std::fill_n(values.values(), mass().size(), 1.0);
    std::fill(values.values() + mass().size(), values.values() + (end - begin), 0.0);
    return vector;
  }();
  const std::vector<MatrixEntry> entries = local_entries(stiffness);
  std::vector<PetscInt> columns;
  for (PetscInt row = begin; row < end; ++row) {
    columns.push_back(row);
  }
  for (const MatrixEntry& entry : entries) {
    columns.push_back(entry.column);
  }
  std::ranges::sort(columns);
  columns.erase(std::ranges::unique(columns).begin(), columns.end());
  const auto count = static_cast<PetscInt>(columns.size());
  petsc::IndexSet from;
  UDAR_CALL(ISCreateGeneral(PETSC_COMM_SELF, count, columns.data(), PETSC_COPY_VALUES, from.put()));
  UDAR_CALL(VecCreateSeq(PETSC_COMM_SELF, count, needed_.put()));
  UDAR_CALL(VecScatterCreate(given_, from, needed_, nullptr, gather_.put()));
  UDAR_CALL(VecScatterBegin(gather_, is_point, needed_, INSERT_VALUES, SCATTER_FORWARD));
  UDAR_CALL(VecScatterEnd(gather_, is_point, needed_, INSERT_VALUES, SCATTER_FORWARD));
  const petsc::ReadArray points{needed_};
  std::size_t next = 0;
  for (PetscInt row = begin; row < end; ++row) {
    const std::size_t first = next;
    while (next < entries.size() && entries[next].row == row) {
      ++next;
    }
    add_row(row, std::span{entries}.subspan(first, next - first), columns, points.values());
  }
}

/// @param points of each of the columns gathered, 1 if it is one
void AssembledOperator::add_row(PetscInt row, std::span<const MatrixEntry> entries, std::span<const PetscInt> columns,
                                const double* points) {
  // Sums that are rounding of what is summed up, by whoever assembled it, are none.
  constexpr double kRounding = 16.0 * std::numeric_limits<double>::epsilon();
  const auto place_of = [&](PetscInt column) {
    return static_cast<std::size_t>(std::ranges::lower_bound(columns, column) - columns.begin());
  };
  const std::size_t own = place_of(row);
  // Any reference is right; a point's own displacement, or that of one beside it, is near.
  std::optional<std::size_t> near;
  if (points[own] != 0.0) {
    near = own;
  }
  Row added{.first = entries_.size()};
  long double sum = 0.0;
  long double size = 0.0;
  for (const MatrixEntry& entry : entries) {
    const std::size_t place = place_of(entry.column);
    if (points[place] == 0.0) {
      continue;
    }
    sum += entry.value;
    size += std::abs(entry.value);
    near = near.value_or(place);
    if (place != own) {
      entries_.push_back({.column = place, .value = entry.value});
    }
  }
  added.last = entries_.size();
  added.near = near.value_or(own);
  added.sum = std::abs(sum) <= kRounding * size ? 0.0 : static_cast<double>(sum);
  rows_.push_back(added);
}

double AssembledOperator::norm() const {
  double norm = 0.0;
  UDAR_CALL(MatNorm(matrix_, NORM_INFINITY, &norm));
  return norm;
}

void AssembledOperator::right_hand_side(const FilterColumn& column, std::span<double> values) const {
  {
    const petsc::WriteArray given{given_};
    std::copy_n(column.displacement, mass().size(), given.values());
  }
  UDAR_CALL(VecScatterBegin(gather_, given_, needed_, INSERT_VALUES, SCATTER_FORWARD));
  UDAR_CALL(VecScatterEnd(gather_, given_, needed_, INSERT_VALUES, SCATTER_FORWARD));
  const petsc::ReadArray needed{needed_};
  const double* u = needed.values();
  for (std::size_t i = 0; i < values.size(); ++i) {
    const Row& row = rows_[i];
    const double near = u[row.near];
    double sum = row.sum * near;
    for (std::size_t k = row.first; k < row.last; ++k) {
      sum += entries_[k].value * (u[entries_[k].column] - near);
    }
    const bool point = i < mass().size();
    const double force = point && column.force != nullptr ? column.force[i] : 0.0;
    values[i] = point && fixed(i) ? 0.0 : scale()[i] * (force - sum);
  }
}

void AssembledOperator::extract(std::span<const double> unknowns, const FilterColumn& column) const {
  extract_stretch(unknowns, column);
  for (std::size_t i = 0; column.internal != nullptr && i < mass().size(); ++i) {
    const double force = column.force != nullptr ? column.force[i] : 0.0;
    column.internal[i] = fixed(i) ? 0.0 : force - ground(i) * column.stretch[i];
  }
}

void AssembledOperator::unknowns_of(const FilterColumn& /*column*/, std::span<double> /*unknowns*/) const {
  throw InputError{"an assembled matrix is not solved by columns: not all of its unknowns have mass"};
}

std::span<const FieldInfo> AssembledOperator::internal_fields() const {
  static constexpr std::array kFields{FieldInfo{.name = "elastic_force", .unit = "N", .extremes = true}};
  return kFields;
}

void AssembledOperator::internal_values(std::span<const double> internal, std::span<double> values) const {
  std::ranges::copy(internal, values.begin());
}

double AssembledOperator::strain_energy(std::span<const double> displacement, std::span<const double> internal) const {
  double energy = 0.0;
  for (std::size_t i = 0; i < mass().size(); ++i) {
    energy += 0.5 * displacement[i] * internal[i];
  }
  return energy;
}

}  // namespace udar
