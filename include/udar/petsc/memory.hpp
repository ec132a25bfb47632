#pragma once
/// @file
/// What the machines have left.

#include <mpi.h>

namespace udar::petsc {

/// @brief Bytes that the machines of these ranks can still give, each machine once: what Linux calls available, at most
/// what a container may have; infinite where the system does not say.
/// @note Collective; equal on every rank.
[[nodiscard]] double available_memory(MPI_Comm comm);

}  // namespace udar::petsc
