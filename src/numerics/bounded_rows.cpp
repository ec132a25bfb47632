#include "udar/numerics/bounded_rows.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "udar/petsc/error.hpp"

// PETSc declares the LAPACK routines it calls; this one under another name.
extern "C" {  // NOLINTBEGIN(readability-identifier-naming): Fortran names
void dgesv_(const int* order, const int* columns, double* matrix, const int* leading, int* pivots, double* right,
            const int* leading_right, int* info);
// NOLINTEND(readability-identifier-naming)
}

namespace udar {
namespace {

// Signs are told apart above this many units in the last place of what they are computed from, as `Complementarity`.
constexpr double kSignRounding = 256.0 * std::numeric_limits<double>::epsilon();
// Attempts of whole blocks without fewer violations before rows change sides one by one.
constexpr int kWholeMoves = 10;

}  // namespace

BoundedRows::BoundedRows(std::vector<double> matrix, std::size_t size)
    : matrix_{std::move(matrix)}, size_{size}, side_(size, 0), next_(size, 0), value_(size, 0.0) {}

/// x that puts the active rows on their bounds, zero elsewhere.
void BoundedRows::respond(const Problem& problem, std::span<double> x) {
  active_.clear();
  for (std::size_t i = 0; i < size_; ++i) {
    x[i] = 0.0;
    if (side_[i] != 0) {
      active_.push_back(i);
    }
  }
  if (active_.empty()) {
    return;
  }
  const auto order = static_cast<int>(active_.size());
  std::vector<double> block(active_.size() * active_.size());
  std::vector<double> right(active_.size());
  for (std::size_t i = 0; i < active_.size(); ++i) {
    const std::size_t row = active_[i];
    right[i] = (side_[row] > 0 ? problem.lower[row] : problem.upper[row]) - problem.value[row];
    for (std::size_t j = 0; j < active_.size(); ++j) {
      block[j * active_.size() + i] = at(row, active_[j]);
    }
  }
  std::vector<int> pivots(active_.size());
  const int one = 1;
  int info = 0;
  dgesv_(&order, &one, block.data(), &order, pivots.data(), right.data(), &order, &info);
  if (info != 0) {
    throw SolveError{"yielding of the line: the matrix of " + std::to_string(active_.size()) + " rows is singular"};
  }
  for (std::size_t i = 0; i < active_.size(); ++i) {
    x[active_[i]] = right[i];
  }
}

/// Who is on the wrong side, and where they belong. @return how many
std::size_t BoundedRows::find_changes(const Problem& problem, std::span<const double> x) {
  double strongest = 0.0;
  double span = 0.0;
  for (std::size_t i = 0; i < size_; ++i) {
    value_[i] = problem.value[i];
    for (const std::size_t j : active_) {
      value_[i] += at(i, j) * x[j];
    }
    strongest = std::max(strongest, std::abs(x[i]) * std::sqrt(at(i, i)));
  }
  std::size_t changes = 0;
  for (std::size_t i = 0; i < size_; ++i) {
    next_[i] = side_[i];
    if (side_[i] != 0) {
      next_[i] = static_cast<double>(side_[i]) * x[i] * std::sqrt(at(i, i)) < -kSignRounding * strongest ? 0 : side_[i];
    } else if (!std::isinf(problem.value[i])) {
      const double reach = std::isinf(problem.upper[i]) ? 0.0 : problem.upper[i] - problem.lower[i];
      span = kSignRounding * std::max({std::abs(problem.value[i]), reach, strongest * std::sqrt(at(i, i))});
      next_[i] = value_[i] < problem.lower[i] - span ? 1 : value_[i] > problem.upper[i] + span ? -1 : 0;
    }
    changes += next_[i] != side_[i] ? 1 : 0;
  }
  return changes;
}

bool BoundedRows::solve(const Problem& problem, std::span<double> x) {
  if (std::ranges::any_of(problem.value, [](double value) { return std::isnan(value); })) {
    throw SolveError{"yielding of the line: a moment or a gap is not a number"};
  }
  std::ranges::fill(side_, std::int8_t{0});
  std::size_t fewest = size_ + 1;
  int moves = kWholeMoves;
  const std::size_t most = 100 + 20 * size_;
  for (std::size_t attempt = 0; attempt < most; ++attempt) {
    respond(problem, x);
    const std::size_t changes = find_changes(problem, x);
    if (changes == 0) {
      return !active_.empty();
    }
    if (changes < fewest) {
      fewest = changes;
      moves = kWholeMoves;
    } else if (moves > 0) {
      --moves;
    } else {
      std::size_t last = size_ - 1;
      while (next_[last] == side_[last]) {
        --last;
      }
      std::copy_n(side_.begin(), last, next_.begin());
    }
    side_ = next_;
  }
  throw SolveError{"yielding of the line: the complementarity problem of " + std::to_string(size_) +
                   " contact points and hinges was not solved; fewer hinges would help (beam hinge position)"};
}

}  // namespace udar
