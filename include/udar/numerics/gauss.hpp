#pragma once
/// @file
/// Gauss-Legendre quadrature.

#include <array>

namespace udar {

/// @brief A point of a quadrature on [0, 1] and its weight.
struct QuadraturePoint {
  double at;
  double weight;
};

/// @brief Eight points, exact to degree 15. Source: Abramowitz and Stegun, table 25.4, from [-1, 1] to [0, 1].
inline constexpr std::array<QuadraturePoint, 8> kGauss{{{0.01985507175123188, 0.05061426814518813},
                                                        {0.10166676129318664, 0.11119051722668724},
                                                        {0.2372337950418355, 0.15685332293894363},
                                                        {0.4082826787521751, 0.18134189168918100},
                                                        {0.5917173212478249, 0.18134189168918100},
                                                        {0.7627662049581645, 0.15685332293894363},
                                                        {0.8983332387068134, 0.11119051722668724},
                                                        {0.9801449282487681, 0.05061426814518813}}};

}  // namespace udar
