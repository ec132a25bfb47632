#include "udar/numerics/symmetric_eigen.hpp"

#include <algorithm>

#include "udar/petsc/error.hpp"

// PETSc declares one of these alone, and in a header that cannot come first.
extern "C" {  // NOLINTBEGIN(readability-identifier-naming): Fortran names
void dsyevd_(const char* job, const char* half, const int* order, double* matrix, const int* leading, double* values,
             double* work, const int* room, int* integers, const int* integer_room, int* info);
void dsygv_(const int* kind, const char* job, const char* half, const int* order, double* a, const int* leading_a,
            double* b, const int* leading_b, double* values, double* work, const int* room, int* info);
// NOLINTEND(readability-identifier-naming)
}

namespace udar {

void symmetric_eigen(std::span<double> matrix, std::span<double> values) {
  const auto order = static_cast<int>(values.size());
  const int room = 1 + 6 * order + 2 * order * order;
  const int integer_room = 3 + 5 * order;
  std::vector<double> work(static_cast<std::size_t>(room));
  std::vector<int> integers(static_cast<std::size_t>(integer_room));
  int info = 0;
  dsyevd_("V", "U", &order, matrix.data(), &order, values.data(), work.data(), &room, integers.data(), &integer_room,
          &info);
  if (info != 0) {
    throw SolveError{"the eigenvalues of a symmetric matrix were not found; it is not finite"};
  }
}

std::optional<double> largest_of_pencil(std::vector<double> a, std::vector<double> b, std::size_t size) {
  const auto order = static_cast<int>(size);
  const int kind = 1;
  const int room = std::max(1, 3 * order);
  std::vector<double> values(size);
  std::vector<double> work(static_cast<std::size_t>(room));
  int info = 0;
  dsygv_(&kind, "N", "U", &order, a.data(), &order, b.data(), &order, values.data(), work.data(), &room, &info);
  return info == 0 ? std::optional{values.back()} : std::nullopt;
}

}  // namespace udar
