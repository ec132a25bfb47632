#include "udar/io/vtkhdf.hpp"

#include <hdf5.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <numeric>
#include <system_error>
#include <utility>

#include "io/text_file.hpp"
#include "udar/io/hdf5_file.hpp"
#include "udar/petsc/error.hpp"

namespace udar::io {
namespace {

constexpr const char* kRoot = "/VTKHDF/";
/// Types of cells in VTK.
constexpr std::uint8_t kVertex = 1;
constexpr std::uint8_t kPolyVertex = 2;
constexpr std::uint8_t kPolyLine = 4;

using Extent = std::vector<hsize_t>;

Hdf5Id space_of(const Extent& extent) {
  return {H5Screate_simple(static_cast<int>(extent.size()), extent.data(), nullptr), H5Sclose};
}

hid_t type_of(double /*value*/) { return H5T_NATIVE_DOUBLE; }
hid_t type_of(std::int64_t /*value*/) { return H5T_NATIVE_INT64; }
hid_t type_of(std::uint8_t /*value*/) { return H5T_NATIVE_UINT8; }

/// Where in a virtual dataset all values of a dataset of results.h5, or of this file, stand.
struct Piece {
  std::string dataset;
  Extent shape;
  Extent start;
  Extent stride;
  Extent count;
  Extent block;
};

/// The file while it is written, by one rank alone. The first call that fails is the last.
class Writer {
 public:
  Writer(const std::string& path, std::string results)
      : results_{std::move(results)},
        file_{H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose} {
    ok_ = file_.valid();
  }

  void group(const std::string& name) {
    keep(Hdf5Id{H5Gcreate2(file_, name.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose}.valid());
  }

  void attribute(const std::string& object, const char* name, hid_t type, const Extent& extent, const void* values) {
    const Hdf5Id space = extent.empty() ? Hdf5Id{H5Screate(H5S_SCALAR), H5Sclose} : space_of(extent);
    const Hdf5Id attribute{
        H5Acreate_by_name(file_, object.c_str(), name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Aclose};
    keep(attribute.valid() && H5Awrite(attribute, type, values) >= 0);
  }

  void text(const std::string& object, const char* name, const std::string& value) {
    const Hdf5Id type{H5Tcopy(H5T_C_S1), H5Tclose};
    H5Tset_size(type, value.size());
    attribute(object, name, type, {}, value.data());
  }

  /// Values that are in this file.
  template <class Value>
  void values(const std::string& name, const std::vector<Value>& values, Extent extent = {}) {
    if (extent.empty()) {
      extent = {values.size()};
    }
    const hid_t type = type_of(Value{});
    const Hdf5Id data{H5Dcreate2(file_, name.c_str(), type, space_of(extent), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                      H5Dclose};
    keep(data.valid() && (values.empty() || H5Dwrite(data, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) >= 0));
  }

  /// Values that are elsewhere; `fill` where no piece has any. A piece whose dataset begins with `kRoot` is of this
  /// file.
  template <class Value>
  void view(const std::string& name, const Extent& extent, Value fill, const std::vector<Piece>& pieces) {
    const Hdf5Id creation{H5Pcreate(H5P_DATASET_CREATE), H5Pclose};
    const hid_t type = type_of(Value{});
    bool ok = H5Pset_fill_value(creation, type, &fill) >= 0;
    for (const Piece& piece : pieces) {
      const Hdf5Id place = space_of(extent);
      ok = ok && H5Sselect_hyperslab(place, H5S_SELECT_SET, piece.start.data(), piece.stride.data(), piece.count.data(),
                                     piece.block.data()) >= 0;
      const char* source = piece.dataset.starts_with(kRoot) ? "." : results_.c_str();
      ok = ok && H5Pset_virtual(creation, place, source, piece.dataset.c_str(), space_of(piece.shape)) >= 0;
    }
    ok = ok &&
         Hdf5Id{H5Dcreate2(file_, name.c_str(), type, space_of(extent), H5P_DEFAULT, creation, H5P_DEFAULT), H5Dclose}
             .valid();
    keep(ok);
  }

  /// Whether all went well.
  [[nodiscard]] bool close() {
    keep(H5Fclose(file_.release()) >= 0);
    return ok_;
  }

 private:
  void keep(bool ok) { ok_ = ok_ && ok; }

  std::string results_;
  Hdf5Id file_;
  bool ok_ = false;
};

hsize_t count_of(std::size_t value) { return value; }

/// The three parts of the grid, their points one after the other.
struct Parts {
  hsize_t nodes;
  hsize_t support_points;
  hsize_t rows;

  [[nodiscard]] hsize_t points() const { return 2 * nodes + support_points; }
  /// Where the points of a body begin.
  [[nodiscard]] hsize_t first(Body body) const { return body == Body::line ? 0 : nodes; }
  /// Rows of a field at the nodes of its body.
  [[nodiscard]] Piece data(const FieldInfo& field) const {
    const auto components = static_cast<hsize_t>(field.components);
    const std::string path = "/fields/" + std::string{field.name};
    if (components == 1) {
      return {path, {rows, nodes}, {first(field.body)}, {points()}, {rows}, {nodes}};
    }
    return {path, {rows, nodes, components}, {first(field.body), 0}, {points(), 1}, {rows, 1}, {nodes, components}};
  }
  /// Rows of values as the heights of vectors.
  [[nodiscard]] Piece height(const std::string& dataset, hsize_t first, hsize_t count) const {
    return {dataset, {rows, count}, {first, 1}, {points(), 1}, {rows, 1}, {count, 1}};
  }
  /// Values that do not change, one per node, in column `column` of an array.
  [[nodiscard]] Piece fixed(const char* dataset, hsize_t first) const {
    return {dataset, {nodes}, {first}, {1}, {1}, {nodes}};
  }
};

void write_grid(Writer& writer, const Parts& parts, const Topology& topology,
                const std::vector<std::int64_t>& support_sizes, const std::vector<double>& support_points) {
  const auto nodes = static_cast<std::int64_t>(parts.nodes);
  const auto of_supports = static_cast<std::int64_t>(parts.support_points);
  const auto supports = static_cast<std::int64_t>(support_sizes.size());
  writer.values("/VTKHDF/NumberOfPoints", std::vector<std::int64_t>{nodes, nodes, of_supports});
  writer.values("/VTKHDF/NumberOfConnectivityIds", std::vector<std::int64_t>{nodes, nodes, of_supports});
  writer.values("/VTKHDF/NumberOfCells", std::vector<std::int64_t>{1, 1, supports});
  std::vector<std::int64_t> offsets{0, nodes, 0, nodes, 0};
  std::vector<std::uint8_t> types{topology.cells == Topology::Cells::polyline ? kPolyLine : kPolyVertex, kPolyVertex};
  std::vector<std::int64_t> part{0, 1};
  for (const std::int64_t size : support_sizes) {
    offsets.push_back(offsets.back() + size);
    types.push_back(size > 1 ? kPolyLine : kVertex);
    part.push_back(2);
  }
  writer.values("/VTKHDF/Offsets", offsets);
  writer.values("/VTKHDF/Types", types);
  writer.group("/VTKHDF/CellData");
  writer.values("/VTKHDF/CellData/part", part);
  writer.text("/VTKHDF/CellData/part", "units", "1");

  // A part numbers its points from 0.
  writer.group("/VTKHDF/Supports");
  std::vector<std::int64_t> numbers(support_points.size() / 3);
  std::iota(numbers.begin(), numbers.end(), std::int64_t{0});
  writer.values("/VTKHDF/Supports/number", numbers);
  writer.values("/VTKHDF/Supports/points", support_points, {parts.support_points, 3});
  const bool scattered = topology.cells == Topology::Cells::vertices;
  const char* shown = scattered ? "/shown" : "/node";
  std::vector<Piece> connectivity{parts.fixed(shown, 0), parts.fixed(shown, parts.nodes)};
  std::vector<Piece> points;
  for (const hsize_t first : {hsize_t{0}, parts.nodes}) {
    points.push_back({"/x", {parts.nodes}, {first, 0}, {1, 1}, {1, 1}, {parts.nodes, 1}});
    if (scattered) {
      points.push_back({"/z", {parts.nodes}, {first, 2}, {1, 1}, {1, 1}, {parts.nodes, 1}});
    }
  }
  if (parts.support_points > 0) {
    connectivity.push_back(
        {"/VTKHDF/Supports/number", {parts.support_points}, {2 * parts.nodes}, {1}, {1}, {parts.support_points}});
    points.push_back({"/VTKHDF/Supports/points",
                      {parts.support_points, 3},
                      {2 * parts.nodes, 0},
                      {1, 1},
                      {1, 1},
                      {parts.support_points, 3}});
  }
  writer.view("/VTKHDF/Connectivity", {parts.points()}, std::int64_t{0}, connectivity);
  writer.view("/VTKHDF/Points", {parts.points(), 3}, 0.0, points);
  writer.text("/VTKHDF/Points", "units", "m");
}

/// A name of point data, and whether each row has its own.
struct PointData {
  std::string name;
  bool changes;
};

std::vector<PointData> write_point_data(Writer& writer, const Parts& parts, std::span<const FieldInfo> fields,
                                        bool supports_move) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  const hsize_t all = parts.rows * parts.points();
  std::vector<PointData> written;
  const auto add = [&](const std::string& name, std::string_view units, const Extent& extent, auto fill,
                       const std::vector<Piece>& pieces, bool changes) {
    const std::string path = "/VTKHDF/PointData/" + name;
    writer.view(path, extent, fill, pieces);
    writer.text(path, "units", std::string{units});
    written.push_back({name, changes});
  };
  writer.group("/VTKHDF/PointData");
  std::vector<Piece> displacement;
  for (const FieldInfo& field : fields) {
    if (field.position) {
      displacement.push_back(parts.height("/fields/" + std::string{field.name}, parts.first(field.body), parts.nodes));
    }
  }
  if (supports_move) {
    displacement.push_back(parts.height("/VTKHDF/Supports/lift", 2 * parts.nodes, parts.support_points));
  }
  add("displacement", "m", {all, 3}, 0.0, displacement, true);
  for (const FieldInfo& field : fields) {
    if (field.position) {
      continue;
    }
    const Extent extent = field.components == 1 ? Extent{all} : Extent{all, static_cast<hsize_t>(field.components)};
    const std::vector<Piece> pieces{parts.data(field)};
    if (field.flag) {
      add(std::string{field.name}, field.unit, extent, std::uint8_t{0}, pieces, true);
    } else {
      add(std::string{field.name}, field.unit, extent, kNone, pieces, true);
    }
  }
  add("mass", "kg", {parts.points()}, kNone, {parts.fixed("/mass", parts.first(Body::masses))}, false);
  return written;
}

void write_steps(Writer& writer, const Parts& parts, std::span<const double> times,
                 const std::vector<PointData>& point_data) {
  const auto rows = static_cast<std::int64_t>(times.size());
  const std::vector<std::int64_t> zeros(times.size(), 0);
  writer.group("/VTKHDF/Steps");
  writer.attribute("/VTKHDF/Steps", "NSteps", H5T_NATIVE_INT64, {}, &rows);
  writer.values("/VTKHDF/Steps/Values", std::vector<double>{times.begin(), times.end()});
  writer.text("/VTKHDF/Steps/Values", "units", "s");
  writer.values("/VTKHDF/Steps/NumberOfParts", std::vector<std::int64_t>(times.size(), 3));
  for (const char* name : {"PartOffsets", "PointOffsets"}) {
    writer.values(std::string{"/VTKHDF/Steps/"} + name, zeros);
  }
  for (const char* name : {"CellOffsets", "ConnectivityIdOffsets"}) {
    writer.values(std::string{"/VTKHDF/Steps/"} + name, zeros, {times.size(), 1});
  }
  writer.group("/VTKHDF/Steps/CellDataOffsets");
  writer.values("/VTKHDF/Steps/CellDataOffsets/part", zeros);
  std::vector<std::int64_t> firsts(times.size());
  for (std::size_t row = 0; row < firsts.size(); ++row) {
    firsts[row] = static_cast<std::int64_t>(row * parts.points());
  }
  writer.group("/VTKHDF/Steps/PointDataOffsets");
  for (const PointData& data : point_data) {
    writer.values("/VTKHDF/Steps/PointDataOffsets/" + data.name, data.changes ? firsts : zeros);
  }
}

}  // namespace

VtkHdfFile::VtkHdfFile(const RunLayout& layout, std::string path, std::string results)
    : comm_{layout.comm},
      path_{std::move(path)},
      results_{std::move(results)},
      nodes_{layout.nodes.total},
      topology_{layout.topology},
      fields_{layout.fields_in_pictures()} {
  std::array<double, 2> ends{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  if (!layout.x.empty()) {
    const auto [least, largest] = std::ranges::minmax(layout.x);
    ends = {least, -largest};
  }
  MPI_Allreduce(MPI_IN_PLACE, ends.data(), 2, MPI_DOUBLE, MPI_MIN, comm_);
  for (const RunLayout::Support& support : layout.supports) {
    const bool ground = !layout.ground_x.empty() && &support == &layout.supports.back();
    std::vector<double> x{support.position};
    std::vector<double> height;
    if (ground) {
      x = layout.ground_x;
      height = layout.ground_height;
    } else if (support.width > 0.0) {  // a floor's is infinite
      x = {std::max(ends[0], support.position - 0.5 * support.width),
           std::min(-ends[1], support.position + 0.5 * support.width)};
    }
    height.resize(x.size(), support.height);
    for (std::size_t i = 0; i < x.size(); ++i) {
      support_points_.insert(support_points_.end(), {x[i], height[i], 0.0});
    }
    support_sizes_.push_back(static_cast<std::int64_t>(x.size()));
    lifts_.push_back(support.lift);
  }
}

void VtkHdfFile::write(std::span<const double> times) const {
  int rank = 0;
  MPI_Comm_rank(comm_, &rank);
  std::string failure;
  if (rank == 0) {
    const std::string unfinished = path_ + ".tmp";
    const Parts parts{.nodes = static_cast<hsize_t>(nodes_),
                      .support_points = count_of(support_points_.size() / 3),
                      .rows = count_of(times.size())};
    const bool supports_move = std::ranges::any_of(lifts_, [](const auto& lift) { return static_cast<bool>(lift); });
    Writer writer{unfinished, results_};
    writer.group("/VTKHDF");
    constexpr std::array<std::int64_t, 2> kVersion{2, 0};
    writer.attribute("/VTKHDF", "Version", H5T_NATIVE_INT64, {2}, kVersion.data());
    writer.text("/VTKHDF", "Type", "UnstructuredGrid");
    write_grid(writer, parts, topology_, support_sizes_, support_points_);
    if (supports_move) {
      std::vector<double> lift;
      lift.reserve(times.size() * parts.support_points);
      for (const double time : times) {
        for (std::size_t k = 0; k < lifts_.size(); ++k) {
          lift.insert(lift.end(), static_cast<std::size_t>(support_sizes_[k]), lifts_[k] ? lifts_[k](time) : 0.0);
        }
      }
      writer.values("/VTKHDF/Supports/lift", lift, {parts.rows, parts.support_points});
      writer.text("/VTKHDF/Supports/lift", "units", "m");
    }
    write_steps(writer, parts, times, write_point_data(writer, parts, fields_, supports_move));
    if (!writer.close()) {
      failure = cannot_write(unfinished, "HDF5 cannot write it");
      unlink(unfinished.c_str());
    } else if (std::rename(unfinished.c_str(), path_.c_str()) != 0) {
      failure = cannot_write(path_, std::generic_category().message(errno));
    }
  }
  throw_together<FileError>(comm_, failure);
}

}  // namespace udar::io
