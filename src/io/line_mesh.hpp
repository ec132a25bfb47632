#pragma once
/// @file
/// Meshes of straight lines in space.

#include <mpi.h>

#include <array>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "udar/structure/mass_points.hpp"

namespace udar::io {

/// @brief Nodes, edges between them, and the named groups that both are in; equal on every rank.
struct LineMesh {
  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

  std::vector<Place> nodes;                       ///< [m]
  std::vector<std::array<std::size_t, 2>> edges;  ///< from node to node
  std::vector<std::size_t> edge_group;            ///< of each edge, in `curves`
  std::vector<std::size_t> node_group;            ///< of each node, in `points`, or `kNone`
  std::vector<std::string> curves;                ///< names of the groups of edges
  std::vector<std::string> points;                ///< and of nodes
};

/// @brief Reads a Gmsh file of lines, version 2.2, 4.0 or 4.1, ASCII or binary, by PETSc's DMPlex. Physical groups of
/// curves and of points are the groups; they need names.
/// @param quantity for messages @param beside as `find_file` takes it
/// @note Collective; rank 0 reads. @throws FileError, InputError on all ranks naming the file, and what is wrong: no
/// Gmsh file, no lines, lines of higher order, elements of surfaces or volumes, a line without a named group or in two,
/// two nodes at one place, two lines between the same nodes
[[nodiscard]] LineMesh read_gmsh(MPI_Comm comm, const std::string& quantity, const std::string& path,
                                 const std::string& beside);

/// @brief Edges one after the other, of one group, straight.
struct StraightRun {
  std::size_t from = 0;           ///< node
  std::size_t to = 0;             ///< node
  std::size_t elements = 1;       ///< edges
  std::size_t group = 0;          ///< in `LineMesh::curves`
  std::vector<double> lengths{};  ///< of the edges [m]; empty if all are equal
};

/// @brief The longest runs between nodes where something else happens: a branch, an end, a change of group or
/// direction, a node in a group, or where equal edges meet equal ones of another length, which are longer or shorter by
/// more than 1e-6. In the order of their first edges, in the direction of these.
[[nodiscard]] std::vector<StraightRun> straight_runs(const LineMesh& mesh);

}  // namespace udar::io
