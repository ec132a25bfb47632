#include "udar/petsc/error.hpp"

#include <exception>
#include <utility>

#include "udar/petsc/session.hpp"

namespace udar {
namespace petsc {
namespace {

std::string describe(PetscErrorCode code, const char* call, std::source_location where) {
  std::string message = take_error_message();
  if (message.empty()) {
    const char* text = nullptr;
    PetscErrorMessage(code, &text, nullptr);
    message = text != nullptr ? text : "unknown error";
  }
  return "PETSc error " + std::to_string(static_cast<int>(code)) + ": " + message + ", in " + call + " at " +
         where.file_name() + ":" + std::to_string(where.line());
}

/// What a callback threw and no C++ frame has seen yet.
std::exception_ptr& pending() {
  static std::exception_ptr exception;
  return exception;
}

}  // namespace

PetscErrorCode keep_exception() {
  PetscFunctionBeginUser;
  std::string message = "unknown exception";
  pending() = std::current_exception();
  try {
    throw;
  } catch (const std::exception& failure) {
    message = failure.what();
  } catch (...) {  // keeps its message
  }
  SETERRQ(PETSC_COMM_SELF, PETSC_ERR_LIB, "%s", message.c_str());
}

Error::Error(PetscErrorCode code, const char* call, std::source_location where)
    : std::runtime_error{describe(code, call, where)}, code_{code} {}

void check(PetscErrorCode code, const char* call, std::source_location where) {
  if (code == 0) {
    pending() = nullptr;  // of a failure that the program between us and the callback has dealt with
  } else {
    if (const std::exception_ptr exception = std::exchange(pending(), nullptr); exception != nullptr) {
      static_cast<void>(take_error_message());
      std::rethrow_exception(exception);
    }
    throw Error{code, call, where};
  }
}

}  // namespace petsc

template <class Failure>
void throw_together(MPI_Comm comm, const std::string& message) {
  int rank = 0;
  int size = 1;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &size);
  int first = message.empty() ? size : rank;
  MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_INT, MPI_MIN, comm);
  if (first == size) {
    return;
  }
  std::string shared = message;
  int length = static_cast<int>(shared.size());
  MPI_Bcast(&length, 1, MPI_INT, first, comm);
  shared.resize(static_cast<std::size_t>(length));
  MPI_Bcast(shared.data(), length, MPI_CHAR, first, comm);
  throw Failure{shared};
}

template void throw_together<InputError>(MPI_Comm, const std::string&);
template void throw_together<SolveError>(MPI_Comm, const std::string&);
template void throw_together<FileError>(MPI_Comm, const std::string&);

}  // namespace udar
