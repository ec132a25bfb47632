#pragma once
/// @file
/// The program `udar`: from options to files.

#include <petscsys.h>

#include <functional>
#include <span>
#include <string>

#include "udar/app/case.hpp"
#include "udar/io/summary.hpp"

namespace udar::app {

/// @brief Makes udar's types known to PETSc: `-ts_type` chebyshev, impact, moreau and `-filter_pc_type` chain.
/// @note Not collective. May be called again.
void register_types();

/// @brief What a run came to.
struct RunResult {
  int exit_code = 0;    ///< 0: reached its end, or `-help`; 3: ended by `-ts_max_steps`; 128 + signal: by a signal
  io::Summary summary;  ///< as in summary.json; empty after `-help`
};

/// @brief Makes a listener of the caller's for a run that is about to start: case, beam and masses of the local nodes
/// [kg]. The listener stays the caller's and must outlive the run. Called on all ranks.
using MakeListener = std::function<Observer&(const Case&, const BeamChain&, std::span<const double>)>;

/// @brief Reads the case from the options database, runs it and writes its files.
/// @param[in] listener empty: none besides those that write the files
/// @note Collective; any part of `PETSC_COMM_WORLD` will do. Says what it has to say through `PETSC_STDOUT` and
/// `PETSC_STDERR`. @throws InputError, SolveError, FileError, petsc::Error
RunResult run(MPI_Comm comm, const MakeListener& listener = {});

/// @brief What `body` failed with, empty if it did not; the program ends here if only some ranks of `comm` failed,
/// which would leave the others waiting.
/// @note Collective; the message is that of this rank.
[[nodiscard]] std::string failure_of(MPI_Comm comm, const std::function<void()>& body);

/// @brief Runs `program` between start and end of PETSc and turns every failure into one line `udar: error: ...` on
/// standard error and exit code 1, on all ranks, also when only some of them failed.
/// @param help printed first by `-help`
int guarded_main(int argc, char** argv, const char* help, int (*program)(MPI_Comm));

}  // namespace udar::app
