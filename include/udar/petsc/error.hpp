#pragma once
/// @file
/// Errors at the two layers: PETSc error codes in callbacks, C++ exceptions everywhere else.

#include <petscsys.h>

#include <source_location>
#include <stdexcept>
#include <string>

namespace udar {

/// @brief What the user gave cannot be used: an option, a value, a file. The message is one complete line for the user.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// @brief The computation cannot go on: a line solve or the integration failed. The message is one complete line.
class SolveError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// @brief A result could not be written or read: full disk, missing permission, malformed file.
class FileError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

namespace petsc {

/// @brief A PETSc call failed; carries PETSc's code and the failing call with its place.
class Error : public std::runtime_error {
 public:
  Error(PetscErrorCode code, const char* call, std::source_location where);
  [[nodiscard]] PetscErrorCode code() const noexcept { return code_; }

 private:
  PetscErrorCode code_;
};

/// @brief Throws `Error` unless `code` is zero, or the exception that a guarded callback caught. Use through
/// `UDAR_CALL`.
void check(PetscErrorCode code, const char* call, std::source_location where = std::source_location::current());

/// Keeps the exception at hand for `check`. State of the whole process, for one thread. @return PETSc's code for it
[[nodiscard]] PetscErrorCode keep_exception();

/// @brief Runs C++ code inside a PETSc callback: an exception becomes a PETSc error here, and itself again in `check`.
template <class Body>
[[nodiscard]] PetscErrorCode guarded(const Body& body) {
  try {
    body();
    return 0;
  } catch (...) {
    return keep_exception();
  }
}

}  // namespace petsc

/// @brief Throws the `Failure` of the lowest rank that has one on every rank of `comm`; returns if no rank has one.
/// @param[in] message empty on a rank without failure
/// @note Collective: the way out of a loop that may fail on one rank only.
template <class Failure>
void throw_together(MPI_Comm comm, const std::string& message);

extern template void throw_together<InputError>(MPI_Comm, const std::string&);
extern template void throw_together<SolveError>(MPI_Comm, const std::string&);
extern template void throw_together<FileError>(MPI_Comm, const std::string&);

}  // namespace udar

/// Calls a PETSc function and throws `udar::petsc::Error` when it fails. For C++ frames only, never inside a callback.
#define UDAR_CALL(...) ::udar::petsc::check((__VA_ARGS__), #__VA_ARGS__)
