#include "io/line_mesh.hpp"

#include <algorithm>
#include <cmath>

namespace udar::io {
namespace {

struct Runs {
  explicit Runs(const LineMesh& of) : mesh{of}, ends(of.nodes.size()), degree(of.nodes.size()), used(of.edges.size()) {
    for (std::size_t edge = 0; edge < mesh.edges.size(); ++edge) {
      for (const std::size_t node : mesh.edges[edge]) {
        if (degree[node] < 2) {
          ends[node][degree[node]] = edge;
        }
        ++degree[node];
      }
    }
  }

  [[nodiscard]] std::size_t other_end(std::size_t edge, std::size_t node) const {
    return mesh.edges[edge][mesh.edges[edge][0] == node ? 1 : 0];
  }

  /// Whether nothing happens at a node but that one edge follows another.
  [[nodiscard]] bool inner(std::size_t node) const {
    constexpr double kSame = 1e-6;  // of an element: meshes are written with ten digits and more
    if (degree[node] != 2 || mesh.node_group[node] != LineMesh::kNone ||
        mesh.edge_group[ends[node][0]] != mesh.edge_group[ends[node][1]]) {
      return false;
    }
    const Place& before = mesh.nodes[other_end(ends[node][0], node)];
    const Place& here = mesh.nodes[node];
    const Place& after = mesh.nodes[other_end(ends[node][1], node)];
    const double change = std::hypot(after.x - 2.0 * here.x + before.x, after.y - 2.0 * here.y + before.y,
                                     after.z - 2.0 * here.z + before.z);
    return change <= kSame * std::hypot(here.x - before.x, here.y - before.y, here.z - before.z);
  }

  /// Goes from a node of an edge away from that edge as far as nothing happens. @return where that ends
  std::size_t follow(std::size_t edge, std::size_t node, std::size_t& count) {
    while (inner(node)) {
      edge = ends[node][ends[node][0] == edge ? 1 : 0];
      used[edge] = true;
      node = other_end(edge, node);
      ++count;
    }
    return node;
  }

  const LineMesh& mesh;
  std::vector<std::array<std::size_t, 2>> ends;  // the first two edges at each node
  std::vector<std::size_t> degree;
  std::vector<bool> used;
};

}  // namespace

std::vector<StraightRun> straight_runs(const LineMesh& mesh) {
  Runs runs{mesh};
  std::vector<StraightRun> found;
  for (std::size_t edge = 0; edge < mesh.edges.size(); ++edge) {
    if (runs.used[edge]) {
      continue;
    }
    runs.used[edge] = true;
    StraightRun& run = found.emplace_back();
    run.group = mesh.edge_group[edge];
    run.from = runs.follow(edge, mesh.edges[edge][0], run.elements);
    run.to = runs.follow(edge, mesh.edges[edge][1], run.elements);
  }
  return found;
}

}  // namespace udar::io
