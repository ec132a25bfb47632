#pragma once
/// @file
/// Small complementarity problems with bounds on both sides.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace udar {

/// @brief Values v = q + W x between two bounds each, with one positive definite W that need not be symmetric: a row
/// has x > 0 only where v is its lower bound, x < 0 only where v is its upper one.
///
/// Block principal pivoting, as `Complementarity`, from nobody active: equal rows give equal answers to the bit. There
/// is one answer for every positive definite W. The active block is factored anew each time, by LAPACK's LU.
/// Source: Judice and Pires, Computers Ops Res. 21 (1994) 587.
/// @note Not collective: equal input gives equal output on every rank.
class BoundedRows {
 public:
  /// @param matrix W, by rows, `size` squared
  BoundedRows(std::vector<double> matrix, std::size_t size);

  /// The rows of a problem; of infinite value: it is never at its bounds.
  struct Problem {
    std::span<const double> value;  ///< q
    std::span<const double> lower;
    std::span<const double> upper;  ///< infinite: none
  };
  /// @brief Finds x. @return whether any is not zero
  /// @throws SolveError if q is not a number, or the pivoting does not end
  bool solve(const Problem& problem, std::span<double> x);

  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] double at(std::size_t row, std::size_t column) const { return matrix_[row * size_ + column]; }
  /// By row: 1 at its lower bound, -1 at its upper one, 0 between, since the last solve.
  [[nodiscard]] std::span<const std::int8_t> sides() const noexcept { return side_; }

 private:
  void respond(const Problem& problem, std::span<double> x);
  [[nodiscard]] std::size_t find_changes(const Problem& problem, std::span<const double> x);

  std::vector<double> matrix_;
  std::size_t size_;
  std::vector<std::int8_t> side_;
  std::vector<std::int8_t> next_;
  std::vector<double> value_;
  std::vector<std::size_t> active_;
};

}  // namespace udar
