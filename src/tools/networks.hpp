#pragma once
/// @file
/// The solve of networks by their members beside general sparse solvers.

#include <mpi.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include "udar/structure/network.hpp"

namespace udar::bench {

/// Equal members: one alone, along the sides of squares, along those of cubes.
enum class Regular : std::uint8_t { beam, grillage_10, grillage_30, lattice_8 };

/// Prints as JSON, for structures and numbers of elements a member: time of a solve per node with one column and with
/// four, and how much longer CHOLMOD (one rank), MUMPS, and one rank alone take, in turn; the same of graded elements
/// and of rotary inertia.
struct NetworkBench {
  std::vector<Regular> structures{Regular::grillage_10, Regular::grillage_30, Regular::lattice_8};
  std::vector<std::size_t> elements{4, 16, 64};  ///< of a member
  double filter_frequency = 300.0;               ///< wf [rad/s]
  long repeats = 50;
  double member_length = 1.0;  ///< [m]
  NetworkPartition partition = NetworkPartition::metis;
  double grading = 1.0;  ///< beside equal elements graded ones, the last so many times as long as the first; 1: none
  bool rotary_inertia = false;  ///< beside networks without it the same with it
  long most = 30000;            ///< the assembled frame is solved up to so many nodes
};
/// @note Collective.
void networks(MPI_Comm comm, const NetworkBench& bench);

}  // namespace udar::bench
