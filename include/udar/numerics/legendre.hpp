#pragma once
/// @file
/// The polynomials in time of a step.

#include <array>
#include <cstddef>

namespace udar::local {

/// Most Legendre terms of the line's motion over a step.
inline constexpr std::size_t kMostTerms = 5;
/// Most powers of time in an arc's series: (wf h)^k / k! is below round-off there for wf h <= 2.
inline constexpr std::size_t kMostPowers = 30;

/// Power coefficients of the Legendre polynomials on [0, 1].
inline constexpr std::array<std::array<double, kMostTerms>, kMostTerms> kLegendre{
    {{1, 0, 0, 0, 0}, {-1, 2, 0, 0, 0}, {1, -6, 6, 0, 0}, {-1, 12, -30, 20, 0}, {1, -20, 90, -140, 70}}};

}  // namespace udar::local
