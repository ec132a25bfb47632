#include "udar/io/shown_rows.hpp"

#include <algorithm>
#include <cstdint>
#include <numeric>

#include "udar/io/point_order.hpp"
#include "udar/petsc/error.hpp"

namespace udar::io {
namespace {

/// Cells in a row as one: the first of them, and the corners of all together.
struct CellPieces {
  std::vector<std::size_t> cell;
  std::vector<PetscInt> corners;
};

CellPieces each_cell(const Topology& topology) {
  CellPieces pieces{.cell = std::vector<std::size_t>(static_cast<std::size_t>(topology.cells())),
                    .corners = topology.corners};
  std::iota(pieces.cell.begin(), pieces.cell.end(), std::size_t{0});
  return pieces;
}

/// A chain's elements have the numbers of their left nodes; those of a member stand together on one rank.
CellPieces strided_cells(MPI_Comm comm, const Topology& topology, PetscInt stride) {
  if (topology.shape != Topology::Shape::line) {
    throw InputError{"output stride: " + std::to_string(stride) +
                     " is not allowed for imported matrices, which have no lines; expected 1"};
  }
  CellPieces pieces;
  const auto add = [&pieces](std::size_t cell, PetscInt from, PetscInt to) {
    pieces.cell.push_back(cell);
    pieces.corners.insert(pieces.corners.end(), {from, to});
  };
  const auto cells = static_cast<std::size_t>(topology.cells());
  const PetscInt last = range_of(comm, topology.cells()).total;
  if (topology.member.empty()) {
    for (std::size_t cell = 0; cell < cells; ++cell) {
      if (const PetscInt node = topology.corners[2 * cell]; node % stride == 0) {
        add(cell, node, std::min(node + stride, last));
      }
    }
    return pieces;
  }
  const auto step = static_cast<std::size_t>(stride);
  for (std::size_t first = 0, end = 0; first < cells; first = end) {
    while (end < cells && topology.member[end] == topology.member[first]) {
      ++end;
    }
    for (std::size_t cell = first; cell < end; cell += step) {
      add(cell, topology.corners[2 * cell], topology.corners[2 * std::min(cell + step, end) - 1]);
    }
  }
  return pieces;
}

/// Those of these pieces whose corners all have a mark, and which belong to a member that is wanted.
CellPieces kept_pieces(const CellPieces& all, std::span<const std::int64_t> marks, const Topology& topology,
                       const RowChoice& choice) {
  const auto corners = static_cast<std::size_t>(Topology::corners_of(topology.shape));
  CellPieces kept;
  for (std::size_t i = 0; i < all.cell.size(); ++i) {
    const auto marked = marks.subspan(i * corners, corners);
    const bool wanted = choice.members.empty() || std::ranges::count(choice.members, topology.member[all.cell[i]]) > 0;
    if (wanted && std::ranges::all_of(marked, [](std::int64_t mark) { return mark != 0; })) {
      kept.cell.push_back(all.cell[i]);
      const auto from = all.corners.begin() + static_cast<std::ptrdiff_t>(i * corners);
      kept.corners.insert(kept.corners.end(), from, from + static_cast<std::ptrdiff_t>(corners));
    }
  }
  return kept;
}

/// Values of some places, of a list that may be empty.
template <class Value>
std::vector<Value> some_of(const std::vector<Value>& all, const std::vector<std::size_t>& chosen) {
  std::vector<Value> some;
  for (std::size_t i = 0; !all.empty() && i < chosen.size(); ++i) {
    some.push_back(all[chosen[i]]);
  }
  return some;
}

}  // namespace

ShownRows choose_rows(const MassPoints& points, const Topology& topology, std::span<const std::size_t> a_point,
                      const RowChoice& choice) {
  ShownRows shown;
  if (choice.all()) {
    shown.nodes.resize(a_point.size());
    std::iota(shown.nodes.begin(), shown.nodes.end(), std::size_t{0});
    shown.cells = each_cell(topology).cell;
    shown.topology = topology;
    return shown;
  }
  const MPI_Comm comm = points.comm();
  const PointOrder every{comm, range_of(comm, static_cast<PetscInt>(a_point.size()))};
  std::vector<std::int64_t> inside(a_point.size());
  std::ranges::transform(a_point, inside.begin(), [&](std::size_t point) -> std::int64_t {
    return choice.everywhere || choice.region.holds(points.place(point)) ? 1 : 0;
  });
  const CellPieces all = choice.stride > 1 ? strided_cells(comm, topology, choice.stride) : each_cell(topology);
  const CellPieces kept = kept_pieces(all, every.values_at(all.corners, inside), topology, choice);
  const std::vector<double> touched = every.largest(kept.corners, std::vector<double>(kept.corners.size(), 1.0));
  for (std::size_t node = 0; node < touched.size(); ++node) {
    if (touched[node] > 0.0) {
      shown.nodes.push_back(node);
    }
  }
  const NodeRange range = range_of(comm, static_cast<PetscInt>(shown.nodes.size()));
  if (range.total == 0) {
    throw InputError{"output region: no element of the structure lies in it, expected one at least"};
  }
  std::vector<std::int64_t> row(a_point.size(), 0);
  for (std::size_t i = 0; i < shown.nodes.size(); ++i) {
    row[shown.nodes[i]] = static_cast<std::int64_t>(range.begin) + static_cast<std::int64_t>(i);
  }
  shown.cells = kept.cell;
  shown.topology = {.name = topology.name, .shape = topology.shape, .corners = {}};
  for (const std::int64_t corner : every.values_at(kept.corners, row)) {
    shown.topology.corners.push_back(static_cast<PetscInt>(corner));
  }
  shown.topology.node_number = some_of(topology.node_number, shown.nodes);
  shown.topology.cell_number = some_of(topology.cell_number, shown.cells);
  shown.topology.member = some_of(topology.member, shown.cells);
  shown.topology.radius = some_of(topology.radius, shown.cells);
  return shown;
}

}  // namespace udar::io
