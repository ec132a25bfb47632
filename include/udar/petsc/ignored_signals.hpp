#pragma once
/// @file
/// Signals that the process was started to ignore, as `nohup` does: PETSc, MPI and UCX take some of them.

namespace udar::petsc {

/// @brief Remembers which of SIGHUP, SIGINT, SIGPIPE, SIGTERM, SIGUSR1, SIGUSR2 are ignored now, beside those noted
/// before. May run before any constructor. @note Not collective.
void note_ignored_signals() noexcept;

/// @brief Ignores them again. @note Not collective.
void ignore_noted_signals() noexcept;

}  // namespace udar::petsc
