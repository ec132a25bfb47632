#include "udar/numerics/complementarity.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <string>
#include <utility>

#include "udar/petsc/error.hpp"

// Cholesky factor of a band matrix, and solves by it. PETSc declares the LAPACK routines it calls; these it does not.
extern "C" {  // NOLINTBEGIN(readability-identifier-naming): Fortran names
void dpbtrf_(const char* half, const int* order, const int* diagonals, double* band, const int* leading, int* info);
void dpbtrs_(const char* half, const int* order, const int* diagonals, const int* columns, const double* band,
             const int* leading, double* right, const int* leading_right, int* info);
// NOLINTEND(readability-identifier-naming)
}

namespace udar {
namespace {

// Signs are told apart above this many units in the last place of what they are computed from: rounding of a Cholesky
// solve of some hundred rows (measured: below 20 on beams of 3200 elements under patches).
constexpr double kRounding = 256.0 * std::numeric_limits<double>::epsilon();
// Entries below this share of the diagonal are nothing to it.
constexpr double kNegligible = 0.1 * std::numeric_limits<double>::epsilon();
// Attempts of whole blocks without fewer violations, as Judice and Pires propose, before rows change sides one by one.
constexpr int kBlockMoves = 10;

std::vector<std::size_t> rows_of(std::span<const std::uint8_t> active) {
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < active.size(); ++i) {
    if (active[i] != 0) {
      rows.push_back(i);
    }
  }
  return rows;
}

}  // namespace

Complementarity::Complementarity(std::vector<double> matrix, std::size_t size)
    : matrix_{std::move(matrix)}, size_{size} {
  result_.resize(size_);
  change_.resize(size_);
  for (std::size_t i = 0; i < size_; ++i) {
    const auto counts = [&](std::size_t j) {
      const double scale = std::sqrt(matrix_[i * size_ + i] * matrix_[j * size_ + j]);
      return std::abs(matrix_[i * size_ + j]) > kNegligible * scale;
    };
    std::size_t first = 0;
    while (first < i && !counts(first)) {
      ++first;
    }
    reach_ = std::max(reach_, i - first);
  }
  factor();
}

/// Puts the Cholesky factor of the active block first; rows that the others already hold, but for rounding, leave it.
void Complementarity::factor() {
  for (;;) {
    const auto known = std::ranges::find(factors_, active_, &Factor::rows);
    if (known != factors_.end()) {
      std::rotate(factors_.begin(), known, known + 1);
      return;
    }
    if (factors_.size() < kFactors) {
      factors_.emplace_back();
    }
    std::ranges::rotate(factors_, factors_.end() - 1);
    Factor& factor = factors_.front();
    const std::size_t count = active_.size();
    factor.rows = active_;
    factor.diagonals = 0;
    for (std::size_t j = 0, i = 0; j < count; ++j) {
      while (i < count && active_[i] - active_[j] <= reach_) {
        ++i;
      }
      factor.diagonals = std::max(factor.diagonals, i - 1 - j);
    }
    const std::size_t height = factor.diagonals + 1;
    factor.values.assign(count * height, 0.0);
    for (std::size_t j = 0; j < count; ++j) {
      for (std::size_t i = j; i < std::min(count, j + height); ++i) {
        factor.values[j * height + i - j] = matrix_[active_[i] * size_ + active_[j]];
      }
    }
    if (count == 0) {
      return;
    }
    const auto order = static_cast<int>(count);
    const auto diagonals = static_cast<int>(factor.diagonals);
    const auto leading = static_cast<int>(height);
    int info = 0;
    dpbtrf_("L", &order, &diagonals, factor.values.data(), &leading, &info);
    if (info == 0) {
      return;
    }
    active_.erase(active_.begin() + (info - 1));
    factors_.erase(factors_.begin());
  }
}

void Complementarity::assume(std::vector<std::size_t> active) {
  active_ = std::move(active);
  factor();
}

std::vector<std::uint8_t> Complementarity::follow(std::span<const std::uint8_t> active,
                                                  std::span<const std::size_t> due, std::span<const double> rates) {
  std::vector<std::uint8_t> tried{active.begin(), active.end()};
  const std::size_t sets = std::size_t{1} << due.size();
  for (std::size_t set = 0; set < sets; ++set) {
    // The first tried has changed sides everywhere.
    for (std::size_t k = 0; k < due.size(); ++k) {
      const bool flips = ((set >> k) & 1U) == 0;
      tried[due[k]] = static_cast<std::uint8_t>((active[due[k]] != 0) != flips);
    }
    assume(rows_of(tried));
    respond(rates, change_);
    gaps(rates, change_, result_);
    if (std::ranges::all_of(due, [&](std::size_t i) { return tried[i] != 0 ? change_[i] > 0.0 : result_[i] >= 0.0; })) {
      return tried;
    }
  }
  return {active.begin(), active.end()};
}

void Complementarity::respond(std::span<const double> gap, std::span<double> force) const {
  std::ranges::fill(force, 0.0);
  const Factor& factor = factors_.front();
  if (factor.rows.empty()) {
    return;
  }
  std::vector<double> right(factor.rows.size());
  for (std::size_t i = 0; i < right.size(); ++i) {
    right[i] = -gap[factor.rows[i]];
  }
  const auto order = static_cast<int>(right.size());
  const auto diagonals = static_cast<int>(factor.diagonals);
  const auto leading = diagonals + 1;
  const int one = 1;
  int info = 0;
  dpbtrs_("L", &order, &diagonals, &one, factor.values.data(), &leading, right.data(), &order, &info);
  for (std::size_t i = 0; i < right.size(); ++i) {
    force[factor.rows[i]] = right[i];
  }
}

void Complementarity::gaps(std::span<const double> gap, std::span<const double> force, std::span<double> result) const {
  const std::vector<std::size_t>& rows = factors_.front().rows;
  std::size_t first = 0;
  for (std::size_t i = 0; i < size_; ++i) {
    while (first < rows.size() && rows[first] + reach_ < i) {
      ++first;
    }
    double sum = gap[i];
    for (std::size_t k = first; k < rows.size() && rows[k] <= i + reach_; ++k) {
      sum += matrix_[i * size_ + rows[k]] * force[rows[k]];
    }
    result[i] = sum;
  }
}

void Complementarity::solve(std::span<const double> gap, std::span<double> force) {
  double largest = 0.0;
  for (const double value : gap) {
    if (std::isnan(value)) {
      throw SolveError{"contact on the line: a gap is not a number"};
    }
    largest = std::isinf(value) ? largest : std::max(largest, std::abs(value));
  }
  std::erase_if(active_, [&](std::size_t i) { return std::isinf(gap[i]); });
  std::size_t fewest = size_ + 1;
  int moves = kBlockMoves;
  const std::size_t most = 100 + 20 * size_;
  std::vector<std::size_t> violating;
  for (std::size_t attempt = 0; attempt < most; ++attempt) {
    factor();
    respond(gap, force);
    gaps(gap, force, result_);
    double strongest = 0.0;
    double span = largest;
    for (const std::size_t i : active_) {
      strongest = std::max(strongest, std::abs(force[i]));
      span = std::max(span, std::abs(force[i]) * matrix_[i * size_ + i]);
    }
    violating.clear();
    auto next = active_.begin();
    for (std::size_t i = 0; i < size_; ++i) {
      const bool is_active = next != active_.end() && *next == i;
      next += is_active ? 1 : 0;
      if (is_active ? !(force[i] >= -kRounding * strongest) : !(result_[i] >= -kRounding * span)) {
        violating.push_back(i);
      }
    }
    if (violating.empty()) {
      for (const std::size_t i : active_) {
        force[i] = std::max(force[i], 0.0);
      }
      return;
    }
    if (violating.size() < fewest) {
      fewest = violating.size();
      moves = kBlockMoves;
    } else if (moves > 0) {
      --moves;
    } else {
      violating.erase(violating.begin(), violating.end() - 1);
    }
    std::vector<std::size_t> changed;
    std::ranges::set_symmetric_difference(active_, violating, std::back_inserter(changed));
    active_ = std::move(changed);
  }
  throw SolveError{"contact on the line: the complementarity problem of " + std::to_string(size_) +
                   " contact nodes was not solved; fewer elements under the supports would help"};
}

}  // namespace udar
