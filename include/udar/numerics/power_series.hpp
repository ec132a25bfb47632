#pragma once
/// @file
/// Power series sum_k c_k s^k, by their coefficients.

#include <array>
#include <cstddef>

namespace udar {

/// Most powers of time in the series of a motion over a step: (wf h)^k / k! is below round-off there for wf h <= 2.
inline constexpr std::size_t kMostPowers = 30;

namespace power_series {

/// @brief sum_k c_k s^k, by Horner's rule.
[[nodiscard]] inline double value(const double* c, std::size_t count, double s) {
  double sum = 0.0;
  for (std::size_t k = count; k-- > 0;) {
    sum = sum * s + c[k];
  }
  return sum;
}

/// @brief Its derivative in s.
[[nodiscard]] inline double slope(const double* c, std::size_t count, double s) {
  double sum = 0.0;
  for (std::size_t k = count; k-- > 1;) {
    sum = sum * s + static_cast<double>(k) * c[k];
  }
  return sum;
}

/// @brief Coefficients about `s` instead of 0, in place.
inline void shift(double* c, std::size_t count, double s) {
  for (std::size_t from = 0; from + 1 < count; ++from) {
    for (std::size_t k = count - 1; k-- > from;) {
      c[k] += s * c[k + 1];
    }
  }
}

}  // namespace power_series
}  // namespace udar
