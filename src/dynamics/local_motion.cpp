#include "udar/dynamics/local_motion.hpp"

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

double first_zero(const double* coefficients, std::size_t count, double end) {
  constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
  constexpr int kMostAdvances = 300;
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
      return -1.0;  // it stays there
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
  return s;  // a contact that grazes: met
}

}  // namespace udar::local
