#pragma once
/// @file
/// Sparse matrices in files: PETSc's binary form and Matrix Market.

#include <petscmat.h>

#include <limits>
#include <string>
#include <vector>

#include "udar/petsc/handle.hpp"

namespace udar {

/// @brief Reads a real sparse matrix: Matrix Market if the name ends in .mtx, else PETSc binary.
///
/// Of a symmetric one either both triangles or one of them may be stored; both are returned. Rows are dealt to the
/// ranks as PETSc deals them. Matrix Market is read by rank 0, through SuiteSparse.
/// @param[in] quantity what the matrix is, for messages ("structure stiffness")
/// @param[in] most_rows and columns for which there is memory: a small Matrix Market file may announce any number
/// @note Collective.
/// @throws FileError on all ranks, naming quantity and file, if it cannot be read, ends early, is of another kind, or
/// holds something else than finite numbers
[[nodiscard]] petsc::Matrix read_matrix(MPI_Comm comm, const std::string& quantity, const std::string& path,
                                        PetscInt most_rows = std::numeric_limits<PetscInt>::max());

/// @brief Writes a symmetric matrix: Matrix Market, 17 digits of the lower triangle, if the name ends in .mtx, else
/// PETSc binary with both triangles.
/// @note Collective; Matrix Market gathers on rank 0. @throws FileError on all ranks if the file cannot be written
void write_matrix(Mat matrix, const std::string& path);

/// @brief An entry of a sparse matrix, by global numbers.
struct MatrixEntry {
  PetscInt row = 0;
  PetscInt column = 0;
  double value = 0.0;
};

/// @brief Entries of this rank's rows. @note Not collective.
[[nodiscard]] std::vector<MatrixEntry> local_entries(Mat matrix);
/// @brief Entries of all rows on rank 0, in the order of rows; none on others. @note Collective.
[[nodiscard]] std::vector<MatrixEntry> gathered_entries(Mat matrix);
/// @brief A square or other `MATAIJ` of the sums of what all ranks give. @note Collective.
[[nodiscard]] petsc::Matrix matrix_of(MPI_Comm comm, PetscInt rows, PetscInt columns,
                                      const std::vector<MatrixEntry>& entries, PetscInt local_rows = PETSC_DECIDE);

}  // namespace udar
