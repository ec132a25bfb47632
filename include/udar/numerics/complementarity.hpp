#pragma once
/// @file
/// Small linear complementarity problems.

#include <petscsys.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace udar {

/// @brief 0 <= r, 0 <= q + W r, r' (q + W r) = 0 with one symmetric positive definite W and many q.
///
/// Block principal pivoting: rows that violate their sign change sides all at once while that helps, one by one when it
/// does not, which ends for every positive definite W. The factors of the last active blocks are kept. W is taken for a
/// band matrix as wide as its entries count: rows of one place should stand side by side.
/// Source: Judice and Pires, Computers Ops Res. 21 (1994) 587; LAPACK's Cholesky factorisation of band matrices.
/// @note Not collective: equal input gives equal output on every rank.
class Complementarity {
 public:
  /// @param matrix W, by rows, `size` squared
  Complementarity(std::vector<double> matrix, std::size_t size);

  /// @param[in] gap q; infinite: a row that never touches
  /// @param[out] force r
  /// @throws SolveError if q is not a number, or the pivoting does not end
  void solve(std::span<const double> gap, std::span<double> force);

  /// @brief r with r = -W_AA^-1 q_A on the rows that are active since the last solve and zero elsewhere: what a change
  /// of q changes while nobody changes sides.
  void respond(std::span<const double> gap, std::span<double> force) const;
  /// q + W r.
  void gaps(std::span<const double> gap, std::span<const double> force, std::span<double> result) const;

  /// More rows than these may have too many active sets for `follow` to try.
  static constexpr std::size_t kMostFollowed = 8;
  /// @brief Who is active from now on, as q moves on: of the rows whose r and gap are zero at once those with r that
  /// grows, others stay as they are. There is one answer, as W is positive definite; where rounding leaves none, nobody
  /// changes sides.
  /// @param active nonzero: until now @param due rows that are zero now, at most `kMostFollowed` @param rates of q
  [[nodiscard]] std::vector<std::uint8_t> follow(std::span<const std::uint8_t> active, std::span<const std::size_t> due,
                                                 std::span<const double> rates);

  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  /// Rows with r > 0 allowed, ascending.
  [[nodiscard]] const std::vector<std::size_t>& active() const noexcept { return active_; }
  /// Where the next solve starts from, and what `respond` goes by: rows, ascending; empty at first.
  void assume(std::vector<std::size_t> active);

 private:
  void factor();

  std::vector<double> matrix_;
  std::size_t size_;
  std::size_t reach_ = 0;  // rows that feel each other are no further apart
  std::vector<std::size_t> active_;
  /// Cholesky factor of a block.
  struct Factor {
    std::vector<std::size_t> rows;
    std::size_t diagonals = 0;   // below the main one
    std::vector<double> values;  // of these diagonals, by columns
  };
  static constexpr std::size_t kFactors = 6;  // about a kink of the motion few sets take turns
  std::vector<Factor> factors_;               // the last used first: that of the last solve
  std::vector<double> result_;
  std::vector<double> change_;  // of r
};

}  // namespace udar
