#include "udar/numerics/positive_inverse.hpp"

extern "C" {  // NOLINTBEGIN(readability-identifier-naming): Fortran names
void dpotrf_(const char* uplo, const int* n, double* a, const int* lda, int* info);
void dpotri_(const char* uplo, const int* n, double* a, const int* lda, int* info);
}  // NOLINTEND(readability-identifier-naming)

namespace udar {

bool invert_positive(std::span<double> matrix, std::size_t order) {
  if (order == 0) {
    return true;
  }
  const auto n = static_cast<int>(order);
  int info = 0;
  dpotrf_("L", &n, matrix.data(), &n, &info);
  if (info == 0) {
    dpotri_("L", &n, matrix.data(), &n, &info);
  }
  for (std::size_t i = 0; i < order; ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      matrix[i * order + k] = matrix[k * order + i];
    }
  }
  return info == 0;
}

}  // namespace udar
