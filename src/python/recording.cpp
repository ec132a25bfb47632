/// @file
/// The class `Recording` of Python: tables in memory as arrays of NumPy.

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "python/motion.hpp"
#include "udar/io/csv.hpp"

namespace udar::python {
namespace {

template <class Record>
py::array as_records(const std::vector<Record>& records) {
  return py::array_t<Record>(static_cast<py::ssize_t>(records.size()), records.data());
}

/// Columns are fields of the array's type.
py::array as_records(const io::RecordedTable& table) {
  py::list columns;
  for (const std::string& name : table.columns) {
    columns.append(py::make_tuple(name, "f8"));
  }
  const auto rows = static_cast<py::ssize_t>(table.numbers.size() / table.columns.size());
  py::array array{py::dtype::from_args(columns), std::vector<py::ssize_t>{rows}};
  std::memcpy(array.mutable_data(), table.numbers.data(), table.numbers.size() * sizeof(double));
  return array;
}

/// A row for each time.
py::array_t<double> as_rows(const io::Recording& recording, std::span<const double> numbers) {
  const auto rows = static_cast<py::ssize_t>(recording.times().size());
  const auto columns = rows > 0 ? static_cast<py::ssize_t>(numbers.size()) / rows : 0;
  return py::array_t<double>(std::vector<py::ssize_t>{rows, columns}, numbers.data());
}

py::array_t<double> field(const RecordingOfMotion& self, const std::string& name) {
  const io::Recording::KeptField& kept = self.recording->field(name);
  const auto rows = static_cast<py::ssize_t>(self.recording->times().size());
  const py::ssize_t components = kept.components;
  const auto places = rows > 0 ? static_cast<py::ssize_t>(kept.rows.size()) / (rows * components) : 0;
  const std::vector<py::ssize_t> shape{rows, places, components};
  return py::array_t<double>(components > 1 ? shape : std::vector<py::ssize_t>{rows, places}, kept.rows.data());
}

/// A node as fields count them.
struct NodeRecord {
  std::int64_t number;
  double x, y, z;
};

py::array nodes(const RecordingOfMotion& self) {
  std::vector<NodeRecord> all;
  for (const std::size_t point : self.recording->points_of_nodes()) {
    const auto [x, y, z] = self.motion->points().place(point);
    all.push_back({.number = self.recording->number(point), .x = x, .y = y, .z = z});
  }
  return as_records(all);
}

}  // namespace

void add_recording(py::module_& module) {
  PYBIND11_NUMPY_DTYPE(ImpactRecord, time, node, x, support, velocity_before, velocity_after, impulse, energy_loss);
  PYBIND11_NUMPY_DTYPE(RestRecord, time, node, x, support, release);
  PYBIND11_NUMPY_DTYPE(NodeRecord, number, x, y, z);
  PYBIND11_NUMPY_DTYPE(io::ContactRow, time, masses, x_min, x_max, force, impulse);
  using Self = RecordingOfMotion;
  py::class_<Self> type(module, "Recording", R"(What a model's files would hold, in memory: the same numbers to the bit.

Tables are arrays of records whose fields are the columns of docs/output.md, so that `pandas.DataFrame(table)` makes a
frame of one. Methods are collective and give every rank the same, unless they say otherwise; arrays are copies. It
keeps its model in memory.)");
  type.def_property_readonly(
      "times",
      [](const Self& self) {
        const std::span<const double> times = self.recording->times();
        return py::array_t<double>(static_cast<py::ssize_t>(times.size()), times.data());
      },
      "Of the rows [s].");
  type.def(
      "gauges", [](const Self& self) { return as_records(self.recording->gauges()); },
      "gauges.csv: time [s], then mass_0 [m], velocity_0 [m/s], line_0 [m], ...; shape (rows,).");
  type.def(
      "strikers", [](const Self& self) { return as_records(self.recording->strikers()); },
      "strikers.csv: time [s], then position_0 [m], velocity_0 [m/s], ...; shape (rows,).");
  type.def(
      "energy", [](const Self& self) { return as_records(self.recording->energy()); },
      "energy.csv: time [s], energies [J], drift [1]; shape (rows,). Not collective.");
  type.def(
      "contact", [](const Self& self) { return as_records(self.recording->contact()); },
      "time [s], masses in contact since the row before, x_min, x_max [m], force [N] and impulse [N s] of all "
      "supports; "
      "shape (rows,).");
  type.def(
      "support_force", [](const Self& self) { return as_rows(*self.recording, self.recording->support_force()); },
      "Of each support on the masses [N], y up, means over `output_force_window`; shape (rows, supports). Not "
      "collective.");
  type.def(
      "support_impulse", [](const Self& self) { return as_rows(*self.recording, self.recording->support_impulse()); },
      "Of each support since t = 0 [N s], y up; shape (rows, supports). Not collective.");
  type.def(
      "peak_force",
      [](const Self& self) {
        const std::span<const double> peaks = self.recording->forces().peaks();
        return py::array_t<double>(static_cast<py::ssize_t>(peaks.size()), peaks.data());
      },
      "Of each support the force of largest size [N], between rows, too; shape (supports,). Not collective.");
  type.def(
      "impacts", [](const Self& self) { return as_records(self.recording->impacts()); },
      "impacts.csv: time [s], node, x [m], support, velocity_before, velocity_after [m/s], impulse [N s], energy_loss "
      "[J]; by time, then node; shape (impacts,).");
  type.def(
      "rests", [](const Self& self) { return as_records(self.recording->rests()); },
      "rests.csv: time [s], node, x [m], support, release: False where the mass came to rest; shape (events,).");
  type.def("nodes", &nodes,
           "number in the user's model, x, y, z [m] where nothing strains the structure: of this rank's nodes, in the "
           "order of `field`; shape (nodes,). Not collective.");
  type.def(
      "field", &field, py::arg("name"),
      "Rows of a field that `Model.record` was asked for, as docs/output.md has it, of this rank's nodes or cells; "
      "shape (rows, nodes), of vectors (rows, nodes, 3). Not collective. Raises UserError for another.");
}

}  // namespace udar::python
