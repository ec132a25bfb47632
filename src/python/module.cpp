/// @file
/// The module `udar._core`: its errors and classes. Python's side is scripts/python/udar/core.py.

#include <pybind11/pybind11.h>

#include <exception>
#include <string>
#include <utility>

#include "python/given_case.hpp"
#include "python/handles.hpp"
#include "python/motion.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/options.hpp"

namespace udar::python {
namespace {

/// Classes of errors, which live as long as Python.
struct Errors {
  PyObject* user = nullptr;
  PyObject* solve = nullptr;
  PyObject* file = nullptr;
  PyObject* petsc = nullptr;
};

Errors& errors() {
  static Errors classes;
  return classes;
}

void raise(PyObject* kind, const std::exception& error) {
  PyErr_SetString(kind, petsc::with_option_keys(error.what()).c_str());
}

void translate(std::exception_ptr failure) {
  try {
    std::rethrow_exception(std::move(failure));
  } catch (const InputError& error) {
    raise(errors().user, error);
  } catch (const SolveError& error) {
    raise(errors().solve, error);
  } catch (const FileError& error) {
    raise(errors().file, error);
  } catch (const petsc::Error& error) {
    raise(errors().petsc, error);
  }
}

PyObject* new_error(py::module_& module, const char* name, PyObject* base, const char* text) {
  PyObject* made = PyErr_NewExceptionWithDoc((std::string{"udar.core."} + name).c_str(), text, base, nullptr);
  module.attr(name) = py::reinterpret_borrow<py::object>(made);
  return made;
}

}  // namespace
}  // namespace udar::python

PYBIND11_MODULE(_core, module) {
  using namespace udar::python;  // NOLINT(google-build-using-namespace): of this module
  start_libraries();
  module.doc() = "udar's library for udar.core.";
  errors().user = py::object{py::module_::import("udar.tools").attr("UserError")}.release().ptr();
  errors().solve = new_error(module, "SolveError", PyExc_RuntimeError, "A solve or the integration failed.");
  errors().file = new_error(module, "FileError", PyExc_OSError, "A file could not be read.");
  errors().petsc = new_error(module, "PetscError", PyExc_RuntimeError, "A call of PETSc failed.");
  py::register_exception_translator(translate);
  add_case(module);
  add_model(module);
  add_recording(module);
}
