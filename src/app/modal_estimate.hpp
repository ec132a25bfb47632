#pragma once
/// @file
/// How far the numbers of a run by modes may be off.

#include <mpi.h>

#include <functional>
#include <optional>

#include "udar/app/case.hpp"
#include "udar/io/summary.hpp"

namespace udar::app {

/// @brief Runs a case again with 1.4 times as many modes, and compares. @param found the summary of the run
/// @param stop whether this rank is asked to end; empty: never
/// @return empty: it was not asked for, is not by modes, was not completed or went on from a restart file, or the other
/// run failed, which is no error of this one: there are not so many modes, or no space on the disk
/// @note Collective. The other run's files are taken away again.
[[nodiscard]] std::optional<io::ModalEstimate> estimate_by_more_modes(MPI_Comm comm, const Case& input,
                                                                      const io::Summary& found,
                                                                      const std::function<bool()>& stop);

/// What it says. @note Collective.
void print_estimate(MPI_Comm comm, const io::Summary& found);

}  // namespace udar::app
