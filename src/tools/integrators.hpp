#pragma once
/// @file
/// Integrators side by side: line solves, time and error of whole motions through impacts.

#include <mpi.h>

#include "udar/structure/beam_chain.hpp"

namespace udar::bench {

/// Where the tables are made, and of which beam.
struct Bench {
  MPI_Comm comm = MPI_COMM_NULL;
  BeamParameters beam;  ///< of one segment
};

/// All tables, each after one another.
void integrators(const Bench& bench, bool quick);

}  // namespace udar::bench
