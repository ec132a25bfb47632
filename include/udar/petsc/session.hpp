#pragma once
/// @file
/// Start and end of PETSc, SLEPc and MPI.

#include <petscsys.h>

#include <string>
#include <vector>

namespace udar::petsc {

/// @brief Initialises MPI, PETSc and SLEPc for the life of the object.
///
/// Files named by `-options_file` (PETSc's own text or YAML form) are inserted here, before the command line, which
/// therefore wins. From here on a failing PETSc call prints nothing by itself: its message travels in `petsc::Error`.
/// @note Collective over `MPI_COMM_WORLD`. Options: `-options_file`
class Session {
 public:
  /// @param help printed first by `-help`
  /// @throws InputError if an options file cannot be read or parsed
  Session(int& argc, char**& argv, const char* help);
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  ~Session();

  /// Whether `-help` was given.
  [[nodiscard]] static bool help_requested();
  /// Whether this is rank 0 of `PETSC_COMM_WORLD`; also valid after the session has ended.
  [[nodiscard]] static bool on_first_rank();
  /// The files named by `-options_file`, in their order: other files they name may lie beside them.
  [[nodiscard]] static const std::vector<std::string>& options_files();

 private:
  Session(int argc, char** argv);

  std::vector<std::string> files_;
  std::vector<char*> arguments_;  // ends with a null pointer
  bool help_ = false;
};

/// @brief The message of the PETSc error that was raised last on this rank, empty if none; reading clears it.
[[nodiscard]] std::string take_error_message();

/// @brief The log events of udar; registered by `Session`, seen in `-log_view`.
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

/// @brief Times one scope under a log event.
class LogScope {
 public:
  explicit LogScope(PetscLogEvent event);
  LogScope(const LogScope&) = delete;
  LogScope& operator=(const LogScope&) = delete;
  ~LogScope();

 private:
  PetscLogEvent event_;
  LogScope* around_ = nullptr;
  PetscLogDouble begin_ = 0.0;
  PetscLogDouble inside_ = 0.0;  ///< seconds in scopes within this one
};

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

/// @brief What an event came to on this rank so far, over all stages of the log.
struct EventTotals {
  double seconds = 0.0;  ///< inclusive
  double own = 0.0;      ///< seconds without those of the events of `LogEvents` inside
  PetscInt calls = 0;
  Traffic traffic{};
};
[[nodiscard]] EventTotals event_totals(PetscLogEvent event);

}  // namespace udar::petsc
