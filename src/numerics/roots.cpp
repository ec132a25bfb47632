#include "udar/numerics/roots.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "udar/numerics/power_series.hpp"

namespace udar {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

struct ValueAndSlope {
  double value;
  double slope;
};

/// What `power_series::value` and `slope` give, to the bit, in the time of one.
ValueAndSlope value_and_slope(const double* c, std::size_t count, double s) {
  ValueAndSlope sum{};
  for (std::size_t k = count; k-- > 1;) {
    sum.value = sum.value * s + c[k];
    sum.slope = sum.slope * s + static_cast<double>(k) * c[k];
  }
  sum.value = sum.value * s + c[0];
  return sum;
}

/// `first_zero` from s on where the bound over the whole interval is too coarse, as near a minimum next to 0: expands
/// anew about every s, and bounds the second derivative over a window of about the advance only.
double first_zero_closely(const double* coefficients, std::size_t count, double s, double end, double size) {
  constexpr int kMostAdvances = 1000;
  constexpr double kWindow = 8.0;  // per advance
  std::array<double, kMostPowers> c{};
  double window = end - s;
  for (int advance = 0; advance < kMostAdvances; ++advance) {
    std::copy(coefficients, coefficients + count, c.begin());
    power_series::shift(c.data(), count, s);
    if (c[0] <= 0.0) {
      return s;
    }
    window = std::min(window, end - s);
    double step = 0.0;
    for (;;) {
      double bound = 0.0;
      for (std::size_t k = count; k-- > 2;) {
        bound = bound * window + static_cast<double>(k * (k - 1)) * std::abs(c[k]);
      }
      const double root = std::sqrt(c[1] * c[1] + 2.0 * bound * c[0]);
      step = c[1] < 0.0 ? 2.0 * c[0] / (root - c[1]) : (bound > 0.0 ? (c[1] + root) / bound : window);
      if (kWindow * step >= window || window <= kEpsilon * s) {
        break;
      }
      window /= kWindow;
    }
    if (c[1] < 0.0 && (step <= 2.0 * kEpsilon * s || c[0] <= kEpsilon * size * 0.01)) {
      return s;
    }
    if (step >= window) {
      if (s + window >= end) {
        return -1.0;
      }
      step = window;
      window *= kWindow;
    }
    s += std::max(step, 1e-17);
    if (s > end) {
      return -1.0;
    }
  }
  return s;  // a contact that grazes: met
}

constexpr std::size_t kMost = 6;
using Coefficients = std::array<double, kMost>;

/// De Casteljau at the middle: `left` and `right` receive the coefficients over the two halves.
void halve(std::span<const double> all, Coefficients& left, Coefficients& right) {
  const std::size_t count = all.size();
  Coefficients work{};
  std::ranges::copy(all, work.begin());
  for (std::size_t level = 0; level < count; ++level) {
    left[level] = work[0];
    right[count - 1 - level] = work[count - 1 - level];
    for (std::size_t i = 0; i + level + 1 < count; ++i) {
      work[i] = 0.5 * (work[i] + work[i + 1]);
    }
  }
}

/// First crossing from above in the open interval; `coefficients[0]` is not negative.
std::optional<double> search(std::span<const double> coefficients, double from, double to) {
  if (std::ranges::all_of(coefficients, [](double value) { return value >= 0.0; })) {
    return std::nullopt;
  }
  // 1e-20 of a step is below any time resolution: stops a root that sits at the very start.
  if (to - from <= std::max(2.0 * std::numeric_limits<double>::epsilon() * to, 1e-20)) {
    return to;
  }
  Coefficients left{};
  Coefficients right{};
  halve(coefficients, left, right);
  const double middle = 0.5 * (from + to);
  const std::span<const double> left_part{left.data(), coefficients.size()};
  const std::span<const double> right_part{right.data(), coefficients.size()};
  if (const auto found = search(left_part, from, middle)) {
    return found;
  }
  return right_part.front() < 0.0 ? std::optional{middle} : search(right_part, middle, to);
}

}  // namespace

double first_zero(const double* coefficients, std::size_t count, double end) {
  constexpr int kMostAdvances = 30;
  double bound = 0.0;  // of the second derivative
  double size = 0.0;   // of the terms, for their rounding
  double power = 1.0;
  for (std::size_t k = 0; k < count; ++k) {
    size += std::abs(coefficients[k]) * power;
    if (k >= 2) {
      bound += static_cast<double>(k * (k - 1)) * std::abs(coefficients[k]) * power / (end * end);
    }
    power *= end;
  }
  if (!std::isfinite(size)) {
    return -1.0;  // nothing to be found
  }
  if (!(end > 0.0)) {
    bound = 0.0;
  }
  double s = 0.0;
  for (int advance = 0; advance < kMostAdvances; ++advance) {
    const auto [value, slope] = value_and_slope(coefficients, count, s);
    if (value < 0.0 || (value == 0.0 && (slope < 0.0 || s > 0.0))) {
      return s;
    }
    if (value == 0.0 && slope == 0.0) {
      return count > 2 ? first_zero(coefficients + 2, count - 2, end) : -1.0;  // which way it leaves, if it does
    }
    const double root = std::sqrt(slope * slope + 2.0 * bound * value);
    const double step = slope < 0.0 ? 2.0 * value / (root - slope) : (bound > 0.0 ? (slope + root) / bound : end);
    if (slope < 0.0 && (step <= 2.0 * kEpsilon * s || value <= kEpsilon * size * 0.01)) {
      return s;
    }
    s += std::max(step, 1e-17);
    if (s > end) {
      return -1.0;
    }
  }
  return first_zero_closely(coefficients, count, s, end, size);
}

template <std::size_t Count>
std::optional<double> first_closing(std::array<double, Count> coefficients, int touching) {
  std::size_t count = Count;
  for (int root = 0; root < touching; ++root) {
    const auto degree = static_cast<double>(count - 1);
    for (std::size_t i = 0; i + 1 < count; ++i) {
      coefficients[i] = coefficients[i + 1] * degree / static_cast<double>(i + 1);
    }
    --count;
  }
  if (coefficients[0] < 0.0) {
    return 0.0;
  }
  return search(std::span<const double>{coefficients.data(), count}, 0.0, 1.0);
}

template std::optional<double> first_closing<4>(std::array<double, 4>, int);
template std::optional<double> first_closing<6>(std::array<double, 6>, int);

}  // namespace udar
