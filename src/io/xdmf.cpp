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

XdmfFile::XdmfFile(MPI_Comm comm, const std::string& path, std::string results, PetscInt nodes)
    : file_{std::make_unique<TextFile>(comm, path)}, results_{std::move(results)}, nodes_{nodes} {
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
  // Row `rows_` of a field. Of the field's rows only those up to this one are named, so that this stays true while the
  // file grows.
  const auto slab = [&](const std::string& indent, const char* name, const char* type, const char* precision) {
    return indent + "<DataItem ItemType=\"HyperSlab\" Dimensions=\"" + nodes + "\" Type=\"HyperSlab\">\n" + indent +
           "  <DataItem Dimensions=\"3 2\" Format=\"XML\">" + row + " 0 1 1 1 " + nodes + "</DataItem>\n" + indent +
           "  <DataItem Dimensions=\"" + rows + " " + nodes + "\" NumberType=\"" + type + "\" Precision=\"" +
           precision + "\" Format=\"HDF\">" + results_ + ":/fields/" + name + "</DataItem>\n" + indent +
           "</DataItem>\n";
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
          "        <Geometry GeometryType=\"X_Y\">\n          " +
          fixed("/x", "Float", unique) + slab("          ", "line_position", "Float", "8") + "        </Geometry>\n";
  grid += attribute("moment", "Float", "8");
  grid += attribute("mass_position", "Float", "8");
  grid += attribute("mass_velocity", "Float", "8");
  grid += attribute("resting", "UChar", "1");
  grid += "      </Grid>\n";
  file_->append(grid, kFooter);
  ++rows_;
}

}  // namespace udar::io
