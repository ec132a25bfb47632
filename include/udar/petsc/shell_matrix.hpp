#pragma once
/// @file
/// Matrices that are only products.

#include <petscmat.h>

#include <cstddef>
#include <span>

#include "udar/petsc/array.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/handle.hpp"

namespace udar::petsc {

/// @brief A symmetric matrix whose product is a member function of an object,
/// `(object.*Multiply)(std::span<const double> x, std::span<double> y)` on this rank's values.
/// @param local, total rows of this rank and of all @param object must outlive the matrix
/// @note Collective. Exceptions of the product come out of the `UDAR_CALL` around what asked for it.
template <auto Multiply, class Object>
[[nodiscard]] Matrix symmetric_shell(MPI_Comm comm, PetscInt local, PetscInt total, Object& object) {
  constexpr auto multiply = [](Mat matrix, Vec x, Vec y) -> PetscErrorCode {
    return guarded([&] {
      void* context = nullptr;
      PetscInt rows = 0;
      UDAR_CALL(MatShellGetContext(matrix, static_cast<void*>(&context)));
      UDAR_CALL(VecGetLocalSize(x, &rows));
      const ReadArray from{x};
      const WriteArray to{y};
      const auto size = static_cast<std::size_t>(rows);
      (static_cast<Object*>(context)->*Multiply)({from.values(), size}, {to.values(), size});
    });
  };
  PetscErrorCode (*const callback)(Mat, Vec, Vec) = multiply;
  Matrix matrix;
  UDAR_CALL(MatCreateShell(comm, local, local, total, total, &object, matrix.put()));
  UDAR_CALL(MatShellSetOperation(matrix, MATOP_MULT, reinterpret_cast<void (*)()>(callback)));
  UDAR_CALL(MatShellSetOperation(matrix, MATOP_MULT_TRANSPOSE, reinterpret_cast<void (*)()>(callback)));
  UDAR_CALL(MatSetOption(matrix, MAT_SYMMETRIC, PETSC_TRUE));
  return matrix;
}

}  // namespace udar::petsc
