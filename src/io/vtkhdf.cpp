#include "udar/io/vtkhdf.hpp"

#include <hdf5.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <numeric>
#include <system_error>
#include <utility>

#include "io/field_lines.hpp"
#include "io/support_outline.hpp"
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

std::uint8_t cell_type(Topology::Shape shape) {
  constexpr std::array<std::uint8_t, 6> kTypes{kVertex, 3, 5, 9, 10, 12};  // in the order of `Shape`
  return kTypes.at(static_cast<std::size_t>(shape));
}

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

  /// As many values as `count`, each made of its number; no more than some of them are in memory.
  template <class Value, class Make>
  void sequence(const std::string& name, hsize_t count, const Make& make) {
    constexpr hsize_t kMost = 1 << 17;
    const hid_t type = type_of(Value{});
    const Hdf5Id space = space_of({count});
    const Hdf5Id data{H5Dcreate2(file_, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Dclose};
    bool ok = data.valid();
    std::vector<Value> block;
    for (hsize_t begin = 0; ok && begin < count; begin += kMost) {
      const hsize_t size = std::min(kMost, count - begin);
      block.clear();
      for (hsize_t i = begin; i < begin + size; ++i) {
        block.push_back(make(i));
      }
      ok = H5Sselect_hyperslab(space, H5S_SELECT_SET, &begin, nullptr, &size, nullptr) >= 0 &&
           H5Dwrite(data, type, space_of({size}), space, H5P_DEFAULT, block.data()) >= 0;
    }
    keep(ok);
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

/// The three parts of the grid: the line in its cells, the masses in one, each support in one; their points and cells
/// one after the other.
struct Parts {
  hsize_t nodes;
  hsize_t line_cells;
  hsize_t corners;  ///< of one of these
  hsize_t supports;
  hsize_t support_points;
  hsize_t rows;

  [[nodiscard]] hsize_t points() const { return 2 * nodes + support_points; }
  [[nodiscard]] hsize_t cells() const { return line_cells + 1 + supports; }
  [[nodiscard]] hsize_t corner_numbers() const { return line_cells * corners + nodes + support_points; }
  /// Where the points of a body begin.
  [[nodiscard]] hsize_t first(Body body) const { return body == Body::line ? 0 : nodes; }
  /// Rows of a field at the nodes of its body, or in the cells of the line.
  [[nodiscard]] Piece data(const FileField& field) const {
    const bool of_points = field.where == Where::points;
    return vectors(field.path(), of_points ? first(field.body) : 0, of_points ? nodes : line_cells,
                   static_cast<hsize_t>(field.components), of_points ? points() : cells());
  }
  /// Rows of `count` values among `all`.
  [[nodiscard]] Piece vectors(const std::string& path, hsize_t first, hsize_t count, hsize_t components,
                              hsize_t all) const {
    if (components == 1) {
      return {path, {rows, count}, {first}, {all}, {rows}, {count}};
    }
    return {path, {rows, count, components}, {first, 0}, {all, 1}, {rows, 1}, {count, components}};
  }
  /// Rows of values as the heights of vectors.
  [[nodiscard]] Piece height(const std::string& dataset, hsize_t first, hsize_t count) const {
    return {dataset, {rows, count}, {first, 1}, {points(), 1}, {rows, 1}, {count, 1}};
  }
  /// Values that do not change, one per node.
  [[nodiscard]] Piece fixed(const char* dataset, hsize_t first) const {
    return {dataset, {nodes}, {first}, {1}, {1}, {nodes}};
  }
  /// The same, one per cell of the line.
  [[nodiscard]] Piece fixed_in_cells(const char* dataset) const {
    return {dataset, {line_cells}, {0}, {1}, {1}, {line_cells}};
  }
};

/// Corners, offsets, types and parts of the cells.
void write_cells(Writer& writer, const Parts& parts, Topology::Shape shape,
                 const std::vector<std::int64_t>& support_sizes) {
  const hsize_t line_cells = parts.line_cells;
  std::vector<std::int64_t> tail{0, static_cast<std::int64_t>(parts.nodes), 0};  // offsets of the other two parts
  for (const std::int64_t size : support_sizes) {
    tail.push_back(tail.back() + size);
  }
  writer.sequence<std::int64_t>("/VTKHDF/Offsets", line_cells + 1 + tail.size(), [&](hsize_t i) {
    return i <= line_cells ? static_cast<std::int64_t>(i * parts.corners) : tail[i - line_cells - 1];
  });
  writer.sequence<std::uint8_t>("/VTKHDF/Types", parts.cells(), [&](hsize_t i) {
    return i < line_cells                          ? cell_type(shape)
           : i == line_cells                       ? kPolyVertex
           : support_sizes[i - line_cells - 1] > 1 ? kPolyLine
                                                   : kVertex;
  });
  writer.group("/VTKHDF/CellData");
  writer.sequence<std::int64_t>("/VTKHDF/CellData/part", parts.cells(), [&](hsize_t i) {
    return i < line_cells ? 0 : i == line_cells ? 1 : 2;
  });
  writer.text("/VTKHDF/CellData/part", "units", "1");

  // A part numbers its points from 0.
  const auto numbers = [&](const std::string& path, hsize_t count) {
    writer.sequence<std::int64_t>(path, count, [](hsize_t i) { return static_cast<std::int64_t>(i); });
  };
  numbers("/VTKHDF/Masses/number", parts.nodes);
  numbers("/VTKHDF/Supports/number", parts.support_points);
  const hsize_t of_line = line_cells * parts.corners;
  const Extent corners = parts.corners > 1 ? Extent{line_cells, parts.corners} : Extent{line_cells};
  std::vector<Piece> connectivity{{"/cells", corners, {0}, {1}, {1}, {of_line}},
                                  {"/VTKHDF/Masses/number", {parts.nodes}, {of_line}, {1}, {1}, {parts.nodes}}};
  if (parts.support_points > 0) {
    connectivity.push_back(
        {"/VTKHDF/Supports/number", {parts.support_points}, {of_line + parts.nodes}, {1}, {1}, {parts.support_points}});
  }
  writer.view("/VTKHDF/Connectivity", {parts.corner_numbers()}, std::int64_t{0}, connectivity);
}

void write_points(Writer& writer, const Parts& parts, std::span<const std::string> axes,
                  const std::vector<double>& support_points) {
  writer.values("/VTKHDF/Supports/points", support_points, {parts.support_points, 3});
  std::vector<Piece> points;
  for (hsize_t axis = 0; axis < axes.size(); ++axis) {
    for (const hsize_t first : {hsize_t{0}, parts.nodes}) {
      if (!axes[axis].empty()) {
        points.push_back({axes[axis], {parts.nodes}, {first, axis}, {1, 1}, {1, 1}, {parts.nodes, 1}});
      }
    }
  }
  if (parts.support_points > 0) {
    points.push_back({"/VTKHDF/Supports/points",
                      {parts.support_points, 3},
                      {2 * parts.nodes, 0},
                      {1, 1},
                      {1, 1},
                      {parts.support_points, 3}});
  }
  writer.view("/VTKHDF/Points", {parts.points(), 3}, 0.0, points);
  writer.text("/VTKHDF/Points", "units", "m");
}

void write_counts(Writer& writer, const Parts& parts) {
  const auto three = [&](const std::string& name, hsize_t line, hsize_t masses, hsize_t supports) {
    writer.values("/VTKHDF/NumberOf" + name,
                  std::vector<std::int64_t>{static_cast<std::int64_t>(line), static_cast<std::int64_t>(masses),
                                            static_cast<std::int64_t>(supports)});
  };
  three("Points", parts.nodes, parts.nodes, parts.support_points);
  three("ConnectivityIds", parts.line_cells * parts.corners, parts.nodes, parts.support_points);
  three("Cells", parts.line_cells, 1, parts.supports);
}

/// The data of the points, or of the cells: "Point" or "Cell".
class DataGroup {
 public:
  DataGroup(Writer& writer, const Parts& parts, std::string kind)
      : writer_{&writer}, parts_{&parts}, kind_{std::move(kind)} {}

  template <class Value>
  void add(const std::string& name, std::string_view units, const Extent& extent, Value fill,
           const std::vector<Piece>& pieces, bool changes = true) {
    const std::string path = "/VTKHDF/" + kind_ + "Data/" + name;
    writer_->view(path, extent, fill, pieces);
    writer_->text(path, "units", std::string{units});
    written_.emplace_back(name, changes);
  }

  /// All fields of this kind that are no places.
  void add(std::span<const FileField> fields) {
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    const bool of_points = kind_ == "Point";
    const hsize_t all = parts_->rows * (of_points ? parts_->points() : parts_->cells());
    for (const FileField& field : fields) {
      if (field.position || field.form == FileField::Form::displacement ||
          (field.where == Where::points) != of_points) {
        continue;
      }
      const Extent extent = field.components == 1 ? Extent{all} : Extent{all, static_cast<hsize_t>(field.components)};
      const std::vector<Piece> pieces{parts_->data(field)};
      if (field.flag) {
        add(std::string{field.name}, field.unit, extent, std::uint8_t{0}, pieces);
      } else {
        add(std::string{field.name}, field.unit, extent, kNone, pieces);
      }
    }
  }

  /// Something that is there and stays.
  void note(const std::string& name) { written_.emplace_back(name, false); }

  /// Where the rows of each begin.
  void write_offsets(std::size_t rows) const {
    const hsize_t size = kind_ == "Point" ? parts_->points() : parts_->cells();
    writer_->group("/VTKHDF/Steps/" + kind_ + "DataOffsets");
    for (const auto& [name, changes] : written_) {
      const hsize_t step = changes ? size : 0;
      writer_->sequence<std::int64_t>("/VTKHDF/Steps/" + kind_ + "DataOffsets/" + name, rows,
                                      [step](hsize_t row) { return static_cast<std::int64_t>(row * step); });
    }
  }

 private:
  Writer* writer_;
  const Parts* parts_;
  std::string kind_;
  std::vector<std::pair<std::string, bool>> written_;  ///< names, and whether each row has its own
};

void write_point_data(Writer& writer, const Parts& parts, std::span<const FileField> fields, bool upright,
                      bool supports_move, DataGroup& data) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  writer.group("/VTKHDF/PointData");
  std::vector<Piece> displacement;
  for (const FileField& field : fields) {
    if (field.form == FileField::Form::displacement) {
      displacement.push_back(parts.data(field));
    } else if (field.position && upright) {
      displacement.push_back(parts.height(field.path(), parts.first(field.body), parts.nodes));
    }
  }
  if (supports_move) {
    displacement.push_back(parts.height("/VTKHDF/Supports/lift", 2 * parts.nodes, parts.support_points));
  }
  data.add("displacement", "m", {parts.rows * parts.points(), 3}, 0.0, displacement);
  data.add(fields);
  data.add("mass", "kg", {parts.points()}, kNone, {parts.fixed("/mass", parts.first(Body::masses))}, false);
}

void write_steps(Writer& writer, std::span<const double> times) {
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
}

}  // namespace

VtkHdfFile::VtkHdfFile(const RunLayout& layout, std::string path, std::string results)
    : comm_{layout.comm()},
      path_{std::move(path)},
      results_{std::move(results)},
      nodes_{layout.nodes().total},
      cells_{layout.cells().total},
      shape_{layout.topology.shape},
      upright_{layout.rows->upright()},
      tubes_{layout.tubes},
      members_{layout.members},
      fields_{layout.fields_in_pictures()} {
  // Heights of points that move along y are absolute.
  constexpr double kNone = -std::numeric_limits<double>::infinity();
  std::array<double, 6> most{0.0, 0.0, kNone, kNone, kNone, kNone};  // sizes of y and z, -y, y, -z, z
  for (std::size_t point = 0; point < layout.points->points(); ++point) {
    const Place at = layout.points->place(point);
    most = {std::max(most[0], upright_ ? 0.0 : std::abs(at.y)),
            std::max(most[1], std::abs(at.z)),
            std::max(most[2], -at.y),
            std::max(most[3], at.y),
            std::max(most[4], -at.z),
            std::max(most[5], at.z)};
  }
  MPI_Allreduce(MPI_IN_PLACE, most.data(), 6, MPI_DOUBLE, MPI_MAX, comm_);
  axes_ = {"/x", most[0] > 0.0 ? "/y" : "", most[1] > 0.0 ? "/z" : ""};
  const udar::Extent along = layout.points->extent();
  place_supports(layout, {.from = {.x = along.from, .y = -most[2], .z = -most[4]},
                          .to = {.x = along.to, .y = most[3], .z = most[5]}});
}

/// Supports hold what is above or below them whatever its z: a point is then a line, a line a closed one.
void VtkHdfFile::place_supports(const RunLayout& layout, const Region& around) {
  const udar::Extent ends{.from = around.from.x, .to = around.to.x};
  for (const RunLayout::Support& support : layout.supports) {
    const std::vector<double>& space = support.space;
    if (support.field) {
      for (const std::vector<Place>& line : field_lines(*support.field, support.base, around)) {
        for (const Place& point : line) {
          support_points_.insert(support_points_.end(), {point.x, point.y, point.z});
        }
        support_sizes_.push_back(static_cast<std::int64_t>(line.size()));
        lifts_.emplace_back();
      }
      continue;
    }
    if (!space.empty() && space[1] != 1.0) {
      const std::array<Place, kCorners> corners = outline_of(support, around);
      for (std::size_t i = 0; i <= kCorners; ++i) {  // the first again
        const Place& corner = corners[i % kCorners];
        support_points_.insert(support_points_.end(), {corner.x, corner.y, corner.z});
      }
      support_sizes_.push_back(kCorners + 1);
      lifts_.emplace_back();  // which would be along the normal
      continue;
    }
    const udar::Extent across{.from = space.empty() ? around.from.z : std::max(around.from.z, space[5]),
                              .to = space.empty() ? around.to.z : std::min(around.to.z, space[6])};
    const bool ground = !layout.ground_x.empty() && &support == &layout.supports.back();
    std::vector<double> x{support.position};
    std::vector<double> height;
    if (ground) {
      x = layout.ground_x;
      height = layout.ground_height;
    } else if (support.width > 0.0) {  // a floor's is infinite
      x = {std::max(ends.from, support.position - 0.5 * support.width),
           std::min(ends.to, support.position + 0.5 * support.width)};
    }
    height.resize(x.size(), support.height);
    const std::size_t before = support_points_.size();
    const auto add = [&](std::size_t i, double z) {
      support_points_.insert(support_points_.end(), {x[i], height[i], z});
    };
    for (std::size_t i = 0; i < x.size(); ++i) {
      add(i, across.from);
    }
    for (std::size_t i = x.size(); across.length() > 0.0 && i-- > 0;) {
      add(i, across.to);
    }
    if (across.length() > 0.0 && x.size() > 1) {
      add(0, across.from);
    }
    support_sizes_.push_back(static_cast<std::int64_t>((support_points_.size() - before) / 3));
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
                      .line_cells = static_cast<hsize_t>(cells_),
                      .corners = static_cast<hsize_t>(Topology::corners_of(shape_)),
                      .supports = count_of(support_sizes_.size()),
                      .support_points = count_of(support_points_.size() / 3),
                      .rows = count_of(times.size())};
    const bool supports_move = std::ranges::any_of(lifts_, [](const auto& lift) { return static_cast<bool>(lift); });
    Writer writer{unfinished, results_};
    writer.group("/VTKHDF");
    constexpr std::array<std::int64_t, 2> kVersion{2, 0};
    writer.attribute("/VTKHDF", "Version", H5T_NATIVE_INT64, {2}, kVersion.data());
    writer.text("/VTKHDF", "Type", "UnstructuredGrid");
    writer.group("/VTKHDF/Masses");
    writer.group("/VTKHDF/Supports");
    write_counts(writer, parts);
    write_cells(writer, parts, shape_, support_sizes_);
    write_points(writer, parts, axes_, support_points_);
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
    DataGroup at_points{writer, parts, "Point"};
    DataGroup in_cells{writer, parts, "Cell"};
    write_point_data(writer, parts, fields_, upright_, supports_move, at_points);
    in_cells.note("part");
    in_cells.add(fields_);
    if (tubes_) {  // the Tube filter takes no number that is none
      at_points.add("radius", "m", {parts.points()}, 0.0, {parts.fixed("/radius", parts.first(Body::line))}, false);
      in_cells.add("radius", "m", {parts.cells()}, 0.0, {parts.fixed_in_cells("/member_radius")}, false);
    }
    if (members_) {
      in_cells.add("member", "1", {parts.cells()}, std::int64_t{-1}, {parts.fixed_in_cells("/member")}, false);
    }
    write_steps(writer, times);
    at_points.write_offsets(times.size());
    in_cells.write_offsets(times.size());
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
