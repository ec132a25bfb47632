// A Gmsh mesh with groups of known names, as far as the structure that is made of it. In ASCII of versions 2.2 and 4.1:
// others are read by PETSc alone, which does not survive all.

#include <sstream>

#include "fuzz/harness.hpp"
#include "udar/io/network_file.hpp"

namespace {

constexpr const char* kGroups = R"(sections:
  - {name: tube, shape: tube, radius: 0.1, inner_radius: 0.09}
groups:
  - {name: feet, held: pinned}
  - {name: middle, mass: 50}
  - {name: posts, section: tube, orientation: [0, 0, 1]}
  - {name: beams, section: tube}
)";

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace udar;
  std::istringstream text{std::string{reinterpret_cast<const char*>(data), size}};
  std::string head;
  std::string version;
  std::string binary;
  text >> head >> version >> binary;
  if (head == "$MeshFormat" && (binary != "0" || (version != "2.2" && version != "4.1"))) {
    return 0;
  }
  fuzz::write_file("groups.yaml", kGroups);
  fuzz::write_file("mesh.msh", {reinterpret_cast<const char*>(data), size});
  fuzz::allow_refusal(
      [&] { const Network network{PETSC_COMM_WORLD, io::read_network(PETSC_COMM_WORLD, "mesh.msh", "groups.yaml")}; });
  return 0;
}
