#include "python/handles.hpp"

#include <dlfcn.h>

#include "udar/petsc/error.hpp"
#include "udar/petsc/session.hpp"

namespace udar::python {
namespace {

std::string file_of(void* function) {
  Dl_info info{};
  return dladdr(function, &info) != 0 && info.dli_fname != nullptr ? info.dli_fname : "nowhere";
}

/// Two libraries of one name can be in a process, each with a state of its own: handles of one are none of the other.
void require_same_library(const char* package, const char* module, const char* function, void* own) {
  const auto file = py::module_::import(module).attr("__file__").cast<std::string>();
  void* theirs = nullptr;
  if (void* loaded = dlopen(file.c_str(), RTLD_LAZY | RTLD_NOLOAD); loaded != nullptr) {
    theirs = dlsym(loaded, function);
    dlclose(loaded);
  }
  if (theirs != own) {
    throw py::import_error{std::string{package} + " is of another library than udar: it has " + function + " of '" +
                           file_of(theirs) + "', udar that of '" + file_of(own) + "'; PETSC_DIR and PYTHONPATH say " +
                           "which " + package + " Python takes"};
  }
}

/// What petsc4py offers to C, found at run time: `PyObject *PyPetscVec_New(Vec)`, which takes a reference, and `Vec
/// PyPetscVec_Get(PyObject *)`, which lends one.
template <class Function>
Function* offered(const std::string& name) {
  const auto functions = py::module_::import("petsc4py.PETSc").attr("__pyx_capi__").cast<py::dict>();
  return reinterpret_cast<Function*>(functions[name.c_str()].cast<py::capsule>().get_pointer<void>());
}

py::object wrapped(const std::string& type, PetscObject object) {
  PyObject* made = offered<PyObject*(PetscObject)>("PyPetsc" + type + "_New")(object);
  if (made == nullptr) {
    throw py::error_already_set();
  }
  return py::reinterpret_steal<py::object>(made);
}

py::object mpi4py_of(const py::object& comm) {
  if (comm.is_none()) {
    return py::module_::import("petsc4py.PETSc").attr("COMM_WORLD").attr("tompi4py")();
  }
  return py::hasattr(comm, "tompi4py") ? comm.attr("tompi4py")() : comm;
}

}  // namespace

void start_libraries() {
  require_same_library("mpi4py", "mpi4py.MPI", "MPI_Init_thread", reinterpret_cast<void*>(&MPI_Init_thread));
  require_same_library("petsc4py", "petsc4py.PETSc", "PetscInitialize", reinterpret_cast<void*>(&PetscInitialize));
  petsc::join_petsc();
}

Communicator::Communicator(const py::object& of) : in_python_{mpi4py_of(of)} {
  if (!py::hasattr(in_python_, "py2f")) {
    throw py::type_error("comm is not allowed, expected a communicator of mpi4py or petsc4py, or None");
  }
  MPI_Comm given = MPI_Comm_f2c(in_python_.attr("py2f")().cast<MPI_Fint>());
  if (given == MPI_COMM_NULL) {
    throw InputError{"comm: the null communicator is not allowed"};
  }
  MPI_Comm_dup(given, &comm_);
}

Communicator::~Communicator() {
  int finalized = 0;
  MPI_Finalized(&finalized);
  if (finalized == 0 && comm_ != MPI_COMM_NULL) {
    MPI_Comm_free(&comm_);
  }
}

py::object as_petsc4py(Vec vector) { return wrapped("Vec", reinterpret_cast<PetscObject>(vector)); }
py::object as_petsc4py(Mat matrix) { return wrapped("Mat", reinterpret_cast<PetscObject>(matrix)); }
py::object as_petsc4py(KSP solver) { return wrapped("KSP", reinterpret_cast<PetscObject>(solver)); }
py::object as_petsc4py(PC preconditioner) { return wrapped("PC", reinterpret_cast<PetscObject>(preconditioner)); }

Vec vector_of(MPI_Comm comm, const py::object& object, const std::string& what, std::size_t size) {
  std::string failure;
  Vec vector = nullptr;
  if (py::isinstance(object, py::module_::import("petsc4py.PETSc").attr("Vec"))) {
    vector = offered<Vec(PyObject*)>("PyPetscVec_Get")(object.ptr());
  }
  PetscInt found = 0;
  if (vector == nullptr) {
    failure = what + ": expected a Vec of petsc4py";
  } else {
    UDAR_CALL(VecGetLocalSize(vector, &found));
    if (found != static_cast<PetscInt>(size)) {
      failure =
          what + ": " + std::to_string(found) + " numbers on a rank are not allowed, expected " + std::to_string(size);
    }
  }
  throw_together<InputError>(comm, failure);
  return vector;
}

}  // namespace udar::python
