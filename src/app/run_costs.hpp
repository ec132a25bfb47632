#pragma once
/// @file
/// What a run costs: seconds, messages and memory, by stage and over the ranks.

#include <mpi.h>

#include <map>
#include <string>

#include "udar/io/summary.hpp"
#include "udar/petsc/log.hpp"

namespace udar::app {

/// @brief Where this rank's clocks and counters stand.
struct CostMark {
  double time = 0.0;  ///< [s], of a clock that only differences mean something of
  petsc::Traffic traffic{};
  std::map<std::string, petsc::EventTotals> stages;
};
[[nodiscard]] CostMark cost_mark();
/// That clock now [s].
[[nodiscard]] double wall_time();

/// @brief Enters the costs of a run into its summary.
/// @param[in] begin of the run, of the stepping and the end of the stepping
/// @note Collective: two reductions.
void add_costs(MPI_Comm comm, const CostMark& begin, const CostMark& stepping, const CostMark& end,
               io::Summary& summary);

}  // namespace udar::app
