#include "python/given_case.hpp"

#include <algorithm>
#include <array>

#include "udar/app/memory_size.hpp"
#include "udar/app/run.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/option_sources.hpp"
#include "udar/petsc/options.hpp"
#include "udar/petsc/scoped_options.hpp"

namespace udar::python {
namespace {

bool& busy() {
  static bool now = false;
  return now;
}

/// Keys of the program, which has files and a terminal.
void refuse_keys_of_the_program(const std::string& key) {
  constexpr std::array kOthers{
      "-help", "-version", "-options_file", "-options_file_yaml", "-continue", "-options_string_yaml", "-restart_file"};
  if (std::ranges::find(kOthers, key) != kOthers.end()) {
    throw InputError{"option " + key + " is not allowed in memory, it is one of the program udar"};
  }
}

/// Options of Python as words: `as_text` is what `udar.run` makes of values.
petsc::Options words_of(const py::dict& options) {
  const py::object as_text = py::module_::import("udar.running").attr("as_text");
  petsc::Options words;
  for (const auto& [name, value] : options) {
    std::string key = py::str(name);
    key = "-" + key.substr(std::min(key.find_first_not_of('-'), key.size()));
    if (!value.is_none()) {
      words.emplace_back(key, as_text(name, value).cast<std::string>());
    }
  }
  return words;
}

void insert(const py::dict& options) {
  for (const auto& [key, value] : words_of(options)) {
    const std::array words{key, *value};
    petsc::check_option_words(words);
    petsc::forget_place(key);
    UDAR_CALL(PetscOptionsSetValue(nullptr, key.c_str(), value->c_str()));
  }
}

}  // namespace

GivenCase::Alone::Alone() {
  if (busy()) {
    throw InputError{"udar is at work: what its own solvers call cannot call it"};
  }
  busy() = true;
}

GivenCase::Alone::~Alone() { busy() = false; }

GivenCase::Scope::Scope(GivenCase& given) : options_{given.options_} { static_cast<void>(petsc::take_warnings()); }

GivenCase::GivenCase(const py::object& source, const py::object& comm, const py::dict& options) : comm_{comm} {
  within([&] { read(source, options); });
}

void GivenCase::read(const py::object& source, const py::dict& options) {
  if (py::isinstance<py::dict>(source)) {
    insert(source);
  } else if (!source.is_none()) {
    const py::object path = py::module_::import("os").attr("fspath")(source);
    petsc::insert_source(comm_.get(), {.kind = petsc::OptionSource::Kind::file, .text = path.cast<std::string>()});
  }
  insert(options);
  for (const auto& [key, value] : petsc::all_options()) {
    refuse_keys_of_the_program(key);
  }
  app::register_types();
  petsc::check_petsc_options();
  const app::CaseInput asked = app::read_case(comm_.get());
  app::refuse_large_memory(comm_.get(), asked);
  input_ = app::resolve(comm_.get(), asked);
}

py::dict GivenCase::options() {
  return within([&] {
    py::dict all;
    for (const auto& [key, value] : petsc::all_options()) {
      all[key.substr(1).c_str()] = value.value_or("true");
    }
    return all;
  });
}

void GivenCase::tell_warnings() const {
  int rank = 0;
  MPI_Comm_rank(comm_.get(), &rank);
  const py::object category = py::module_::import("udar.running").attr("UdarWarning");
  for (const std::string& text : petsc::take_warnings()) {
    if (rank == 0 && PyErr_WarnEx(category.ptr(), petsc::with_option_keys(text).c_str(), 1) != 0) {
      throw py::error_already_set();
    }
  }
}

void add_case(py::module_& module) {
  py::class_<GivenCase, std::shared_ptr<GivenCase>> type(module, "Case", R"(A case, read and checked.

`case` is a case file, a dictionary of options, or None; `options` win over it, as in `udar.run`. SI units throughout.
Nothing of the options of PETSc's own database, such as PETSC_OPTIONS, reaches it. Keys that say what the program
writes and prints are read and have no effect. Collective over `comm`, a communicator of mpi4py or petsc4py; None: all
of PETSc's world.

Raises UserError with the message of the program where an option cannot be used, FileError where a file cannot be read,
on all ranks. What only a model shows - solvers, integrators, contacts - is checked by `Model`.)");
  type.def(py::init([](const py::object& source, const py::object& comm, const py::kwargs& options) {
             return std::make_shared<GivenCase>(source, comm, options);
           }),
           py::arg("case") = py::none(), py::arg("comm") = py::none());
  type.def_property_readonly(
      "comm", [](const GivenCase& self) { return self.comm().in_python(); }, "The communicator, of mpi4py.");
  type.def_property_readonly("options", &GivenCase::options, "All options that were given, as text, without the dash.");
  type.def_property_readonly(
      "filter_frequency",
      [](const GivenCase& self) { return self.input().filter.filtered() ? self.input().filter.filter_frequency : 0.0; },
      "[rad/s], of `auto` the one that was found; 0: no filter, or modes alone.");
  type.def_property_readonly(
      "end_time", [](const GivenCase& self) { return self.input().end_time; }, "[s], `ts_max_time`.");
  type.def_property_readonly(
      "supports", [](const GivenCase& self) { return self.input().supports.size(); },
      "How many, floor, ground and faces of strikers and pairs included.");
}

}  // namespace udar::python
