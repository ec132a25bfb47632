#pragma once
/// @file
/// The program `udar`: from options to files.

#include <petscsys.h>

#include <functional>
#include <string>

#include "udar/app/case.hpp"
#include "udar/io/summary.hpp"

namespace udar::app {

/// @brief Makes udar's types known to PETSc: `-ts_type` chebyshev, impact, moreau and `-filter_pc_type` chain.
/// @note Not collective. May be called again.
void register_types();

/// @brief What a run came to.
struct RunResult {
  int exit_code = 0;    ///< 0: reached its end, or `-help`; 3: ended by `-ts_max_steps`, 4: by `-wall_limit`; 128 +
                        ///< signal: by a signal
  io::Summary summary;  ///< as in summary.json; empty after `-help`
};

/// @brief Makes a listener of the caller's for a run of this case on these points that is about to start. The listener
/// stays the caller's and must outlive the run. Called on all ranks.
using MakeListener = std::function<Observer&(const Case&, const MassPoints&)>;

/// @brief What a program adds to a run; each may be empty.
struct RunHooks {
  MakeListener listener{};
  std::function<int()> stop_signal{};  ///< the signal by which this rank is asked to end in order; 0: none so far
};

/// @brief Reads the case from the options database, runs it and writes its files.
/// @note Collective; any part of `PETSC_COMM_WORLD` will do. Says what it has to say through `PETSC_STDOUT` and
/// `PETSC_STDERR`. @throws InputError, SolveError, FileError, petsc::Error
RunResult run(MPI_Comm comm, const RunHooks& hooks = {});

}  // namespace udar::app
