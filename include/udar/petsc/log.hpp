#pragma once
/// @file
/// What udar adds to PETSc's log, and what it counts of its own. State of the whole process, for one thread.

#include <petscsys.h>

namespace udar::petsc {

/// @brief The log events of udar, seen in `-log_view`; all -1, which counts nothing, until they are registered.
struct LogEvents {
  PetscLogEvent assemble = -1;      ///< assembly and factorisation of the line operator
  PetscLogEvent solve = -1;         ///< one line solve, right-hand side included
  PetscLogEvent contact = -1;       ///< search, location and resolution of contact, without the line solves
  PetscLogEvent local_motion = -1;  ///< the masses of `-ts_type impact` over a step, the line given
  PetscLogEvent reduction = -1;     ///< what the ranks tell each other in a step, without the line solves
  PetscLogEvent output = -1;        ///< everything the observers do
  PetscLogEvent fields = -1;        ///< within it: one row of all fields into results.h5
};
[[nodiscard]] const LogEvents& log_events();

/// @brief Registers them, until PETSc ends. `Session` does, and so does the registration of every type of ours: where
/// libudar is a plug-in they are logged, too. May be called again. @note Not collective; on all ranks.
[[nodiscard]] PetscErrorCode register_log_events();

/// @brief What this rank has told others, as PETSc's log counts it.
///
/// Calls of MPI in code that includes petsclog.h are counted: `MPI_Send`, `MPI_Isend` and their counterparts,
/// persistent requests of PETSc; reductions, gathers, scatters and broadcasts. Not counted are `MPI_Sendrecv`,
/// `MPI_Reduce`, `MPI_Iallreduce`, `MPI_Barrier` and what HDF5 does inside.
struct Traffic {
  double messages = 0.0;       ///< half of those sent and received, as `-log_view` counts
  double message_bytes = 0.0;  ///< of these
  double reductions = 0.0;     ///< collective calls; on one rank `MPI_Gather` alone counts
};
/// @brief Everything since the start of the program.
[[nodiscard]] Traffic traffic();

/// @brief Counts what happens in one scope under a log event: for `event_totals` always, and for PETSc's log if there
/// is one.
class LogScope {
 public:
  explicit LogScope(PetscLogEvent event);
  LogScope(const LogScope&) = delete;
  LogScope& operator=(const LogScope&) = delete;
  ~LogScope();

 private:
  [[nodiscard]] bool within_itself() const noexcept;

  PetscLogEvent event_;
  LogScope* around_ = nullptr;
  Traffic before_;
  PetscLogDouble begin_ = 0.0;
  PetscLogDouble inside_ = 0.0;  ///< seconds in scopes within this one
};

/// @brief What an event came to on this rank so far, in the scopes of `LogScope`, whatever log PETSc keeps.
struct EventTotals {
  double seconds = 0.0;  ///< inclusive
  double own = 0.0;      ///< seconds without those of the events of `LogEvents` inside
  PetscInt calls = 0;
  Traffic traffic{};
};
[[nodiscard]] EventTotals event_totals(PetscLogEvent event);

}  // namespace udar::petsc
