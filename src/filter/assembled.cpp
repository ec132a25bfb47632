#include "udar/filter/assembled.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "udar/petsc/array.hpp"
#include "udar/petsc/error.hpp"
#include "udar/structure/matrix_file.hpp"

namespace udar {

AssembledOperator::AssembledOperator(Mat stiffness, const MassPoints& points, double filter_frequency,
                                     Translation translation)
    : wf2_{filter_frequency * filter_frequency}, mass_(points.mass().begin(), points.mass().end()) {
  UDAR_CALL(PetscObjectGetComm(reinterpret_cast<PetscObject>(stiffness), &comm_));
  for (std::size_t point = 0; point < mass_.size(); ++point) {
    fixed_.push_back(points.fixed(point));
  }
  collect(stiffness, points, translation);
  create_matrix(stiffness);
}

/// What the product with displacements of the points needs.
void AssembledOperator::collect(Mat stiffness, const MassPoints& points, Translation translation) {
  UDAR_CALL(MatCreateVecs(stiffness, given_.put(), nullptr));
  UDAR_CALL(VecSet(given_, 0.0));
  PetscInt begin = 0;
  PetscInt end = 0;
  UDAR_CALL(MatGetOwnershipRange(stiffness, &begin, &end));
  // With what each column translates; 0: no point.
  const petsc::Vector group = [&] {
    petsc::Vector vector;
    UDAR_CALL(VecDuplicate(given_, vector.put()));
    const petsc::WriteArray values{vector};
    for (std::size_t point = 0; point < mass_.size(); ++point) {
      values.values()[point] =
          translation == Translation::of_all ? 1.0 : 1.0 + static_cast<double>(points.direction(point));
    }
    std::fill(values.values() + mass_.size(), values.values() + (end - begin), 0.0);
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
  UDAR_CALL(VecScatterBegin(gather_, group, needed_, INSERT_VALUES, SCATTER_FORWARD));
  UDAR_CALL(VecScatterEnd(gather_, group, needed_, INSERT_VALUES, SCATTER_FORWARD));
  const petsc::ReadArray groups{needed_};
  std::size_t next = 0;
  for (PetscInt row = begin; row < end; ++row) {
    const std::size_t first = next;
    while (next < entries.size() && entries[next].row == row) {
      ++next;
    }
    add_row(row, std::span{entries}.subspan(first, next - first), columns, groups.values());
  }
  first_group_.push_back(groups_.size());
}

/// @param groups of each of the columns gathered
void AssembledOperator::add_row(PetscInt row, std::span<const MatrixEntry> entries, std::span<const PetscInt> columns,
                                const double* groups) {
  // Sums that are rounding of what is summed up, by whoever assembled it, are none.
  constexpr double kRounding = 16.0 * std::numeric_limits<double>::epsilon();
  constexpr int kGroups = 1 + static_cast<int>(Direction::z);
  const auto place_of = [&](PetscInt column) {
    return static_cast<std::size_t>(std::ranges::lower_bound(columns, column) - columns.begin());
  };
  const std::size_t own = place_of(row);
  std::vector<std::size_t> places;
  for (const MatrixEntry& entry : entries) {
    places.push_back(place_of(entry.column));
  }
  first_group_.push_back(groups_.size());
  for (int number = 1; number <= kGroups; ++number) {
    const auto wanted = static_cast<double>(number);
    // Any reference is right; a point's own displacement, or that of one beside it, is near.
    const std::size_t none = columns.size();
    Group group{.first = entries_.size(), .near = groups[own] == wanted ? own : none};
    long double sum = 0.0;
    long double size = 0.0;
    for (std::size_t k = 0; k < entries.size(); ++k) {
      if (groups[places[k]] != wanted) {
        continue;
      }
      sum += entries[k].value;
      size += std::abs(entries[k].value);
      group.near = group.near == none ? places[k] : group.near;
      if (places[k] != own) {
        entries_.push_back({.column = places[k], .value = entries[k].value});
      }
    }
    group.last = entries_.size();
    group.sum = std::abs(sum) <= kRounding * size ? 0.0 : static_cast<double>(sum);
    if (group.near != none) {
      groups_.push_back(group);
    }
  }
}

/// S (wf^2 M + C) S, with powers of two in S: scaled entries keep their digits.
void AssembledOperator::create_matrix(Mat stiffness) {
  petsc::Vector diagonal;
  UDAR_CALL(VecDuplicate(given_, diagonal.put()));
  UDAR_CALL(MatGetDiagonal(stiffness, diagonal));
  UDAR_CALL(MatDuplicate(stiffness, MAT_COPY_VALUES, matrix_.put()));
  {
    const petsc::WriteArray values{diagonal};
    PetscInt count = 0;
    UDAR_CALL(VecGetLocalSize(diagonal, &count));
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
      values.values()[i] += i < mass_.size() ? wf2_ * mass_[i] : 0.0;
      scale_.push_back(std::exp2(-std::round(0.5 * std::log2(values.values()[i]))));
    }
  }
  UDAR_CALL(MatDiagonalSet(matrix_, diagonal, INSERT_VALUES));
  {
    const petsc::WriteArray values{diagonal};
    std::ranges::copy(scale_, values.values());
  }
  UDAR_CALL(MatDiagonalScale(matrix_, diagonal, diagonal));
  UDAR_CALL(PetscObjectSetName(reinterpret_cast<PetscObject>(static_cast<Mat>(matrix_)), "filtered_structure"));
  UDAR_CALL(MatSetOptionsPrefix(matrix_, "filter_"));
  UDAR_CALL(MatSetOption(matrix_, MAT_SYMMETRIC, PETSC_TRUE));
  UDAR_CALL(MatSetOption(matrix_, MAT_SPD, PETSC_TRUE));
}

double AssembledOperator::norm() const {
  double norm = 0.0;
  UDAR_CALL(MatNorm(matrix_, NORM_INFINITY, &norm));
  return norm;
}

void AssembledOperator::right_hand_side(const FilterColumn& column, std::span<double> values) const {
  {
    const petsc::WriteArray given{given_};
    std::copy_n(column.displacement, mass_.size(), given.values());
  }
  UDAR_CALL(VecScatterBegin(gather_, given_, needed_, INSERT_VALUES, SCATTER_FORWARD));
  UDAR_CALL(VecScatterEnd(gather_, given_, needed_, INSERT_VALUES, SCATTER_FORWARD));
  const petsc::ReadArray needed{needed_};
  const double* u = needed.values();
  for (std::size_t i = 0; i < values.size(); ++i) {
    double sum = 0.0;
    for (std::size_t g = first_group_[i]; g < first_group_[i + 1]; ++g) {
      const Group& group = groups_[g];
      const double near = u[group.near];
      double part = group.sum * near;
      for (std::size_t k = group.first; k < group.last; ++k) {
        part += entries_[k].value * (u[entries_[k].column] - near);
      }
      sum += part;
    }
    const double force = i < mass_.size() && column.force != nullptr ? column.force[i] : 0.0;
    values[i] = i < mass_.size() && fixed_[i] ? 0.0 : scale_[i] * (force - sum);
  }
}

void AssembledOperator::extract(std::span<const double> unknowns, const FilterColumn& column) const {
  for (std::size_t i = 0; i < mass_.size(); ++i) {
    column.stretch[i] = fixed_[i] ? -column.displacement[i] : scale_[i] * unknowns[i];
    if (column.internal != nullptr && fixed_[i]) {
      column.internal[i] = 0.0;
    } else if (column.internal != nullptr) {
      column.internal[i] = (column.force != nullptr ? column.force[i] : 0.0) - wf2_ * mass_[i] * column.stretch[i];
    }
  }
}

void AssembledOperator::unknowns_of(const FilterColumn& /*column*/, std::span<double> /*unknowns*/) const {
  throw InputError{"an assembled matrix is not solved by columns: not all of its unknowns have mass"};
}

double AssembledOperator::largest_unknown(const double* displacement) const {
  double largest = 0.0;
  for (std::size_t i = 0; i < mass_.size(); ++i) {
    largest = std::max(largest, fixed_[i] ? 0.0 : std::abs(displacement[i] / scale_[i]));
  }
  return largest;
}

void AssembledOperator::internal_of(std::span<const double> /*displacement*/, std::span<double> /*internal*/) {
  throw InputError{"filter frequency: none is for beams: no other structure is integrated without a filter"};
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
  for (std::size_t i = 0; i < mass_.size(); ++i) {
    energy += 0.5 * displacement[i] * internal[i];
  }
  return energy;
}

std::unique_ptr<ColumnSolver> AssembledOperator::with_springs(std::span<const ContactSpring> /*springs*/) const {
  throw InputError{"springs at contact points need the chain solver, and there is none for an assembled matrix"};
}

double AssembledOperator::points_moved_together(std::size_t /*point*/) const {
  throw InputError{"springs at contact points need the chain solver, and there is none for an assembled matrix"};
}

}  // namespace udar
