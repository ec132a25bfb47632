#include "udar/io/results_file.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "udar/io/hdf5_file.hpp"
#include "udar/io/versions.hpp"
#include "udar/motion/motion_state.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/log.hpp"

namespace udar::io {
namespace {

/// The energy balance as it stands in the file; events stand there as they are in memory, so that HDF5 has nothing to
/// convert.
struct EnergyRow {
  double time;
  double kinetic;
  double line_strain;
  double fictitious_springs;
  double load_potential;
  double support_springs;
  double load_work;
  double support_work;
  double base_work;
  double lost_in_impacts;
  double lost_in_dampers;
  double radiated;
  double lost_in_hinges;
  double total;
  double drift;
};

struct Column {
  const char* name;
  std::size_t offset;
  hid_t type;
};

Hdf5Id record_type(std::size_t size, std::initializer_list<Column> columns) {
  Hdf5Id type{H5Tcreate(H5T_COMPOUND, size), H5Tclose};
  for (const Column& column : columns) {
    H5Tinsert(type, column.name, column.offset, column.type);
  }
  return type;
}

constexpr bool kWideIndices = sizeof(PetscInt) == sizeof(std::int64_t);

Hdf5Id impact_type() {
  const hid_t index = kWideIndices ? H5T_NATIVE_INT64 : H5T_NATIVE_INT32;
  return record_type(sizeof(ImpactRecord),
                     {{"time", offsetof(ImpactRecord, time), H5T_NATIVE_DOUBLE},
                      {"node", offsetof(ImpactRecord, node), index},
                      {"x", offsetof(ImpactRecord, x), H5T_NATIVE_DOUBLE},
                      {"support", offsetof(ImpactRecord, support), index},
                      {"velocity_before", offsetof(ImpactRecord, velocity_before), H5T_NATIVE_DOUBLE},
                      {"velocity_after", offsetof(ImpactRecord, velocity_after), H5T_NATIVE_DOUBLE},
                      {"impulse", offsetof(ImpactRecord, impulse), H5T_NATIVE_DOUBLE},
                      {"energy_loss", offsetof(ImpactRecord, energy_loss), H5T_NATIVE_DOUBLE}});
}

Hdf5Id merged_type() {
  const hid_t index = kWideIndices ? H5T_NATIVE_INT64 : H5T_NATIVE_INT32;
  return record_type(sizeof(MergedImpact), {{"time", offsetof(MergedImpact, time), H5T_NATIVE_DOUBLE},
                                            {"last_time", offsetof(MergedImpact, last_time), H5T_NATIVE_DOUBLE},
                                            {"node", offsetof(MergedImpact, node), index},
                                            {"x", offsetof(MergedImpact, x), H5T_NATIVE_DOUBLE},
                                            {"support", offsetof(MergedImpact, support), index},
                                            {"impacts", offsetof(MergedImpact, impacts), index},
                                            {"speed_max", offsetof(MergedImpact, speed_max), H5T_NATIVE_DOUBLE},
                                            {"impulse", offsetof(MergedImpact, impulse), H5T_NATIVE_DOUBLE},
                                            {"energy_loss", offsetof(MergedImpact, energy_loss), H5T_NATIVE_DOUBLE}});
}

Hdf5Id rest_type() {
  static_assert(sizeof(bool) == 1);
  const hid_t index = kWideIndices ? H5T_NATIVE_INT64 : H5T_NATIVE_INT32;
  return record_type(sizeof(RestRecord), {{"time", offsetof(RestRecord, time), H5T_NATIVE_DOUBLE},
                                          {"node", offsetof(RestRecord, node), index},
                                          {"x", offsetof(RestRecord, x), H5T_NATIVE_DOUBLE},
                                          {"support", offsetof(RestRecord, support), index},
                                          {"release", offsetof(RestRecord, release), H5T_NATIVE_UINT8}});
}

Hdf5Id energy_type() {
  return record_type(sizeof(EnergyRow),
                     {{"time", offsetof(EnergyRow, time), H5T_NATIVE_DOUBLE},
                      {"kinetic", offsetof(EnergyRow, kinetic), H5T_NATIVE_DOUBLE},
                      {"line_strain", offsetof(EnergyRow, line_strain), H5T_NATIVE_DOUBLE},
                      {"fictitious_springs", offsetof(EnergyRow, fictitious_springs), H5T_NATIVE_DOUBLE},
                      {"load_potential", offsetof(EnergyRow, load_potential), H5T_NATIVE_DOUBLE},
                      {"support_springs", offsetof(EnergyRow, support_springs), H5T_NATIVE_DOUBLE},
                      {"load_work", offsetof(EnergyRow, load_work), H5T_NATIVE_DOUBLE},
                      {"support_work", offsetof(EnergyRow, support_work), H5T_NATIVE_DOUBLE},
                      {"base_work", offsetof(EnergyRow, base_work), H5T_NATIVE_DOUBLE},
                      {"lost_in_impacts", offsetof(EnergyRow, lost_in_impacts), H5T_NATIVE_DOUBLE},
                      {"lost_in_dampers", offsetof(EnergyRow, lost_in_dampers), H5T_NATIVE_DOUBLE},
                      {"radiated", offsetof(EnergyRow, radiated), H5T_NATIVE_DOUBLE},
                      {"lost_in_hinges", offsetof(EnergyRow, lost_in_hinges), H5T_NATIVE_DOUBLE},
                      {"total", offsetof(EnergyRow, total), H5T_NATIVE_DOUBLE},
                      {"drift", offsetof(EnergyRow, drift), H5T_NATIVE_DOUBLE}});
}

Hdf5Id contact_type() {
  return record_type(sizeof(ContactRow), {{"time", offsetof(ContactRow, time), H5T_NATIVE_DOUBLE},
                                          {"masses", offsetof(ContactRow, masses), H5T_NATIVE_DOUBLE},
                                          {"x_min", offsetof(ContactRow, x_min), H5T_NATIVE_DOUBLE},
                                          {"x_max", offsetof(ContactRow, x_max), H5T_NATIVE_DOUBLE},
                                          {"force", offsetof(ContactRow, force), H5T_NATIVE_DOUBLE},
                                          {"impulse", offsetof(ContactRow, impulse), H5T_NATIVE_DOUBLE}});
}

constexpr const char* kContact = "/contact";
constexpr const char* kForce = "/supports/force";
constexpr const char* kImpulse = "/supports/impulse";
constexpr const char* kLift = "/supports/lift";

constexpr const char* kFieldTime = "/fields/time";

/// A unit on a dataset; of a table those of its columns, in their order.
void add_units(Hdf5File& file, const std::string& name, const std::string& units) {
  file.add_attribute(name, "units", units);
}

/// What a reader must know of a field to show it.
void add_description(Hdf5File& file, const std::string& path, const FieldInfo& field) {
  add_units(file, path, std::string{field.unit});
  file.add_attribute(path, "label", std::string{field.label.empty() ? field.name : field.label});
  file.add_attribute(path, "where", std::string{field.where == Where::points ? "points" : "cells"});
}

/// Where nodes stand, which they are, and how they move.
void add_nodes(Hdf5File& file, const RunLayout& layout) {
  const MassPoints& points = *layout.points;
  const PointOrder& order = layout.rows->nodes();
  std::array<std::vector<double>, 3> place;
  std::vector<double> mass;
  std::vector<std::int64_t> number;
  std::vector<std::int64_t> direction;
  for (const std::size_t point : layout.rows->a_point()) {
    const Place at = points.place(point);
    place[0].push_back(at.x);
    place[1].push_back(at.y);
    place[2].push_back(at.z);
    mass.push_back(layout.rows->mass(point));
    number.push_back(layout.rows->number(point));
    direction.push_back(static_cast<std::int64_t>(points.direction(point)));
  }
  constexpr std::array kAxes{"/x", "/y", "/z"};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    int there = axis == 0 || std::ranges::any_of(place[axis], [](double at) { return at != 0.0; }) ? 1 : 0;
    MPI_Allreduce(MPI_IN_PLACE, &there, 1, MPI_INT, MPI_LOR, layout.comm());
    if (there != 0) {
      file.add_node_values(kAxes[axis], order.range(), order.to_user(place[axis]));
      add_units(file, kAxes[axis], "m");
    }
  }
  file.add_node_values("/mass", order.range(), order.to_user(mass));
  add_units(file, "/mass", "kg");
  file.add_node_values("/node", order.range(), order.to_user(number));
  add_units(file, "/node", "1");
  if (!layout.rows->upright() && !layout.rows->grouped()) {
    file.add_node_values("/direction", order.range(), order.to_user(direction));
    add_units(file, "/direction", "1");
  }
}

/// Of nodes that are held in some direction; nothing where none is.
void add_held(Hdf5File& file, const RunLayout& layout) {
  std::vector<std::int64_t> held(layout.rows->a_point().size(), 0);
  int any = 0;
  for (std::size_t point = 0; point < layout.points->points(); ++point) {
    if (layout.points->fixed(point)) {
      any = 1;
      if (const auto row = layout.rows->row(point); row) {
        held[*row] = 1;
      }
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, &any, 1, MPI_INT, MPI_LOR, layout.comm());
  if (any != 0) {
    file.add_node_values("/held", layout.nodes(), layout.rows->nodes().to_user(held));
    add_units(file, "/held", "1");
  }
}

/// What nodes are the corners of, and what of the user's model that is.
void add_cells(Hdf5File& file, const RunLayout& layout) {
  const PointOrder& order = layout.rows->cells();
  const Topology& topology = layout.rows->topology();
  const auto corners = static_cast<int>(Topology::corners_of(topology.shape));
  file.add_node_values("/cells", order.range(), order.to_user(layout.rows->nodes().rows_of(topology.corners), corners),
                       corners);
  add_units(file, "/cells", "1");
  if (layout.members) {
    file.add_node_values("/member", order.range(), order.to_user(topology.member));
    add_units(file, "/member", "1");
  }
  if (layout.tubes) {
    file.add_node_values("/member_radius", order.range(), order.to_user(topology.radius));
    add_units(file, "/member_radius", "m");
    std::vector<double> of_corners;
    for (const double radius : topology.radius) {
      of_corners.insert(of_corners.end(), static_cast<std::size_t>(corners), radius);
    }
    const PointOrder& nodes = layout.rows->nodes();
    file.add_node_values("/radius", nodes.range(), nodes.to_user(nodes.largest(topology.corners, of_corners)));
    add_units(file, "/radius", "m");
  }
}

/// What a run that goes on may have otherwise.
void set_program(Hdf5File& file, const RunLayout& layout) {
  int ranks = 1;
  MPI_Comm_size(layout.comm(), &ranks);
  file.remove_attribute("/", "options");
  file.add_attribute("/", "options", layout.options_text);
  file.remove_attribute("/", "ranks");
  file.add_attribute("/", "ranks", static_cast<std::int64_t>(ranks));
}

/// Which nodes touch each other, two of each pair.
void add_pairs(Hdf5File& file, const RunLayout& layout) {
  std::vector<PetscInt> nodes;
  for (const Strike& strike : layout.points->strikes()) {
    if (strike.of_nodes()) {
      nodes.insert(nodes.end(), {strike.centre, strike.gap});
    }
  }
  if (!nodes.empty()) {
    file.add_small("/pair_nodes", layout.numbers_of(nodes));
    add_units(file, "/pair_nodes", "1");
  }
}

void add_layout(Hdf5File& file, const RunLayout& layout) {
  for (const auto& [library, version] : library_versions()) {
    file.add_attribute("/", library + "_version", version);
  }
  if (layout.filter_frequency) {
    file.add_attribute("/", "filter_frequency", *layout.filter_frequency);
  }
  const bool only_points = layout.topology.shape == Topology::Shape::vertex;
  const PetscInt elements = range_of(layout.comm(), layout.topology.cells()).total;
  file.add_attribute("/", "structure", std::string{layout.topology.name});
  file.add_attribute("/", "elements", static_cast<std::int64_t>(only_points ? 0 : elements));
  file.add_group("/parameters");
  for (const auto& [name, value] : layout.parameters) {
    file.add_attribute("/parameters", name, value);
  }
  add_nodes(file, layout);
  add_held(file, layout);
  add_cells(file, layout);
  file.add_small("/gauge_node", layout.numbers_of(layout.gauges.node));
  add_units(file, "/gauge_node", "1");
  file.add_small("/gauge_position", layout.gauges.position);
  add_units(file, "/gauge_position", "m");
  if (!layout.rows->all()) {  // their nodes need have no rows
    file.add_small("/gauge_place", layout.places_of(layout.gauges.node));
    add_units(file, "/gauge_place", "m");
  }

  const auto add_of_supports = [&](const char* name, const char* units, auto value_of) {
    std::vector<double> values;
    values.reserve(layout.supports.size());
    for (const RunLayout::Support& support : layout.supports) {
      values.push_back(static_cast<double>(value_of(support)));
    }
    file.add_small(name, values);
    add_units(file, name, units);
  };
  using Support = RunLayout::Support;
  add_of_supports("/support_position", "m", [](const Support& support) { return support.position; });
  add_of_supports("/support_width", "m", [](const Support& support) { return support.width; });
  add_of_supports("/support_height", "m", [](const Support& support) { return support.height; });
  add_of_supports("/support_side", "1", [](const Support& support) { return support.side; });
  add_of_supports("/support_restitution", "1", [](const Support& support) { return support.restitution; });
  const auto add_faces = [&](const char* name, std::int64_t Support::* of) {
    std::vector<std::int64_t> numbers;
    std::ranges::transform(layout.supports, std::back_inserter(numbers), of);
    if (std::ranges::any_of(numbers, [](std::int64_t number) { return number >= 0; })) {
      file.add_small(name, numbers);
      add_units(file, name, "1");
    }
  };
  add_faces("/support_striker", &Support::striker);
  add_faces("/support_pair", &Support::pair);
  add_pairs(file, layout);
  constexpr std::array<std::pair<const char*, const char*>, 7> kSpace{{{"/support_normal_x", "1"},
                                                                       {"/support_normal_y", "1"},
                                                                       {"/support_normal_z", "1"},
                                                                       {"/support_y_from", "m"},
                                                                       {"/support_y_to", "m"},
                                                                       {"/support_z_from", "m"},
                                                                       {"/support_z_to", "m"}}};
  for (std::size_t k = 0; !layout.supports.empty() && k < layout.supports.front().space.size(); ++k) {
    add_of_supports(kSpace.at(k).first, kSpace.at(k).second, [k](const Support& support) { return support.space[k]; });
  }
  for (std::size_t k = 0; k < layout.supports.size(); ++k) {
    if (const Support& support = layout.supports[k]; support.field) {
      const std::string name = "/height_field_" + std::to_string(k);
      std::vector<double> height{support.field->height().begin(), support.field->height().end()};
      std::ranges::for_each(height, [&](double& value) { value += support.base; });
      file.add_small(name + "_x", support.field->x());
      file.add_small(name + "_z", support.field->z());
      file.add_small(name + "_height", height);
      for (const char* part : {"_x", "_z", "_height"}) {
        add_units(file, name + part, "m");
      }
    }
  }
  if (!layout.ground_x.empty()) {
    file.add_small("/ground_x", layout.ground_x);
    add_units(file, "/ground_x", "m");
    file.add_small("/ground_height", layout.ground_height);
    add_units(file, "/ground_height", "m");
  }
}

/// A table of records, or the one that is there.
void add_table(Hdf5File& file, const char* name, hid_t type, const char* units, int compression = 0) {
  file.add_records(name, type, compression);
  if (!file.has(name, "units")) {
    add_units(file, name, units);
  }
}

constexpr const char* kExtents = "results.h5 extents";
constexpr const char* kPieces = "results.h5";
constexpr const char* kFieldNames = "fields of results.h5";
const std::string kWaiting = "results.h5 waiting rows of ";
constexpr const char* kMerged = "/impacts_merged";

std::string names_of(const std::vector<FileField>& fields) {
  std::string names;
  for (const FileField& field : fields) {
    names.append(names.empty() ? "" : ", ").append(field.name);
  }
  return names.empty() ? "none" : names;
}

/// Rows of fields stand side by side: none may begin later, or end earlier.
void require_same_fields(const RunLayout& layout, const std::vector<FileField>& fields) {
  const auto there = layout.earlier->texts.find(kFieldNames);
  if (there != layout.earlier->texts.end() && there->second != names_of(fields)) {
    throw InputError{"output fields: results.h5 has " + there->second +
                     "; a run that goes on in it has the same, not " + names_of(fields)};
  }
}

std::unique_ptr<Hdf5File> open_results(const RunLayout& layout, const std::string& path) {
  if (layout.earlier == nullptr) {
    return std::make_unique<Hdf5File>(layout.comm(), path, Hdf5File::Access::create);
  }
  return std::make_unique<Hdf5File>(
      layout.comm(), path,
      Hdf5File::Mark{.extents = layout.earlier->table(kExtents), .pieces = layout.earlier->text(kPieces)});
}

}  // namespace

ResultsFile::ResultsFile(const RunLayout& layout, const std::string& path)
    : file_{open_results(layout, path)},
      rows_{layout.rows},
      fields_{layout.fields_in_files()},
      supports_{static_cast<PetscInt>(layout.supports.size())},
      anew_{layout.earlier == nullptr} {
  int rank = 0;
  MPI_Comm_rank(layout.comm(), &rank);
  first_rank_ = rank == 0;
  if (anew_) {
    add_layout(*file_, layout);
    file_->add_group("/fields");
  } else {
    require_same_fields(layout, fields_);
  }
  set_program(*file_, layout);
  add_table(*file_, kFieldTime, H5T_NATIVE_DOUBLE, "s");
  for (const FileField& field : fields_) {
    file_->add_rows(field.path(), field.flag ? H5T_NATIVE_UINT8 : H5T_NATIVE_DOUBLE,
                    rows_->order_of(field.where).range().total, field.components, layout.content.compression);
    if (anew_) {
      add_description(*file_, field.path(), field);
    }
  }
  const int compression = layout.content.compression;
  add_table(*file_, "/impacts", impact_type(), "s,1,m,1,m/s,m/s,N s,J", compression);
  if (layout.content.impacts.merged) {
    add_table(*file_, kMerged, merged_type(), "s,s,1,m,1,1,m/s,N s,J", compression);
  }
  add_table(*file_, "/rests", rest_type(), "s,1,m,1,1", compression);
  for (const auto& [table, none] : file_->waiting()) {
    if (!anew_ && layout.earlier->texts.contains(kWaiting + table.substr(1))) {
      file_->set_waiting(table, layout.earlier->text(kWaiting + table.substr(1)));
    }
  }
  add_table(*file_, "/energy", energy_type(), "s,J,J,J,J,J,J,J,J,J,J,J,J,J,1");
  file_->flush();
  field_rows_ = field_rows_on_disk_ = file_->rows(kFieldTime);
}

void ResultsFile::save(MotionState& state) const {
  Hdf5File::Mark mark = file_->mark();
  state.tables[kExtents] = std::move(mark.extents);
  state.texts[kPieces] = std::move(mark.pieces);
  state.texts[kFieldNames] = names_of(fields_);
  for (auto& [table, rows] : file_->waiting()) {
    state.texts[kWaiting + table.substr(1)] = std::move(rows);  // without the slash
  }
}

std::vector<double> ResultsFile::field_times() const {
  return field_rows_ > 0 ? file_->read_small(kFieldTime) : std::vector<double>{};
}

ResultsFile::~ResultsFile() = default;

void ResultsFile::append_fields(const Snapshot& state) {
  const petsc::LogScope scope{petsc::log_events().fields};
  // Space for the whole row first: a row that does not fit leaves none of its fields behind.
  std::uint64_t bytes = file_->growth(kFieldTime);
  for (const FileField& field : fields_) {
    bytes += file_->growth(field.path());
  }
  file_->reserve(bytes);

  for (const FileField& field : fields_) {
    append_field(field, state.fields[field.source]);
  }
  file_->append_records(kFieldTime, &state.time, first_rank_ ? 1 : 0);
  ++field_rows_;
  flush_if_due();
}

void ResultsFile::append_field(const FileField& field, const Field& shown) {
  const PointOrder& order = rows_->order_of(field.where);
  if (rows_->as_shown(field)) {
    file_->append_row(field.path(), order.range(), shown.data());
  } else if (field.flag) {
    const std::vector<std::uint8_t> own = rows_->flags(field, shown.flags());
    file_->append_row(field.path(), order.range(), order.to_user(own, field.components).data());
  } else {
    const std::vector<double> own = rows_->numbers(field, shown.numbers());
    file_->append_row(field.path(), order.range(), order.to_user(own, field.components).data());
  }
}

template <class Row>
void ResultsFile::append_events(const char* table, RowStream<Row>& rows) {
  file_->append_records(table, rows.size(), [&](std::size_t count) { return rows.next(count).data(); });
  flush_if_due();
}

void ResultsFile::append_impacts(RowStream<ImpactRecord> rows) { append_events("/impacts", rows); }
void ResultsFile::append_merged(RowStream<MergedImpact> rows) { append_events(kMerged, rows); }
void ResultsFile::append_rests(RowStream<RestRecord> rows) { append_events("/rests", rows); }

void ResultsFile::append_energy(std::span<const double> times, std::span<const EnergyLedger> rows) {
  assert(times.size() == rows.size());
  std::vector<EnergyRow> records;
  records.reserve(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const EnergyLedger& row = rows[i];
    records.push_back({times[i], row.kinetic, row.line_strain, row.fictitious_springs, row.load_potential,
                       row.support_springs, row.load_work, row.support_work, row.base_work, row.lost_in_impacts,
                       row.lost_in_dampers, row.radiated, row.lost_in_hinges, row.total(), row.drift()});
  }
  file_->append_records("/energy", records.data(), first_rank_ ? records.size() : 0);
  flush_if_due();
}

void ResultsFile::add_contact(double force_window, bool supports_move) {
  add_table(*file_, kContact, contact_type(), "s,1,m,m,N,N s");
  if (anew_) {
    file_->add_group("/supports");
  }
  file_->remove_attribute("/supports", "force_window");
  file_->add_attribute("/supports", "force_window", force_window);
  const auto add_rows = [this](const char* name, const char* units) {
    file_->add_rows(name, H5T_NATIVE_DOUBLE, supports_);
    if (anew_) {
      add_units(*file_, name, units);
    }
  };
  add_rows(kForce, "N");
  add_rows(kImpulse, "N s");
  if (supports_move) {
    add_rows(kLift, "m");
  }
  flush_if_due();
}

void ResultsFile::append_contact(std::span<const ContactRow> rows, std::span<const double> force,
                                 std::span<const double> impulse, std::span<const double> lift) {
  const std::size_t count = force.size() / static_cast<std::size_t>(supports_);
  if (count == 0) {
    return;
  }
  file_->reserve(file_->growth(kContact, count) + file_->growth(kForce, count) + file_->growth(kImpulse, count) +
                 (lift.empty() ? 0 : file_->growth(kLift, count)));
  const NodeRange all{.begin = first_rank_ ? 0 : supports_, .end = supports_, .total = supports_};
  file_->append_rows(kForce, all, count, force.data());
  file_->append_rows(kImpulse, all, count, impulse.data());
  if (!lift.empty()) {
    file_->append_rows(kLift, all, count, lift.data());
  }
  file_->append_records(kContact, rows.data(), first_rank_ ? count : 0);
  flush_if_due();
}

void ResultsFile::add_envelope(std::span<const EnvelopeColumn> columns) {
  file_->add_group("/envelope");
  for (const EnvelopeColumn& column : columns) {
    const PointOrder& order = rows_->order_of(column.field.where);
    const std::string path = "/envelope/" + column.name;
    file_->add_node_values(path, order.range(), order.to_user(column.values));
    add_description(*file_, path, column.field);
  }
  flush_if_due();
}

void ResultsFile::flush() {
  file_->flush();
  field_rows_on_disk_ = field_rows_;
}

void ResultsFile::flush_if_due() {
  if (file_->flush_if_due()) {
    field_rows_on_disk_ = field_rows_;
  }
}

void ResultsFile::close() { file_->close(); }

}  // namespace udar::io
