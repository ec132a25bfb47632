#pragma once
/// @file
/// What a sequence of ever finer results tells: observed order, limit, error. Source: docs/theory.md, "Convergence
/// studies".

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <vector>

namespace udar::study {

/// @brief How a quantity behaves along an axis.
enum class Verdict {
  converges,     ///< monotone, at an order that can be trusted: extrapolated
  constant,      ///< does not depend on the axis beyond round-off
  fast,          ///< monotone, but settles faster than any order of the method: nothing left to extrapolate
  slow,          ///< monotone, but so slowly that an extrapolated value would be a guess
  not_monotone,  ///< goes up and down
  diverges,      ///< monotone, and the changes do not shrink
  two_values,    ///< too few values for an order
  one_value,     ///< too few values for anything
};

[[nodiscard]] inline const char* name(Verdict verdict) {
  constexpr std::array kNames{"converges",    "constant",         "settled",    "slow",
                              "not monotone", "does not converge", "two values", "one value"};
  return kNames.at(static_cast<std::size_t>(verdict));
}

/// @brief What is known of a quantity along one axis.
struct Trend {
  Verdict verdict = Verdict::one_value;
  std::optional<double> order;  ///< observed with the three finest values; empty if they are not monotone or do not tell
  std::optional<double> limit;  ///< by Richardson extrapolation; only where `converges`
  /// Estimated error of the finest value: distance to the limit where `converges`, else the last change (constant,
  /// fast, two values) or the spread of the last three values (not monotone). Empty: cannot be told.
  std::optional<double> error;
  bool trusted = false;  ///< whether `error` is an estimate or an upper bound, not a mere size of the changes
};

/// @brief The exponent p of q(h) = q(0) + c h^p through three values; empty if they are not monotone, or no p > 0 fits.
/// @param[in] size  of the discretisation, descending, any ratios
inline std::optional<double> observed_order(std::span<const double, 3> size, std::span<const double, 3> value) {
  const double ratio = (value[1] - value[0]) / (value[2] - value[1]);
  const auto of_order = [&size](double p) {
    const double middle = std::pow(size[1] / size[0], p);
    const double last = std::pow(size[2] / size[0], p);
    return (1.0 - middle) / (middle - last);
  };
  const double of_order_zero = std::log(size[0] / size[1]) / std::log(size[1] / size[2]);
  constexpr double kHighest = 64.0;
  if (!(ratio > of_order_zero)) {  // also where it is not a number
    return std::nullopt;
  }
  double low = 0.0;
  double high = 1.0;
  while (of_order(high) < ratio) {
    high *= 2.0;
    if (high > kHighest) {
      return std::numeric_limits<double>::infinity();
    }
  }
  constexpr int kHalvings = 60;  // more than a double has bits
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    (of_order(middle) < ratio ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// @brief Judges a sequence of values from coarse to fine.
/// @param[in] size  of the discretisation, descending: 1/N, 1/wf, dt, rtol
/// @param[in] scale of quantities of this kind; changes below round-off of it are none
inline Trend trend(std::span<const double> size, std::span<const double> value, double scale) {
  // Sums over a run of some thousand steps are right to about this.
  constexpr double kRoundOff = 1e-12;
  // Below half an order the limit lies more than twice the last change away (halved sizes); beyond six there is no
  // method here.
  constexpr double kLowest = 0.5;
  constexpr double kHighest = 6.0;
  const std::size_t count = value.size();
  Trend result;
  if (count < 2) {
    return result;
  }
  std::vector<double> change;
  for (std::size_t i = 1; i < count; ++i) {
    change.push_back(value[i] - value[i - 1]);
  }
  const double noise = kRoundOff * std::max(scale, std::abs(value.back()));
  const std::size_t judged = std::min<std::size_t>(change.size(), 3);
  const auto last = std::span{change}.last(judged);
  result.error = std::abs(change.back());
  result.trusted = true;
  if (std::ranges::all_of(last, [noise](double d) { return std::abs(d) <= noise; })) {
    result.verdict = Verdict::constant;
    return result;
  }
  if (count == 2) {
    result.verdict = Verdict::two_values;
    result.trusted = false;
    return result;
  }
  // The first changes may vanish, where an axis begins to act; the last may, where it has ceased to.
  const bool falls_into_noise = std::abs(change.back()) <= noise;
  const bool monotone = std::ranges::all_of(last, [](double d) { return d > 0.0; }) ||
                        std::ranges::all_of(last, [](double d) { return d < 0.0; });
  if (falls_into_noise) {
    result.verdict = Verdict::fast;
    return result;
  }
  if (!monotone) {
    const auto [lowest, highest] = std::ranges::minmax(value.last(judged + 1 > count ? count : judged + 1));
    result.verdict = Verdict::not_monotone;
    result.error = highest - lowest;
    result.trusted = false;
    return result;
  }
  result.order = observed_order(size.last(3).first<3>(), value.last(3).first<3>());
  if (!result.order) {
    result.verdict = Verdict::diverges;
    result.error.reset();
    result.trusted = false;
  } else if (*result.order < kLowest) {
    result.verdict = Verdict::slow;
    result.error.reset();
    result.trusted = false;
  } else if (*result.order > kHighest) {
    result.verdict = Verdict::fast;
  } else {
    result.verdict = Verdict::converges;
    const double ratio = std::pow(size[count - 2] / size[count - 1], *result.order);
    result.limit = value.back() + change.back() / (ratio - 1.0);
    result.error = std::abs(*result.limit - value.back());
  }
  return result;
}

/// @brief The finest value of a quantity with its error along each axis.
struct Budget {
  std::optional<double> limit;  ///< the finest value, corrected along every axis that converges
  std::optional<double> sum;    ///< of the errors along the axes; empty if one cannot be told
  bool trusted = true;          ///< whether every part is
};

/// @brief Adds up what the axes say. Errors of different origin are taken as independent of each other.
inline Budget budget(double finest, std::span<const Trend> axes) {
  Budget result{.limit = finest, .sum = 0.0};
  for (const Trend& axis : axes) {
    if (axis.limit) {
      *result.limit += *axis.limit - finest;
    }
    result.trusted = result.trusted && axis.trusted;
    if (result.sum && axis.error) {
      *result.sum += *axis.error;
    } else {
      result.sum.reset();
    }
  }
  return result;
}

}  // namespace udar::study
