#pragma once
/// @file
/// Eigenvalues of small dense symmetric matrices.

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace udar {

/// @brief All eigenvalues of a symmetric matrix, ascending.
/// @param[in,out] matrix by rows, of `values.size()` squared; eigenvectors, by rows, afterwards
/// @throws SolveError if they are not found. Source: LAPACK's divide and conquer, dsyevd
void symmetric_eigen(std::span<double> matrix, std::span<double> values);

/// @brief The largest eigenvalue of A x = lambda B x, both symmetric; nothing if B is not positive definite.
/// @param a, b by rows, of `size` squared
[[nodiscard]] std::optional<double> largest_of_pencil(std::vector<double> a, std::vector<double> b, std::size_t size);

}  // namespace udar
