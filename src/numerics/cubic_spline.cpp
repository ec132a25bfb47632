#include "udar/numerics/cubic_spline.hpp"

#include <cstddef>
#include <string>

#include "udar/petsc/error.hpp"

// Factor of a positive definite tridiagonal matrix, and solves by it.
extern "C" {  // NOLINTBEGIN(readability-identifier-naming): Fortran names
void dpttrf_(const int* order, double* diagonal, double* beside, int* info);
void dpttrs_(const int* order, const int* columns, const double* diagonal, const double* beside, double* right,
             const int* leading, int* info);
// NOLINTEND(readability-identifier-naming)
}

namespace udar {

std::vector<double> spline_curvature(std::span<const double> x, std::span<const double> y) {
  const std::size_t count = x.size();
  std::vector<double> diagonal(count, 0.0);
  std::vector<double> beside(count - 1);
  std::vector<double> curvature(count, 0.0);  // first the right-hand side: jumps of the slopes of the polygon
  for (std::size_t i = 0; i + 1 < count; ++i) {
    const double length = x[i + 1] - x[i];
    const double slope = (y[i + 1] - y[i]) / length;
    diagonal[i] += length / 3.0;
    diagonal[i + 1] += length / 3.0;
    beside[i] = length / 6.0;
    curvature[i] += slope;
    curvature[i + 1] -= slope;
  }
  const auto n = static_cast<int>(count);
  const int columns = 1;
  int info = 0;
  dpttrf_(&n, diagonal.data(), beside.data(), &info);
  if (info == 0) {
    dpttrs_(&n, &columns, diagonal.data(), beside.data(), curvature.data(), &n, &info);
  }
  if (info != 0) {
    throw SolveError{"spline: LAPACK's dpttrf or dpttrs failed with " + std::to_string(info)};
  }
  return curvature;
}

}  // namespace udar
