#pragma once
/// @file
/// Inverses of small dense matrices.

#include <cstddef>
#include <span>

namespace udar {

/// @brief Inverts a symmetric positive definite matrix in place. @param matrix by rows, of `order` squared; afterwards
/// both triangles are the inverse's @return whether it is positive definite; if not, nothing of it is of use
/// @note LAPACK's dpotrf and dpotri.
[[nodiscard]] bool invert_positive(std::span<double> matrix, std::size_t order);

}  // namespace udar
