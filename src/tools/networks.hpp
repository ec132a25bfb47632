#pragma once
/// @file
/// The solve of networks by their members beside general sparse solvers.

#include <mpi.h>

namespace udar::bench {

/// Prints as JSON, for two grillages and a lattice of members of 4, 16 and 64 elements: time of a solve per node with
/// one column and with four, and how much longer CHOLMOD (one rank), MUMPS, and one rank alone take, in turn.
struct NetworkBench {
  double filter_frequency = 300.0;  ///< wf [rad/s]
  long repeats = 50;
  long most = 30000;   ///< the assembled frame is solved up to so many nodes
  bool quick = false;  ///< the smaller grillage alone
};
/// @note Collective.
void networks(MPI_Comm comm, const NetworkBench& bench);

}  // namespace udar::bench
