#pragma once
/// @file
/// A small dense model of the lumped beam, built apart from the library: C = T' S^-1 T entry by entry.

#include <cstddef>
#include <vector>

#include "udar/structure/beam_chain.hpp"

namespace udar::test {

/// @brief A dense square matrix, row by row.
struct Dense {
  std::size_t size = 0;
  std::vector<double> values;

  explicit Dense(std::size_t n) : size{n}, values(n * n, 0.0) {}
  double& operator()(std::size_t i, std::size_t j) { return values[i * size + j]; }
  double operator()(std::size_t i, std::size_t j) const { return values[i * size + j]; }
};

/// Solves A x = b by Gaussian elimination with pivoting in extended precision.
[[nodiscard]] std::vector<double> solve(const Dense& matrix, const std::vector<double>& right_hand_side);

/// Eigenvalues (ascending) and, in the columns of `vectors`, eigenvectors of a symmetric matrix, by SLEPc's LAPACK
/// solver.
struct Eigen {
  std::vector<double> values;
  Dense vectors;
};
[[nodiscard]] Eigen eigen(const Dense& symmetric);

/// @brief Bending stiffness C of the massless line over all nodes, elastic ends and foundation included; a held end is
/// left out by `free_nodes`.
[[nodiscard]] Dense line_stiffness(const BeamChain& beam);

/// Nodes that can move.
[[nodiscard]] std::vector<std::size_t> free_nodes(const BeamChain& beam);

/// Unfiltered vibration modes of the lumped beam: w^2 and mass-normalised shapes over all nodes, one per column.
[[nodiscard]] Eigen lumped_modes(const BeamChain& beam);

}  // namespace udar::test
