#pragma once
/// @file
/// How much memory a run is going to take.

#include <mpi.h>

#include <string>

#include "udar/app/case.hpp"

namespace udar::app {

/// @brief What the memory of a run goes by.
struct ModelSize {
  double beam_nodes = 0.0;
  double junctions = 0.0;    ///< of a network
  double members = 0.0;      ///< the same: every rank knows all
  double inner_nodes = 0.0;  ///< of members
  double row_bytes = 0.0;    ///< of rows that forces of supports are means over, on each rank
};

/// @brief Bytes over all ranks, program and libraries left out: from measured runs, a factor's fill not counted.
[[nodiscard]] double memory_of(const ModelSize& size, int ranks);

/// @brief Refuses before anything of that size is built what the machines cannot hold.
/// @param what asks for it, with its value: "option -beam_elements: 1000000000"
/// @param most bytes over all ranks; 0: what the machines have available
/// @note Collective. @throws InputError naming the estimate, what there is, and -structure_memory
void refuse_large_memory(MPI_Comm comm, const std::string& what, const ModelSize& size, double most);

/// @brief The same of a network, of which every rank has what it was read as; refuses one that is not countable, too.
/// @note Collective.
void refuse_large_network(MPI_Comm comm, const std::string& what, const NetworkParameters& network, double most);

/// @brief How many unknowns of imported matrices fit. @param most as above @note Collective.
[[nodiscard]] PetscInt most_unknowns(MPI_Comm comm, double most);

/// @brief The same of a beam, and of the rows that are kept. @note Collective.
void refuse_large_memory(MPI_Comm comm, const CaseInput& input);

}  // namespace udar::app
