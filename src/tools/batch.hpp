#pragma once
/// @file
/// Many small beams at once, on parts of the communicator.

#include <mpi.h>

#include "udar/app/case.hpp"

namespace udar::bench {

/// Deals the beams to groups of ranks and prints the throughput as one JSON object.
void batch(MPI_Comm comm, const app::Case& input, PetscInt beams, PetscInt group);

}  // namespace udar::bench
