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

  [[nodiscard]] double length(std::size_t edge) const {
    const Place& from = mesh.nodes[mesh.edges[edge][0]];
    const Place& to = mesh.nodes[mesh.edges[edge][1]];
    return std::hypot(to.x - from.x, to.y - from.y, to.z - from.z);
  }

  /// Whether a node is where one edge goes on as another.
  [[nodiscard]] bool straight(std::size_t node) const {
    if (degree[node] != 2 || mesh.node_group[node] != LineMesh::kNone ||
        mesh.edge_group[ends[node][0]] != mesh.edge_group[ends[node][1]]) {
      return false;
    }
    const std::array size{length(ends[node][0]), length(ends[node][1])};
    const Place& before = mesh.nodes[other_end(ends[node][0], node)];
    const Place& here = mesh.nodes[node];
    const Place& after = mesh.nodes[other_end(ends[node][1], node)];
    const auto turn = [&](double a, double b, double c) { return (c - b) / size[1] - (b - a) / size[0]; };
    return std::hypot(turn(before.x, here.x, after.x), turn(before.y, here.y, after.y),
                      turn(before.z, here.z, after.z)) <= kSame;
  }

  [[nodiscard]] static bool equal(double one, double other) { return std::abs(one - other) <= kSame * one; }

  /// Whether an edge is one of a row of equal ones that ends at a node.
  [[nodiscard]] bool ends_row(std::size_t edge, std::size_t node) const {
    const std::size_t other = other_end(edge, node);
    return straight(other) && equal(length(ends[other][0]), length(ends[other][1]));
  }

  /// Whether nothing happens at a node.
  [[nodiscard]] bool inner(std::size_t node) const {
    const auto& [left, right] = ends[node];
    return straight(node) && (equal(length(left), length(right)) || !ends_row(left, node) || !ends_row(right, node));
  }

  /// Goes from a node of an edge away from that edge as far as nothing happens. @param lengths of the edges, added to
  /// @return where that ends
  std::size_t follow(std::size_t edge, std::size_t node, std::vector<double>& lengths) {
    while (inner(node)) {
      edge = ends[node][ends[node][0] == edge ? 1 : 0];
      used[edge] = true;
      node = other_end(edge, node);
      lengths.push_back(length(edge));
    }
    return node;
  }

  static constexpr double kSame = 1e-6;  // meshes are written with ten digits and more

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
    run.from = runs.follow(edge, mesh.edges[edge][0], run.lengths);
    std::ranges::reverse(run.lengths);
    run.lengths.push_back(runs.length(edge));
    run.to = runs.follow(edge, mesh.edges[edge][1], run.lengths);
    run.elements = run.lengths.size();
    const auto differ = [](double one, double other) { return !Runs::equal(one, other); };
    if (std::ranges::adjacent_find(run.lengths, differ) == run.lengths.end()) {
      run.lengths.clear();
    }
  }
  return found;
}

}  // namespace udar::io
