#pragma once
/// @file
/// How far the numbers of a run by modes may be off.

#include <mpi.h>

#include <optional>

#include "udar/app/case.hpp"
#include "udar/io/summary.hpp"

namespace udar::app {

/// @brief Runs a case again with 1.4 times as many modes, and compares. @param found the summary of the run
/// @return empty: it was not asked for, is not by modes, was not completed or went on from a restart file, or there
/// are not so many modes
/// @note Collective. The other run's files are taken away again. @throws FileError on all ranks
[[nodiscard]] std::optional<io::ModalEstimate> estimate_by_more_modes(MPI_Comm comm, const Case& input,
                                                                      const io::Summary& found);

/// What it says. @note Collective.
void print_estimate(MPI_Comm comm, const io::Summary& found);

}  // namespace udar::app
