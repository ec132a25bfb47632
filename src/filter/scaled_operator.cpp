#include "udar/filter/scaled_operator.hpp"

#include <algorithm>
#include <cmath>

#include "udar/petsc/array.hpp"
#include "udar/petsc/error.hpp"

namespace udar {

ScaledOperator::ScaledOperator(MPI_Comm comm, const MassPoints& points, double filter_frequency)
    : comm_{comm}, wf2_{filter_frequency * filter_frequency}, mass_(points.mass().begin(), points.mass().end()) {
  for (std::size_t point = 0; point < mass_.size(); ++point) {
    fixed_.push_back(points.fixed(point));
  }
}

void ScaledOperator::set_scale(std::span<const double> diagonal) {
  scale_.clear();
  for (std::size_t i = 0; i < diagonal.size(); ++i) {
    scale_.push_back(std::exp2(-std::round(0.5 * std::log2(diagonal[i] + ground(i)))));
  }
}

petsc::Matrix ScaledOperator::assembled(Mat stiffness) const {
  petsc::Vector diagonal;
  petsc::Matrix matrix;
  UDAR_CALL(MatCreateVecs(stiffness, diagonal.put(), nullptr));
  UDAR_CALL(MatGetDiagonal(stiffness, diagonal));
  UDAR_CALL(MatDuplicate(stiffness, MAT_COPY_VALUES, matrix.put()));
  {
    const petsc::WriteArray values{diagonal};
    for (std::size_t i = 0; i < scale_.size(); ++i) {
      values.values()[i] += ground(i);
    }
  }
  UDAR_CALL(MatDiagonalSet(matrix, diagonal, INSERT_VALUES));
  {
    const petsc::WriteArray values{diagonal};
    std::ranges::copy(scale_, values.values());
  }
  UDAR_CALL(MatDiagonalScale(matrix, diagonal, diagonal));
  UDAR_CALL(PetscObjectSetName(reinterpret_cast<PetscObject>(static_cast<Mat>(matrix)), "filtered_structure"));
  UDAR_CALL(MatSetOptionsPrefix(matrix, "filter_"));
  UDAR_CALL(MatSetOption(matrix, MAT_SYMMETRIC, PETSC_TRUE));
  UDAR_CALL(MatSetOption(matrix, MAT_SPD, PETSC_TRUE));
  return matrix;
}

void ScaledOperator::extract_stretch(std::span<const double> unknowns, const FilterColumn& column) const {
  for (std::size_t i = 0; i < mass_.size(); ++i) {
    column.stretch[i] = fixed_[i] ? -column.displacement[i] : scale_[i] * unknowns[i];
  }
}

double ScaledOperator::largest_unknown(const double* displacement) const {
  double largest = 0.0;
  for (std::size_t i = 0; i < mass_.size(); ++i) {
    largest = std::max(largest, fixed_[i] ? 0.0 : std::abs(displacement[i] / scale_[i]));
  }
  return largest;
}

void ScaledOperator::internal_of(const FilterColumn& /*column*/) {
  throw InputError{"filter frequency: none is not for assembled matrices: they are not integrated without a filter"};
}

std::unique_ptr<ColumnSolver> ScaledOperator::with_springs(std::span<const ContactSpring> /*springs*/) const {
  throw InputError{"springs at contact points need the chain solver, and there is none for an assembled matrix"};
}

double ScaledOperator::points_moved_together(std::size_t /*point*/) const {
  throw InputError{"springs at contact points need the chain solver, and there is none for an assembled matrix"};
}

}  // namespace udar
