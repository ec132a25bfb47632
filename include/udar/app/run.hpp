#pragma once
/// @file
/// The program `udar`: from options to files.

#include <petscsys.h>

namespace udar::app {

/// @brief Reads the case from the options database, runs it and writes its files.
/// @return the exit code: 0 when the run reached its end or `-help` was asked for, 3 when `-ts_max_steps` ended it,
/// 128 + signal when a signal did
/// @note Collective. @throws InputError, SolveError, FileError, petsc::Error
int run(MPI_Comm comm);

/// @brief Runs `program` between start and end of PETSc and turns every failure into one line `udar: error: ...` on
/// standard error and exit code 1, on all ranks, also when only some of them failed.
/// @param help printed first by `-help`
int guarded_main(int argc, char** argv, const char* help, int (*program)(MPI_Comm));

}  // namespace udar::app
