#pragma once
/// @file
/// Objects of mpi4py and petsc4py, by their handles: neither is needed to compile this.

#include <petscksp.h>
#include <pybind11/pybind11.h>

#include <cstddef>
#include <string>

namespace udar::python {

namespace py = pybind11;

/// @brief Imports mpi4py and petsc4py, which start MPI and PETSc, and refuses those of other libraries than udar's.
/// @throws pybind11::import_error naming both libraries
void start_libraries();

/// @brief A communicator of udar's own beside one that Python has.
class Communicator {
 public:
  /// @param of an mpi4py or petsc4py communicator; None: PETSc's world @note Collective over it.
  explicit Communicator(const py::object& of);
  Communicator(const Communicator&) = delete;
  Communicator& operator=(const Communicator&) = delete;
  ~Communicator();

  [[nodiscard]] MPI_Comm get() const noexcept { return comm_; }
  /// As Python gave it, or mpi4py's for the world.
  [[nodiscard]] const py::object& in_python() const noexcept { return in_python_; }

 private:
  py::object in_python_;
  MPI_Comm comm_ = MPI_COMM_NULL;
};

/// @name A petsc4py object with a reference of its own. @note Not collective.
/// @{
[[nodiscard]] py::object as_petsc4py(Vec vector);
[[nodiscard]] py::object as_petsc4py(Mat matrix);
[[nodiscard]] py::object as_petsc4py(KSP solver);
[[nodiscard]] py::object as_petsc4py(PC preconditioner);
/// @}

/// @brief The vector inside of a petsc4py Vec, borrowed. @param what it gives, for the message
/// @param size this rank must have of it @note Collective. @throws InputError on all ranks
[[nodiscard]] Vec vector_of(MPI_Comm comm, const py::object& object, const std::string& what, std::size_t size);

}  // namespace udar::python
