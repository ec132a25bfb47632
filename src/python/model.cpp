/// @file
/// The class `Model` of Python.

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "python/motion.hpp"
#include "udar/petsc/array.hpp"
#include "udar/petsc/error.hpp"

namespace udar::python {
namespace {

/// What Python has of a motion, until it is closed.
class OpenMotion {
 public:
  explicit OpenMotion(std::shared_ptr<Motion> motion) : motion_{std::move(motion)} {}
  OpenMotion(const OpenMotion&) = delete;
  OpenMotion& operator=(const OpenMotion&) = delete;
  ~OpenMotion() { close(); }

  void close() { let_go(std::exchange(motion_, nullptr)); }
  [[nodiscard]] std::shared_ptr<Motion> shared() const {
    if (motion_ == nullptr) {
      throw InputError{"the model is closed"};
    }
    return motion_;
  }
  [[nodiscard]] Motion& get() const { return *shared(); }

 private:
  std::shared_ptr<Motion> motion_;
};

std::unique_ptr<OpenMotion> make(const std::shared_ptr<GivenCase>& given) {
  let_go(nullptr);
  return std::make_unique<OpenMotion>(given->within([&] { return std::make_shared<Motion>(given); }));
}

/// One number for each coordinate of this rank's points, in a Vec of its own.
py::object as_vec(const Motion& motion, std::span<const double> values) {
  petsc::Vector vector;
  UDAR_CALL(VecCreate(motion.comm(), vector.put()));
  UDAR_CALL(VecSetSizes(vector, static_cast<PetscInt>(values.size()), PETSC_DETERMINE));
  UDAR_CALL(VecSetType(vector, VECSTANDARD));
  {
    const petsc::WriteArray array{vector};
    std::ranges::copy(values, array.values());
  }
  return as_petsc4py(vector);
}

py::array_t<double> as_array(std::span<const double> values) {
  return py::array_t<double>(static_cast<py::ssize_t>(values.size()), values.data());
}

/// The masses' displacement and the force on the line, as Python gives them.
struct Given {
  petsc::ReadArray displacement;
  std::optional<petsc::ReadArray> force;

  Given(const Motion& motion, const py::object& displacement_of, const py::object& force_of)
      : displacement{vector_of(motion.comm(), displacement_of, "displacement", motion.points().coordinates())} {
    if (!force_of.is_none()) {
      force.emplace(vector_of(motion.comm(), force_of, "force", motion.points().coordinates()));
    }
  }
  [[nodiscard]] FilterColumn column() const {
    return {.displacement = displacement.values(), .force = force ? force->values() : nullptr};
  }
};

py::object solve(const OpenMotion& self, const py::object& displacement, const py::object& force) {
  Motion& motion = self.get();
  std::vector<double> stretch(motion.points().coordinates());
  motion.given().within([&] {
    const Given given{motion, displacement, force};
    FilterColumn column = given.column();
    column.stretch = stretch.data();
    motion.line().solve({&column, 1});
  });
  return as_vec(motion, stretch);
}

void require_plain_unknowns(const Motion& motion) {
  if (!motion.points().frames().empty()) {
    throw InputError{"the unknowns of nodes with axes of their own are not their points': use solve"};
  }
}

py::object right_hand_side(const OpenMotion& self, const py::object& displacement, const py::object& force) {
  Motion& motion = self.get();
  petsc::Vector right;
  motion.given().within([&] {
    require_plain_unknowns(motion);
    const Given given{motion, displacement, force};
    UDAR_CALL(MatCreateVecs(motion.op(), nullptr, right.put()));
    const petsc::WriteArray array{right};
    const FilterOperator& filter = motion.line().filter_operator();
    filter.right_hand_side(given.column(), {array.values(), filter.unknowns()});
  });
  return as_petsc4py(right);
}

py::object stretch(const OpenMotion& self, const py::object& unknowns, const py::object& displacement) {
  Motion& motion = self.get();
  std::vector<double> values(motion.points().coordinates());
  motion.given().within([&] {
    require_plain_unknowns(motion);
    const Given given{motion, displacement, py::none()};
    const FilterOperator& filter = motion.line().filter_operator();
    const petsc::ReadArray solution{vector_of(motion.comm(), unknowns, "unknowns", filter.unknowns())};
    FilterColumn column = given.column();
    column.stretch = values.data();
    filter.extract({solution.values(), filter.unknowns()}, column);
  });
  return as_vec(motion, values);
}

/// Whether somebody asks to stop. @throws on all ranks where the callback failed on one, what it threw there
bool told(const Motion& motion, const py::object& callback, const py::object& self) {
  int stop = 0;
  std::string failure;
  std::exception_ptr own;
  try {
    const py::object answer = callback(self);
    stop = answer.is_none() ? 0 : PyObject_IsTrue(answer.ptr());
    if (stop < 0) {
      throw py::error_already_set();
    }
  } catch (const py::error_already_set& error) {
    own = std::current_exception();
    failure = std::string{"the callback failed on another rank: "} + error.what();
    failure.resize(std::min(failure.find('\n'), failure.size()));
  }
  try {
    throw_together<SolveError>(motion.comm(), failure);
  } catch (const SolveError&) {
    if (own != nullptr) {
      std::rethrow_exception(own);
    }
    throw;
  }
  MPI_Allreduce(MPI_IN_PLACE, &stop, 1, MPI_INT, MPI_MAX, motion.comm());
  return stop != 0;
}

double advance(const py::object& python_self, const std::optional<double>& until, const py::object& callback) {
  const auto& self = python_self.cast<const OpenMotion&>();
  const std::shared_ptr<Motion> motion = self.shared();  // the callback may close the model
  const double end = until.value_or(std::numeric_limits<double>::infinity());
  if (callback.is_none()) {
    motion->given().within([&] { motion->advance(end); });
    return motion->dynamics().time();
  }
  bool stop = motion->dynamics().time() >= end;
  while (!stop && !motion->dynamics().completed()) {
    const PetscInt steps = motion->dynamics().counts().steps;
    motion->given().within([&] { motion->step(); });
    const bool moved = motion->dynamics().counts().steps > steps;  // else -ts_max_steps has been reached
    stop = !moved || told(*motion, callback, python_self) || motion->dynamics().time() >= end;
  }
  return motion->dynamics().time();
}

double step(const OpenMotion& self) {
  Motion& motion = self.get();
  motion.given().within([&] { motion.step(); });
  return motion.dynamics().time();
}

py::dict counts(const OpenMotion& self) {
  const RunCounts counts = self.get().dynamics().counts();
  py::dict all;
  all["steps"] = counts.steps;
  all["rejected_steps"] = counts.rejected_steps;
  all["line_solves"] = counts.line_solves;
  all["impacts"] = counts.impacts;
  all["rests"] = counts.rests;
  all["releases"] = counts.releases;
  all["resting"] = counts.resting;
  return all;
}

py::array_t<double> places(const OpenMotion& self) {
  const MassPoints& points = self.get().points();
  py::array_t<double> array({static_cast<py::ssize_t>(points.points()), py::ssize_t{3}});
  auto values = array.mutable_unchecked<2>();
  for (std::size_t point = 0; point < points.points(); ++point) {
    const auto row = static_cast<py::ssize_t>(point);
    const Place place = points.place(point);
    values(row, 0) = place.x;
    values(row, 1) = place.y;
    values(row, 2) = place.z;
  }
  return array;
}

std::unique_ptr<RecordingOfMotion> record(const OpenMotion& self, const std::optional<double>& interval,
                                          const std::vector<std::string>& fields) {
  Motion& motion = self.get();
  const double between = interval.value_or(motion.given().input().output.interval);
  io::Recording& made = motion.given().within([&]() -> io::Recording& { return motion.record(between, fields); });
  return std::make_unique<RecordingOfMotion>(self.shared(), made);
}

void add_state(py::class_<OpenMotion>& type) {
  type.def_property_readonly(
      "time", [](const OpenMotion& self) { return self.get().dynamics().time(); }, "[s], of the last step's end.");
  type.def_property_readonly(
      "end_time", [](const OpenMotion& self) { return self.get().dynamics().end_time(); }, "[s], `ts_max_time`.");
  type.def_property_readonly(
      "finished", [](const OpenMotion& self) { return self.get().dynamics().completed(); },
      "Whether `advance` has reached the end.");
  type.def_property_readonly(
      "comm", [](const OpenMotion& self) { return self.get().given().comm().in_python(); },
      "The communicator, of mpi4py.");
  type.def_property_readonly("counts", &counts,
                             "Steps, line solves, impacts, rests and releases so far, masses at rest now, of all "
                             "ranks.");
  type.def_property_readonly(
      "support_impulses", [](const OpenMotion& self) { return as_array(self.get().dynamics().support_impulses()); },
      "Of each support on the masses so far [N s], y up, the same on every rank; a copy.");
  type.def_property_readonly(
      "masses", [](const OpenMotion& self) { return as_array(self.get().points().mass()); },
      "[kg], of this rank's coordinates, as vectors have them; a copy.");
  type.def_property_readonly(
      "places", &places, "x, y, z [m] of this rank's points where nothing strains the structure, shape (points, 3).");
  type.def(
      "mass_position",
      [](const OpenMotion& self) { return as_vec(self.get(), self.get().dynamics().masses().position); },
      "Ym now [m]: a petsc4py Vec of its own, one number a coordinate, component by component on each rank. "
      "Collective.");
  type.def(
      "mass_velocity",
      [](const OpenMotion& self) { return as_vec(self.get(), self.get().dynamics().masses().velocity); },
      "Vm now [m/s], as `mass_position`. Collective.");
  type.def(
      "line_position",
      [](const OpenMotion& self) {
        Motion& motion = self.get();
        return as_vec(motion, motion.given().within([&] { return motion.line_position(); }));
      },
      "Yc, where the massless line is now [m], as `mass_position`. Collective: a line solve, which the motion does not "
      "notice.");
}

void add_solver(py::class_<OpenMotion>& type) {
  type.def_property_readonly(
      "ksp", [](const OpenMotion& self) { return as_petsc4py(self.get().solver()); },
      "The petsc4py KSP of wf^2 M + C, prefix `filter_`, which the model goes on using; in the operator's own, scaled "
      "unknowns.");
  type.def_property_readonly(
      "pc", [](const OpenMotion& self) { return as_petsc4py(self.get().preconditioner()); },
      "Its petsc4py PC, of type `chain` or `network` where one of these serves.");
  type.def_property_readonly(
      "operator", [](const OpenMotion& self) { return as_petsc4py(self.get().op()); },
      "Its petsc4py Mat: the product, without a matrix where the structure allows that.");
  type.def("solve", &solve, py::arg("displacement"), py::arg("force") = py::none(),
           R"(Stretch Yc - Ym of the line [m] for given masses and forces, a Vec as `mass_position`.

`displacement` is Ym minus the places where nothing is strained [m], `force` acts on the line [N]; petsc4py Vecs laid
out as `mass_position`. Collective. Raises UserError for vectors of another size, SolveError if the solve diverges.)");
  type.def("right_hand_side", &right_hand_side, py::arg("displacement"), py::arg("force") = py::none(),
           "wf^2 M Ym + F in the operator's unknowns, for `ksp.solve`: a new Vec. Collective. Raises UserError as "
           "`solve`, and where nodes have axes of their own.");
  type.def("stretch", &stretch, py::arg("unknowns"), py::arg("displacement"),
           "Yc - Ym [m] from what `ksp.solve` gave for that displacement, corrected modes left out: a new Vec. "
           "Collective. Raises as `right_hand_side`.");
}

}  // namespace

void add_model(py::module_& module) {
  py::class_<OpenMotion> type(module, "Model",
                              R"(A case in memory, from its start on. Collective over the case's `comm`.

Vectors have one number for each coordinate of this rank's points: with one component a number a point. They are
copies, and stay when the model goes. `ksp`, `pc` and `operator` are the model's own; it stays in memory as long as any
of them is held. `close`, or leaving `with`, gives it up on all ranks together. One call into udar at a time, from one
thread.

Raises UserError for what cannot be used, SolveError where modes or solvers fail, PetscError with PETSc's message.)");
  type.def(py::init(&make), py::arg("case"));
  add_state(type);
  add_solver(type);
  type.def("step", &step, "One step of the integrator; returns the time then [s]. Collective. Raises as `advance`.");
  type.def("advance", &advance, py::arg("until") = py::none(), py::arg("callback") = py::none(),
           R"(Steps until one ends at or behind the time `until` [s]; None: to the end. Returns the time then [s].

Steps are the integrator's, the same to the bit however the way is cut; rows at exact times are `record`'s.
`callback(model)` is called after each step on all ranks; where it says True on any, that was the last. Collective.

Raises SolveError if the integration or a solve fails, or a guard ends the run: the state is that of the last good step.
What the callback raises on one rank ends the call on all, as SolveError on the others; KeyboardInterrupt likewise.)");
  type.def("record", &record, py::arg("interval") = py::none(), py::arg("fields") = std::vector<std::string>{},
           R"(A `Recording` of all that follows, with rows every `interval` [s]; None: `output_interval`.

`fields` are names such as "moment", of docs/output.md, of which this rank's numbers are kept for each row.
Collective; before the first step, else UserError.)");
  type.def("close", &OpenMotion::close, "Gives the model up. Collective.");
  type.def("__enter__", [](const py::object& self) { return self; });
  type.def("__exit__", [](OpenMotion& self, const py::args& /*reason*/) { self.close(); });
}

}  // namespace udar::python
