#include "udar/io/xdmf.hpp"

#include <algorithm>
#include <utility>

#include "io/text_file.hpp"
#include "udar/motion/motion_state.hpp"

namespace udar::io {
namespace {

constexpr const char* kRowsOfXdmf = "rows of results.xdmf";

TextFrame frame(const Topology& topology) {
  return {.header =
              "<?xml version=\"1.0\"?>\n"
              "<Xdmf Version=\"2.0\">\n"
              "  <Domain>\n"
              "    <Grid Name=\"" +
              std::string{topology.name} + "\" GridType=\"Collection\" CollectionType=\"Temporal\">\n",
          .footer =
              "    </Grid>\n"
              "  </Domain>\n"
              "</Xdmf>\n"};
}

/// What XDMF calls a cell; for those whose size it does not tell it is asked for.
std::string topology_type(Topology::Shape shape) {
  switch (shape) {
    case Topology::Shape::vertex:
      return "Polyvertex\" NodesPerElement=\"1";
    case Topology::Shape::line:
      return "Polyline\" NodesPerElement=\"2";
    case Topology::Shape::triangle:
      return "Triangle";
    case Topology::Shape::quadrilateral:
      return "Quadrilateral";
    case Topology::Shape::tetrahedron:
      return "Tetrahedron";
    case Topology::Shape::hexahedron:
      break;
  }
  return "Hexahedron";
}

std::string open(const std::string& extent, const std::string& type) {
  return "<DataItem Dimensions=\"" + extent + "\" NumberType=" + type + " Format=\"HDF\">";
}

/// A whole dataset.
std::string whole(const std::string& extent, const std::string& type, const std::string& source) {
  return "          " + open(extent, type) + source + "</DataItem>\n";
}

/// The numbers `choice` - start, stride and count - of a dataset of two or three dimensions.
std::string part(const std::string& extent, const std::string& choice, const std::string& shape,
                 const std::string& type, const std::string& source) {
  const bool flat = extent.find(' ') == std::string::npos;
  const std::string indent = "          ";
  return indent + "<DataItem ItemType=\"HyperSlab\" Dimensions=\"" + extent + "\" Type=\"HyperSlab\">\n" + indent +
         "  <DataItem Dimensions=\"3 " + (flat ? "2" : "3") + "\" Format=\"XML\">" + choice + "</DataItem>\n" + indent +
         "  " + open(shape, type) + source + "</DataItem>\n" + indent + "</DataItem>\n";
}

constexpr const char* kFloat = "\"Float\" Precision=\"8\"";
constexpr const char* kInteger = "\"Int\" Precision=\"8\"";

std::string open_attribute(const std::string& name, const std::string& type, Where where) {
  return "        <Attribute Name=\"" + name + "\" AttributeType=\"" + type + "\" Center=\"" +
         (where == Where::points ? "Node" : "Cell") + "\">\n";
}
constexpr const char* kCloseAttribute = "        </Attribute>\n";

}  // namespace

XdmfFile::XdmfFile(const RunLayout& layout, const std::string& path, std::string results, std::string points)
    : file_{std::make_unique<TextFile>(layout.comm(), path, frame(layout.topology), layout.earlier)},
      results_{std::move(results)},
      points_{std::move(points)},
      nodes_{layout.nodes().total},
      cells_{layout.cells().total},
      shape_{layout.topology.shape},
      tubes_{layout.tubes},
      members_{layout.members},
      fields_{layout.fields_in_pictures()} {
  if (layout.earlier != nullptr) {
    const auto rows = layout.earlier->scalars.find(kRowsOfXdmf);
    rows_ = rows != layout.earlier->scalars.end() ? static_cast<PetscInt>(rows->second) : 0;
  }
}

XdmfFile::~XdmfFile() = default;

/// The next row of a field. Of its rows only those up to this one are named, so that this stays true while the file
/// grows.
std::string XdmfFile::row_of(const FileField& field) const {
  const std::string count = std::to_string(field.where == Where::points ? nodes_ : cells_);
  const std::string row = std::to_string(rows_);
  const std::string rows = std::to_string(rows_ + 1);
  const std::string type = field.flag ? "\"UChar\" Precision=\"1\"" : kFloat;
  if (field.components == 1) {
    return part(count, row + " 0 1 1 1 " + count, rows + " " + count, type, results_ + ":" + field.path());
  }
  const std::string extent = count + " " + std::to_string(field.components);
  return part(extent, row + " 0 0 1 1 1 1 " + extent, rows + " " + extent, type, results_ + ":" + field.path());
}

std::string XdmfFile::attribute(const std::string& name, const FileField& field) const {
  const char* type = field.components == 1 ? "Scalar" : (field.components == 3 ? "Vector" : "Matrix");
  return open_attribute(name, type, field.where) + row_of(field) + kCloseAttribute;
}

/// What cells are like at all times.
std::string XdmfFile::constants() const {
  const std::string nodes = std::to_string(nodes_);
  const std::string cells = std::to_string(cells_);
  const auto item = [this](const char* name, Where where, const std::string& count, const char* type,
                           const char* dataset) {
    return open_attribute(name, "Scalar", where) + whole(count, type, results_ + ":" + dataset) + kCloseAttribute;
  };
  std::string text;
  if (tubes_) {
    text += item("radius", Where::points, nodes, kFloat, "/radius");
    text += item("radius", Where::cells, cells, kFloat, "/member_radius");
  }
  if (members_) {
    text += item("member", Where::cells, cells, kInteger, "/member");
  }
  return text;
}

/// The points of the line: x, then its height, or y, then z.
std::string XdmfFile::geometry(const FileField* height) const {
  const std::string nodes = std::to_string(nodes_);
  const auto column = [&](int axis) {
    return part(nodes, "0 " + std::to_string(axis) + " 1 1 " + nodes + " 1", nodes + " 3", kFloat, points_);
  };
  // VTK takes the points of the row before again if the first thing in the first item of the geometry reads the same.
  const std::string unique = "<!-- row " + std::to_string(rows_) + " -->";
  // VTK's Xdmf3 readers crash on points of two coordinates.
  return "        <Geometry GeometryType=\"X_Y_Z\">\n" + whole(nodes, kFloat, unique + results_ + ":/x") +
         (height != nullptr ? row_of(*height) : column(1)) + column(2) + "        </Geometry>\n";
}

void XdmfFile::append(double time) {
  std::string grid =
      "      <Grid Name=\"row " + std::to_string(rows_) + "\" GridType=\"Uniform\">\n        <Time Value=\"";
  append_number(grid, time);
  const std::string cells = std::to_string(cells_);
  const PetscInt corners = Topology::corners_of(shape_);
  grid += "\"/>\n        <Topology TopologyType=\"" + topology_type(shape_) + "\" NumberOfElements=\"" + cells +
          "\">\n" + whole(corners > 1 ? cells + " " + std::to_string(corners) : cells, kInteger, results_ + ":/cells") +
          "        </Topology>\n";
  const auto moves = [](const FileField& field) { return field.form == FileField::Form::displacement; };
  auto shape = std::ranges::find_if(fields_, moves);  // of the line, as a rule
  const bool displaced = shape != fields_.end();
  if (!displaced) {
    shape = std::ranges::find_if(fields_, &FileField::position);
  }
  grid += geometry(displaced || shape == fields_.end() ? nullptr : &*shape);
  for (auto field = fields_.begin(); field != fields_.end(); ++field) {
    if (field != shape) {
      grid += attribute(std::string{field->name}, *field);
    } else if (displaced) {
      grid += attribute("displacement", *field);
    }
  }
  grid += constants();
  grid += "      </Grid>\n";
  file_->append(grid);
  ++rows_;
}

void XdmfFile::sync() { file_->sync(); }

void XdmfFile::save(MotionState& state) const {
  file_->save(state);
  state.scalars[kRowsOfXdmf] = static_cast<double>(rows_);
}

}  // namespace udar::io
