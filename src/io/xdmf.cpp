#include "udar/io/xdmf.hpp"

#include <algorithm>
#include <utility>

#include "io/text_file.hpp"

namespace udar::io {
namespace {

constexpr const char* kFooter =
    "    </Grid>\n"
    "  </Domain>\n"
    "</Xdmf>\n";

}  // namespace

XdmfFile::XdmfFile(const RunLayout& layout, const std::string& path, std::string results, std::string points)
    : file_{std::make_unique<TextFile>(layout.comm, path)},
      results_{std::move(results)},
      zeros_{std::move(points)},
      nodes_{layout.nodes.total},
      topology_{layout.topology},
      fields_{layout.fields_in_pictures()} {
  file_->append(
      "<?xml version=\"1.0\"?>\n"
      "<Xdmf Version=\"2.0\">\n"
      "  <Domain>\n"
      "    <Grid Name=\"" +
          std::string{topology_.name} + "\" GridType=\"Collection\" CollectionType=\"Temporal\">\n",
      kFooter);
}

XdmfFile::~XdmfFile() = default;

void XdmfFile::append(double time) {
  const std::string nodes = std::to_string(nodes_);
  const std::string row = std::to_string(rows_);
  const std::string rows = std::to_string(rows_ + 1);
  // A value per node that does not change.
  const auto fixed = [&](const char* name, const char* type, const std::string& comment) {
    return std::string{"<DataItem Dimensions=\""} + nodes + "\" NumberType=\"" + type +
           "\" Precision=\"8\" Format=\"HDF\">" + comment + results_ + ":" + name + "</DataItem>\n";
  };
  // What stands at the nodes out of a larger array.
  const auto part = [&](const std::string& extent, const std::string& choice, const std::string& shape,
                        const std::string& type, const std::string& source) {
    const std::string indent = "          ";
    return indent + "<DataItem ItemType=\"HyperSlab\" Dimensions=\"" + extent + "\" Type=\"HyperSlab\">\n" + indent +
           "  <DataItem Dimensions=\"3 " + (extent == nodes ? "2" : "3") + "\" Format=\"XML\">" + choice +
           "</DataItem>\n" + indent + "  <DataItem Dimensions=\"" + shape + "\" NumberType=" + type +
           " Format=\"HDF\">" + source + "</DataItem>\n" + indent + "</DataItem>\n";
  };
  // Row `rows_` of a field. Of the field's rows only those up to this one are named, so that this stays true while the
  // file grows.
  const auto slab = [&](const FieldInfo& field) {
    const std::string type = field.flag ? "\"UChar\" Precision=\"1\"" : "\"Float\" Precision=\"8\"";
    const std::string source = results_ + ":/fields/" + std::string{field.name};
    if (field.components == 1) {
      return part(nodes, row + " 0 1 1 1 " + nodes, rows + " " + nodes, type, source);
    }
    const std::string extent = nodes + " " + std::to_string(field.components);
    return part(extent, row + " 0 0 1 1 1 1 " + extent, rows + " " + extent, type, source);
  };
  const auto attribute = [&](const FieldInfo& field) {
    const char* type = field.components == 1 ? "Scalar" : (field.components == 3 ? "Vector" : "Matrix");
    return "        <Attribute Name=\"" + std::string{field.name} + "\" AttributeType=\"" + type +
           "\" Center=\"Node\">\n" + slab(field) + "        </Attribute>\n";
  };

  // VTK takes the points of the row before again if the first thing in the first item of the geometry reads the same.
  const std::string unique = "<!-- row " + row + " -->";
  std::string grid = "      <Grid Name=\"row " + row + "\" GridType=\"Uniform\">\n        <Time Value=\"";
  append_number(grid, time);
  const bool polyline = topology_.cells == Topology::Cells::polyline;
  grid += std::string{"\"/>\n        <Topology TopologyType=\""} + (polyline ? "Polyline" : "Polyvertex") +
          "\" NodesPerElement=\"" + (polyline ? nodes : "1") + "\" NumberOfElements=\"" + (polyline ? "1" : nodes) +
          "\">\n          " + fixed(polyline ? "/node" : "/shown", "Int", "") +
          "        </Topology>\n"
          "        <Geometry GeometryType=\"X_Y_Z\">\n          " +
          fixed("/x", "Float", unique);
  const auto shape = std::ranges::find_if(fields_, &FieldInfo::position);  // of the line, as a rule
  if (shape != fields_.end()) {
    grid += slab(*shape);
  }
  // VTK's Xdmf3 readers crash on points of two coordinates.
  grid += part(nodes, "0 2 1 1 " + nodes + " 1", nodes + " 3", "\"Float\" Precision=\"8\"", zeros_);
  grid += "        </Geometry>\n";
  for (auto field = fields_.begin(); field != fields_.end(); ++field) {
    if (field != shape) {
      grid += attribute(*field);
    }
  }
  grid += "      </Grid>\n";
  file_->append(grid, kFooter);
  ++rows_;
}

}  // namespace udar::io
