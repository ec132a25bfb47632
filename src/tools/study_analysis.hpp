#pragma once
/// @file
/// What a sequence of ever finer results tells: observed order, limit, error. Source: docs/theory.md, "Convergence
/// studies".

#include <optional>
#include <span>
#include <vector>

namespace udar::study {

/// @brief How a quantity behaves along an axis.
enum class Verdict {
  converges,     ///< monotone, at an order that can be trusted: extrapolated
  constant,      ///< does not depend on the axis beyond round-off
  settled,       ///< monotone, but settles faster than any order of the method: nothing left to extrapolate
  slow,          ///< monotone, but so slowly that an extrapolated value would be a guess
  irregular,     ///< monotone, but the order changes too much from one triple of values to the next
  not_monotone,  ///< goes up and down
  diverges,      ///< monotone, and the changes do not shrink
  two_values,    ///< too few values for an order
  no_values,     ///< too few values for anything
};

[[nodiscard]] const char* name(Verdict verdict);

/// @brief What an error stands for, better ones first.
enum class Bound {
  estimate,  ///< of the error, or above it
  changes,   ///< only as large as the changes that were seen
  at_least,  ///< the error is larger, nobody knows by how much
  unknown,
};

[[nodiscard]] const char* name(Bound bound);

/// @brief What is known of a quantity along one axis.
struct Trend {
  Verdict verdict = Verdict::no_values;
  std::vector<std::optional<double>>
      orders;  ///< observed with each three successive values; an empty one does not tell; none if `constant`
  std::optional<double> limit;  ///< by Richardson extrapolation; only where `converges`
  /// Of the finest value: distance to the limit where `converges`; the last change (constant, settled, slow, does not
  /// converge, two values); the spread of the last values (not monotone, irregular).
  double error = 0.0;
  Bound bound = Bound::unknown;
};

/// @brief The exponent p of q(h) = q(0) + c h^p through three values; empty if they are not monotone, or no p > 0 fits;
/// infinite beyond 64.
/// @param[in] size  of the discretisation, descending, any ratios
std::optional<double> observed_order(std::span<const double, 3> size, std::span<const double, 3> value);

/// @brief Judges a sequence of values from coarse to fine.
/// @param[in] size  of the discretisation, descending: 1/N, 1/wf, dt, rtol
/// @param[in] scale of quantities of this kind; changes below round-off of it are none
Trend trend(std::span<const double> size, std::span<const double> value, double scale);

/// @brief The finest value of a quantity with its error along all axes together.
struct Budget {
  double limit = 0.0;  ///< the finest value, corrected along every axis that converges if none leaves it open
  double sum = 0.0;    ///< of the errors along the axes
  Bound bound = Bound::estimate;  ///< the worst of them
};

/// @brief Adds up what the axes say, as if the errors along them were independent of each other.
Budget budget(double finest, std::span<const Trend> axes);

}  // namespace udar::study
