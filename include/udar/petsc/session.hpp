#pragma once
/// @file
/// Start and end of PETSc, SLEPc and MPI.

#include <petscsys.h>

#include <array>
#include <string>
#include <vector>

#include "udar/petsc/option_sources.hpp"

namespace udar::petsc {

/// @brief Initialises MPI, PETSc and SLEPc for the life of the object.
///
/// A first word without a dash is a case file, as are those named by `-options_file` (YAML, or PETSc's own text form).
/// They are inserted by `insert_options`, over `.petscrc` and `PETSC_OPTIONS` and below the command line. From here on
/// a failing PETSc call prints nothing by itself: its message travels in `petsc::Error`.
/// @note Collective over `MPI_COMM_WORLD`. Options: `-options_file`, `-options_file_yaml`, `-options_string_yaml`
class Session {
 public:
  /// Starts all, and inserts the options.
  /// @param help printed first by `-help`
  /// @throws InputError as `insert_options` does
  Session(int argc, char** argv, const char* help);
  /// Starts all, with no option of the files yet.
  Session(int argc, char** argv);
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  ~Session();

  /// Inserts what files, the environment and the command line ask for; once.
  /// @param help printed first by `-help`
  /// @throws InputError if an options file cannot be read or parsed, or a word belongs to no option
  void insert_options(const char* help);
  /// Whether `-version` was given.
  [[nodiscard]] bool version_requested() const noexcept { return version_; }
  /// Whether `-help TOPIC` found no key of that topic.
  [[nodiscard]] static bool help_found_nothing();
  /// Whether `-help` was given.
  [[nodiscard]] static bool help_requested();
  /// Whether this is rank 0 of `PETSC_COMM_WORLD`; also valid after the session has ended.
  [[nodiscard]] static bool on_first_rank();
  /// The files named by `-options_file`, in their order: other files they name may lie beside them.
  [[nodiscard]] static const std::vector<std::string>& options_files();
  /// Keeps the end of a run that failed from listing the options that it did not come to. @note Not collective.
  static void forget_unused_options();

 private:
  void begin_log_of_files() const;

  std::array<std::string, 2> environment_;  // PETSC_OPTIONS, PETSC_OPTIONS_YAML as they were
  std::vector<OptionSource> sources_;       // in the order of the command line
  std::vector<std::string> words_;          // the rest of the command line
  std::vector<char*> arguments_;            // these as PETSc wants them, with the program's name and a null pointer
  std::string help_topic_;
  PetscBool log_begun_ = PETSC_FALSE;
  bool help_ = false;
  bool version_ = false;
};

/// @brief Instead of a `Session` where others have started PETSc, or will end it: starts SLEPc, and PETSc where it is
/// not up yet. No option is read. May be called again. @note Collective over `PETSC_COMM_WORLD`.
void join_petsc();

/// @brief While it lives a failing PETSc call prints nothing, and its message travels in `petsc::Error`, as in a
/// `Session`: for calls into udar from programs with an error handler of their own. @note Not collective.
class RecordedErrors {
 public:
  RecordedErrors();
  RecordedErrors(const RecordedErrors&) = delete;
  RecordedErrors& operator=(const RecordedErrors&) = delete;
  ~RecordedErrors();
};

/// @brief The message of the PETSc error that was raised last on this rank, empty if none; reading clears it.
[[nodiscard]] std::string take_error_message();

}  // namespace udar::petsc
