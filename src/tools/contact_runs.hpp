#pragma once
/// @file
/// One motion through contact for a table of methods: what it comes to, and what it takes.

#include <mpi.h>

#include <optional>
#include <string>
#include <vector>

#include "udar/petsc/scoped_options.hpp"

namespace udar::bench {

/// What a method needs, without rows: nobody looks at the motion.
struct ContactCost {
  double line_solves = 0.0;  ///< set-up included
  double set_up = 0.0;       ///< CPU time of all ranks [s]
  double stepping = 0.0;     ///< the same from the start to the end of the motion [s]
};

/// Equal on every rank.
struct ContactRun {
  std::string refusal;                   ///< empty: it was run to its end
  std::vector<double> gauges;            ///< where they are [m]
  std::vector<double> lowest;            ///< positions of the line there in the first contact [m]
  std::optional<double> rebound;         ///< speed of the centre on its way back over that of the first landing [-]
  std::optional<double> second_landing;  ///< after the first [s]
  std::vector<double> times;             ///< of rows, from the first landing on [s]
  std::vector<std::vector<double>> positions;  ///< of the line at the gauges in these rows [m]
  double drift = 0.0;                          ///< of the energy, relative
  ContactCost cost;
};

/// Runs the case that the options in force and these make: once for its rows, and for its cost until 20 ms or so many
/// repeats are spent, of which the least counts. A refusal or failure is told in the result.
/// @note Collective.
[[nodiscard]] ContactRun run_contact(MPI_Comm comm, const petsc::Options& options, long repeats);

}  // namespace udar::bench
