#pragma once
/// @file
/// Cubics through points, with continuous first and second derivatives.

#include <span>
#include <vector>

namespace udar {

/// @brief Second derivatives, at the points, of the cubic spline that leaves the first point and reaches the last with
/// no slope; linear between the points.
/// @param x strictly ascending, at least two @param y as many
/// @throws SolveError if numbers are not finite. Source: C. de Boor, A Practical Guide to Splines, ch. IV; LAPACK's
/// factorisation of a positive definite tridiagonal matrix
[[nodiscard]] std::vector<double> spline_curvature(std::span<const double> x, std::span<const double> y);

}  // namespace udar
