#pragma once
/// @file
/// The solve of networks by their members beside general sparse solvers.

#include <mpi.h>

namespace udar::bench {

/// Prints as JSON, for two grillages and a lattice of members of 4, 16 and 64 elements: time of a solve per node with
/// one column and with four, and how much longer CHOLMOD (one rank), MUMPS, and one rank alone take, in turn.
/// @param filter_frequency wf [rad/s] @param most the assembled frame is solved up to so many nodes @note Collective.
void networks(MPI_Comm comm, double filter_frequency, long repeats, long most);

}  // namespace udar::bench
