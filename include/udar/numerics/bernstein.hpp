#pragma once
/// @file
/// Polynomials on [0, 1] in Bernstein form.

#include <array>
#include <cstddef>

namespace udar {

/// @brief Bernstein coefficient `i` on [0, 1] of the powers of a series up to `degree`.
[[nodiscard]] double bernstein_of_powers(const double* series, std::size_t degree, std::size_t i);

/// @brief Bernstein coefficients of the cubic Hermite polynomial through values and rates at both ends of a step.
[[nodiscard]] std::array<double, 4> cubic_bernstein(double start, double start_rate, double end, double end_rate,
                                                    double length);

/// @brief Value of a cubic in Bernstein form.
[[nodiscard]] double bernstein_value(const std::array<double, 4>& c, double theta);
/// @brief Its rate over a step of this length.
[[nodiscard]] double bernstein_slope(const std::array<double, 4>& c, double theta, double length);

}  // namespace udar
