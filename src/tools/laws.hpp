#pragma once
/// @file
/// What a law of contact costs.

#include <mpi.h>
#include <petscsystypes.h>

namespace udar::bench {

/// @brief Moves masses over one step, each through a whole contact, and prints the time of a mass and sweep [ns] by
/// what it meets, as one JSON object. @param repeats samples of each time; the best counts
void laws(MPI_Comm comm, PetscInt repeats);

}  // namespace udar::bench
