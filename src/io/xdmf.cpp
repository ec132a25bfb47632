#include "udar/io/xdmf.hpp"

#include <utility>

#include "io/text_file.hpp"

namespace udar::io {
namespace {

constexpr const char* kFooter =
    "    </Grid>\n"
    "  </Domain>\n"
    "</Xdmf>\n";

}  // namespace

XdmfFile::XdmfFile(MPI_Comm comm, const std::string& path, std::string results, std::string points, PetscInt nodes)
    : file_{std::make_unique<TextFile>(comm, path)},
      results_{std::move(results)},
      zeros_{std::move(points)},
      nodes_{nodes} {
  file_->append(
      "<?xml version=\"1.0\"?>\n"
      "<Xdmf Version=\"2.0\">\n"
      "  <Domain>\n"
      "    <Grid Name=\"beam\" GridType=\"Collection\" CollectionType=\"Temporal\">\n",
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
  // One value per node out of an array of two dimensions.
  const auto part = [&](const std::string& indent, const std::string& choice, const std::string& shape,
                        const std::string& type, const std::string& source) {
    return indent + "<DataItem ItemType=\"HyperSlab\" Dimensions=\"" + nodes + "\" Type=\"HyperSlab\">\n" + indent +
           "  <DataItem Dimensions=\"3 2\" Format=\"XML\">" + choice + "</DataItem>\n" + indent +
           "  <DataItem Dimensions=\"" + shape + "\" NumberType=" + type + " Format=\"HDF\">" + source +
           "</DataItem>\n" + indent + "</DataItem>\n";
  };
  // Row `rows_` of a field. Of the field's rows only those up to this one are named, so that this stays true while the
  // file grows.
  const auto slab = [&](const std::string& indent, const char* name, const char* type, const char* precision) {
    std::string number = std::string{"\""} + type + "\" Precision=\"" + precision + "\"";
    return part(indent, row + " 0 1 1 1 " + nodes, rows + " " + nodes, number, results_ + ":/fields/" + name);
  };
  const auto attribute = [&](const char* name, const char* type, const char* precision) {
    return std::string{"        <Attribute Name=\""} + name + "\" AttributeType=\"Scalar\" Center=\"Node\">\n" +
           slab("          ", name, type, precision) + "        </Attribute>\n";
  };

  // VTK takes the points of the row before again if the first thing in the first item of the geometry reads the same.
  const std::string unique = "<!-- row " + row + " -->";
  std::string grid = "      <Grid Name=\"row " + row + "\" GridType=\"Uniform\">\n        <Time Value=\"";
  append_number(grid, time);
  grid += "\"/>\n        <Topology TopologyType=\"Polyline\" NodesPerElement=\"" + nodes +
          "\" NumberOfElements=\"1\">\n          " + fixed("/node", "Int", "") +
          "        </Topology>\n"
          "        <Geometry GeometryType=\"X_Y_Z\">\n          " +
          fixed("/x", "Float", unique) + slab("          ", "line_position", "Float", "8");
  // VTK's Xdmf3 readers crash on points of two coordinates.
  grid += part("          ", "0 2 1 1 " + nodes + " 1", nodes + " 3", "\"Float\" Precision=\"8\"", zeros_);
  grid += "        </Geometry>\n";
  grid += attribute("moment", "Float", "8");
  grid += attribute("mass_position", "Float", "8");
  grid += attribute("mass_velocity", "Float", "8");
  grid += attribute("resting", "UChar", "1");
  grid += "      </Grid>\n";
  file_->append(grid, kFooter);
  ++rows_;
}

}  // namespace udar::io
