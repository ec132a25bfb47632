#include <petscdmplex.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <map>
#include <numbers>
#include <numeric>
#include <sstream>

#include "io/gmsh_nodes.hpp"
#include "io/input_file.hpp"
#include "io/line_mesh.hpp"
#include "udar/petsc/array.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/handle.hpp"
#include "udar/petsc/scoped_options.hpp"

namespace udar::io {
namespace {

using Plex = petsc::Handle<DM, DMDestroy>;
using Names = std::map<PetscInt, std::string>;  // of physical groups, by their numbers

/// Points [first, last) of a plex.
struct Span {
  PetscInt first = 0;
  PetscInt last = 0;

  [[nodiscard]] bool contains(PetscInt point) const noexcept { return point >= first && point < last; }
  [[nodiscard]] std::size_t size() const noexcept { return static_cast<std::size_t>(last - first); }
};

std::string text_of(const Place& place) {
  std::ostringstream text;
  text << "(" << place.x << ", " << place.y << ", " << place.z << ") m";
  return text.str();
}

/// What a file says of its version; 0: nothing.
double version_of(const std::string& path) {
  std::ifstream file{path};
  std::string head;
  double version = 0.0;
  file >> head >> version;
  return head == "$MeshFormat" ? version : 0.0;
}

/// @param named whether labels are named after groups, and hold all their elements; version 2.2 counts the number of
/// the entity as a group, too. Else there are labels of numbers with the first group of each element alone.
Plex read_plex(const std::string& path, bool named) {
  const petsc::ScopedOptions options{{{"-dm_plex_gmsh_spacedim", "3"},
                                      {"-dm_plex_gmsh_use_regions", named ? "true" : "false"},
                                      {"-dm_plex_gmsh_multiple_tags", "false"},
                                      {"-dm_plex_gmsh_mark_vertices", "false"},
                                      {"-dm_plex_gmsh_periodic", "false"},
                                      {"-dm_plex_gmsh_project", "false"}}};
  Plex plex;
  UDAR_CALL(DMPlexCreateGmshFromFile(PETSC_COMM_SELF, path.c_str(), PETSC_TRUE, plex.put()));
  return plex;
}

/// Names and numbers in the labels of groups.
class Groups {
 public:
  Groups(DM named, Span cells) {
    PetscInt labels = 0;
    UDAR_CALL(DMGetNumLabels(named, &labels));
    for (PetscInt i = 0; i < labels; ++i) {
      const char* name = nullptr;
      UDAR_CALL(DMGetLabelName(named, i, &name));
      if (const std::string of_plex = name; of_plex != "celltype" && of_plex != "depth") {
        read(named, name, cells);
      }
    }
  }

  Names curves;
  Names points;
  std::map<PetscInt, int> count;  ///< in how many groups a cell or vertex is

 private:
  void read(DM named, const char* name, Span cells) {
    DMLabel label = nullptr;
    UDAR_CALL(DMGetLabel(named, name, &label));
    petsc::IndexSet values;
    UDAR_CALL(DMLabelGetValueIS(label, values.put()));
    for (const PetscInt tag : indices(values)) {
      petsc::IndexSet members;
      UDAR_CALL(DMLabelGetStratumIS(label, tag, members.put()));
      for (const PetscInt point : indices(members)) {
        (cells.contains(point) ? curves : points).emplace(tag, name);
        ++count[point];
      }
    }
  }

  static std::vector<PetscInt> indices(IS set) {
    std::vector<PetscInt> all;
    if (set != nullptr) {
      PetscInt size = 0;
      const PetscInt* first = nullptr;
      UDAR_CALL(ISGetLocalSize(set, &size));
      UDAR_CALL(ISGetIndices(set, &first));
      all.assign(first, first + size);
      UDAR_CALL(ISRestoreIndices(set, &first));
    }
    return all;
  }
};

std::vector<std::string> values_of(const Names& names) {
  std::vector<std::string> values;
  for (const auto& [number, name] : names) {
    values.push_back(name);
  }
  return values;
}

/// Reads one file; every method throws Complaint.
class MeshReader {
 public:
  explicit MeshReader(const std::string& path) : version_{version_of(path)}, plex_{read_plex(path, false)} {
    PetscInt dimension = 0;
    UDAR_CALL(DMGetDimension(plex_, &dimension));
    if (dimension != 1) {
      throw Complaint{" has elements of dimension " + std::to_string(dimension) +
                      " as its largest, expected a mesh of lines, of dimension 1; save these alone"};
    }
    UDAR_CALL(DMPlexGetHeightStratum(plex_, 0, &cells_.first, &cells_.last));
    UDAR_CALL(DMPlexGetDepthStratum(plex_, 0, &vertices_.first, &vertices_.last));
    const Groups groups{read_plex(path, true), cells_};
    read_nodes();
    read_edges();
    mesh_.curves = values_of(groups.curves);
    mesh_.points = values_of(groups.points);
    read_groups(groups);
  }

  LineMesh take() { return std::move(mesh_); }

 private:
  void read_nodes() {
    Vec coordinates = nullptr;
    PetscSection section = nullptr;
    UDAR_CALL(DMGetCoordinatesLocal(plex_, &coordinates));
    UDAR_CALL(DMGetCoordinateSection(plex_, &section));
    PetscInt of_cell = 0;
    PetscInt begin = 0;
    PetscInt end = 0;
    UDAR_CALL(PetscSectionGetChart(section, &begin, &end));
    if (begin <= cells_.first && cells_.first < end) {
      UDAR_CALL(PetscSectionGetDof(section, cells_.first, &of_cell));
    }
    if (of_cell > 0) {
      throw Complaint{" has lines of higher order, expected straight ones of order 1: two nodes each"};
    }
    const petsc::ReadArray values{coordinates};
    for (PetscInt vertex = vertices_.first; vertex < vertices_.last; ++vertex) {
      PetscInt offset = 0;
      UDAR_CALL(PetscSectionGetOffset(section, vertex, &offset));
      const double* const at = values.values() + offset;
      mesh_.nodes.push_back({.x = at[0], .y = at[1], .z = at[2]});
    }
  }

  void read_edges() {
    for (PetscInt cell = cells_.first; cell < cells_.last; ++cell) {
      const PetscInt* cone = nullptr;
      UDAR_CALL(DMPlexGetCone(plex_, cell, &cone));
      mesh_.edges.push_back(
          {static_cast<std::size_t>(cone[0] - vertices_.first), static_cast<std::size_t>(cone[1] - vertices_.first)});
    }
  }

  [[nodiscard]] std::string edge_text(std::size_t edge) const {
    const auto& [from, to] = mesh_.edges[edge];
    return "the line from " + text_of(mesh_.nodes[from]) + " to " + text_of(mesh_.nodes[to]);
  }

  void read_groups(const Groups& groups) {
    DMLabel of_cells = nullptr;
    DMLabel of_vertices = nullptr;
    UDAR_CALL(DMGetLabel(plex_, "Cell Sets", &of_cells));
    UDAR_CALL(DMGetLabel(plex_, "Face Sets", &of_vertices));
    require_on_lines(of_vertices);
    for (std::size_t edge = 0; edge < mesh_.edges.size(); ++edge) {
      const PetscInt cell = cells_.first + static_cast<PetscInt>(edge);
      const std::size_t group = group_of(of_cells, cell, groups.curves);
      if (group == LineMesh::kNone) {
        throw Complaint{": " + edge_text(edge) +
                        " is in no physical group with a name, expected one that says its section"};
      }
      require_one(groups, cell, edge_text(edge));
      mesh_.edge_group.push_back(group);
    }
    for (std::size_t node = 0; node < mesh_.nodes.size(); ++node) {
      const PetscInt vertex = vertices_.first + static_cast<PetscInt>(node);
      require_one(groups, vertex, "the point at " + text_of(mesh_.nodes[node]));
      mesh_.node_group.push_back(group_of(of_vertices, vertex, groups.points));
    }
  }

  /// A point on no line has no vertex; some versions of PETSc take a cell in its place.
  void require_on_lines(DMLabel of_vertices) const {
    for (PetscInt cell = cells_.first; of_vertices != nullptr && cell < cells_.last; ++cell) {
      PetscInt tag = -1;
      UDAR_CALL(DMLabelGetValue(of_vertices, cell, &tag));
      if (tag != -1) {
        throw Complaint{" has a point in a physical group that is on no line"};
      }
    }
  }

  static std::size_t group_of(DMLabel label, PetscInt point, const Names& names) {
    PetscInt tag = -1;
    if (label != nullptr) {
      UDAR_CALL(DMLabelGetValue(label, point, &tag));
    }
    const auto found = names.find(tag);
    return found == names.end() ? LineMesh::kNone : static_cast<std::size_t>(std::distance(names.begin(), found));
  }

  /// Version 2 repeats an element for each of its groups, which `require_simple` finds.
  void require_one(const Groups& groups, PetscInt point, const std::string& what) const {
    constexpr double kWithEntities = 4.0;
    const auto count = groups.count.find(point);
    if (version_ >= kWithEntities && count != groups.count.end() && count->second > 1) {
      throw Complaint{": " + what + " is in " + std::to_string(count->second) + " physical groups, expected one"};
    }
  }

  double version_;
  Plex plex_;
  Span cells_;
  Span vertices_;
  LineMesh mesh_;
};

/// Refuses two nodes at one place, and two lines between the same nodes.
void require_simple(const LineMesh& mesh) {
  // Along a line on which no two nodes of a regular mesh meet.
  const auto along = [&](std::size_t node) {
    const auto& [x, y, z] = mesh.nodes[node];
    return x + std::numbers::sqrt2 * y + std::numbers::sqrt3 * z;
  };
  std::vector<std::size_t> order(mesh.nodes.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, {}, along);
  const double same = 1e-9 * (along(order.back()) - along(order.front()));
  for (std::size_t i = 0; i < order.size(); ++i) {
    const Place& here = mesh.nodes[order[i]];
    for (std::size_t j = i + 1; j < order.size() && along(order[j]) - along(order[i]) <= same; ++j) {
      const Place& other = mesh.nodes[order[j]];
      if (std::hypot(here.x - other.x, here.y - other.y, here.z - other.z) <= same) {
        throw Complaint{" has two nodes at " + text_of(here) + ", expected one; Gmsh's Coherence Mesh makes it one"};
      }
    }
  }
  std::vector<std::array<std::size_t, 2>> edges = mesh.edges;
  for (auto& [from, to] : edges) {
    if (from > to) {
      std::swap(from, to);
    }
  }
  std::ranges::sort(edges);
  if (const auto twice = std::ranges::adjacent_find(edges); twice != edges.end()) {
    throw Complaint{" has two lines from " + text_of(mesh.nodes[(*twice)[0]]) + " to " +
                    text_of(mesh.nodes[(*twice)[1]]) + ", expected one, in one physical group"};
  }
}

template <class T>
void share(MPI_Comm comm, std::vector<T>& values) {
  std::uint64_t size = values.size();
  MPI_Bcast(&size, 1, MPI_UINT64_T, 0, comm);
  values.resize(size);
  broadcast(comm, values.data(), values.size() * sizeof(T));
}

void share_names(MPI_Comm comm, std::vector<std::string>& names) {
  std::uint64_t size = names.size();
  MPI_Bcast(&size, 1, MPI_UINT64_T, 0, comm);
  names.resize(size);
  for (std::string& name : names) {
    std::vector<char> letters(name.begin(), name.end());
    share(comm, letters);
    name.assign(letters.begin(), letters.end());
  }
}

}  // namespace

LineMesh read_gmsh(MPI_Comm comm, const std::string& quantity, const std::string& path, const std::string& beside) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  LineMesh mesh;
  std::string failure;
  if (rank == 0) {
    try {
      const std::string found = find_file(path, beside.empty() ? beside : find_file(beside));
      if (const std::string fault = fault_of_mesh(read_file(found)); !fault.empty()) {
        throw Complaint{": " + fault};
      }
      mesh = MeshReader{found}.take();
      require_simple(mesh);
    } catch (const Complaint& complaint) {
      failure = quantity + ": '" + path + "'" + complaint.text;
    } catch (const petsc::Error& error) {
      failure = quantity + ": '" + path + "' cannot be read as a Gmsh mesh of lines alone: " + error.what();
    }
  }
  throw_together<FileError>(comm, failure);
  share(comm, mesh.nodes);
  share(comm, mesh.edges);
  share(comm, mesh.edge_group);
  share(comm, mesh.node_group);
  share_names(comm, mesh.curves);
  share_names(comm, mesh.points);
  return mesh;
}

}  // namespace udar::io
