#pragma once
/// @file
/// Legendre polynomials on [0, 1], and functions over a step as series in them.

#include <array>
#include <cstddef>

namespace udar {

/// Most Legendre terms of a function over a step.
inline constexpr std::size_t kMostTerms = 5;
using LegendreMatrix = std::array<std::array<double, kMostTerms>, kMostTerms>;

/// Their power coefficients: [polynomial][power].
inline constexpr LegendreMatrix kLegendre{
    {{1, 0, 0, 0, 0}, {-1, 2, 0, 0, 0}, {1, -6, 6, 0, 0}, {-1, 12, -30, 20, 0}, {1, -20, 90, -140, 70}}};

/// @brief Polynomial `j` and its derivative.
[[nodiscard]] double legendre(std::size_t j, double tau);
[[nodiscard]] double legendre_slope(std::size_t j, double tau);

/// @brief Adds to Legendre coefficients over [0, 1] those of a function that is a power series in tau - `from` on
/// [from, from + length] and zero elsewhere.
void add_legendre(const double* series, std::size_t count, double from, double length, std::size_t terms,
                  std::array<double, kMostTerms>& coefficients);

/// @brief Bernstein coefficients of the Legendre polynomials: [coefficient][polynomial].
[[nodiscard]] LegendreMatrix legendre_bernstein(std::size_t terms);

/// @brief Legendre coefficients of L_old(offset + ratio tau): [new][old].
[[nodiscard]] LegendreMatrix legendre_change(std::size_t terms, double offset, double ratio);

/// @brief What the projection of a function on `terms` polynomials misses of a kink of unit slope at tau = `at`: the
/// integral, over the kink's ramp, of the miss.
[[nodiscard]] double kink_miss(std::size_t terms, double at);
/// @brief The same of a unit jump.
[[nodiscard]] double jump_miss(std::size_t terms, double at);
/// @brief The largest of these over [0, 1].
[[nodiscard]] double kink_integral(std::size_t terms);
[[nodiscard]] double jump_integral(std::size_t terms);

}  // namespace udar
