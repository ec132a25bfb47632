#pragma once
/// @file
/// First zeros of polynomials that start at or above zero.

#include <array>
#include <cstddef>
#include <optional>

namespace udar {

/// @brief First zero in [0, end] of sum_k c_k s^k, which is not negative at 0; negative: none, or not finite.
///
/// Advances by the zero of the parabola that the bound of the second derivative puts under the function: it cannot pass
/// a zero, and converges quadratically to one.
[[nodiscard]] double first_zero(const double* coefficients, std::size_t count, double end);

/// @brief First theta in (0, 1] where a polynomial that starts at or above zero turns negative.
///
/// `touching` says how often theta = 0 is a root by construction (a mass that stands on the support: 1; at rest there:
/// 2); these roots are divided out exactly. Bernstein subdivision: no crossing is missed. A polynomial that is negative
/// from the start gives theta = 0.
/// @param coefficients Bernstein form over [0, 1], degree 3 or 5
template <std::size_t Count>
[[nodiscard]] std::optional<double> first_closing(std::array<double, Count> coefficients, int touching);

extern template std::optional<double> first_closing<4>(std::array<double, 4>, int);
extern template std::optional<double> first_closing<6>(std::array<double, 6>, int);

}  // namespace udar
