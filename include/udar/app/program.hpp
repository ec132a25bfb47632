#pragma once
/// @file
/// What every program of udar does around its own work: starts and ends PETSc, and turns failures into one line.

#include <petscsys.h>

#include <functional>
#include <string>

namespace udar::app {

/// What a failed allocation comes to.
inline constexpr const char* kShortOfMemory =
    "memory ran out: this needs more machines, fewer ranks on each, or a smaller case";

/// @brief What `body` failed with, empty if it did not; the program ends here if only some ranks of `comm` failed,
/// which would leave the others waiting.
/// @note Collective; the message is that of this rank.
[[nodiscard]] std::string failure_of(MPI_Comm comm, const std::function<void()>& body);

/// @brief Runs `program` between start and end of PETSc and turns every failure into one line `udar: error: ...` on
/// standard error and exit code 1, on all ranks, also when only some of them failed.
/// @param help printed first by `-help`
int guarded_main(int argc, char** argv, const char* help, int (*program)(MPI_Comm));

}  // namespace udar::app
