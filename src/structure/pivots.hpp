#pragma once
/// @file
/// What a Cholesky factorisation tells of a stiffness matrix.

#include <optional>
#include <vector>

#include "udar/structure/matrix_file.hpp"

namespace udar {

/// @brief Pivots of a symmetric matrix.
struct Pivots {
  std::optional<PetscInt> failed;  ///< the unknown whose pivot is not positive beyond rounding
  PetscInt small = 0;              ///< pivots next to nothing beside the diagonal
};

/// @brief Factors K + D on this rank by CHOLMOD. @param entries of K, at least its lower triangle
/// @param added D, one value per unknown
/// @throws SolveError if there is not memory enough
[[nodiscard]] Pivots pivots_of(const std::vector<MatrixEntry>& entries, const std::vector<double>& added);

}  // namespace udar
