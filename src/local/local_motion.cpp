#include "udar/local/local_motion.hpp"

#include <algorithm>

namespace udar::local {

std::size_t powers_for(double angle) {
  constexpr double kRoundOff = 1e-18;
  double term = 1.0;
  std::size_t count = 4;
  for (std::size_t k = 1; k < kMostPowers; ++k) {
    term *= angle / static_cast<double>(k);
    if (term < kRoundOff && k >= count) {
      break;
    }
    count = std::max(count, k + 1);
  }
  return count;
}

namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

/// `first_zero` from s on where the bound over the whole interval is too coarse, as near a minimum next to 0: expands
/// anew about every s, and bounds the second derivative over a window of about the advance only.
double first_zero_closely(const double* coefficients, std::size_t count, double s, double end, double size) {
  constexpr int kMostAdvances = 1000;
  constexpr double kWindow = 8.0;  // per advance
  std::array<double, kMostPowers> c{};
  double window = end - s;
  for (int advance = 0; advance < kMostAdvances; ++advance) {
    std::copy(coefficients, coefficients + count, c.begin());
    for (std::size_t from = 0; from + 1 < count; ++from) {
      for (std::size_t k = count - 1; k-- > from;) {
        c[k] += s * c[k + 1];
      }
    }
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
    const double value = detail::value(coefficients, count, s);
    const double slope = detail::slope(coefficients, count, s);
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

}  // namespace udar::local
