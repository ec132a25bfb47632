#include "udar/io/point_order.hpp"

#include <petscis.h>

#include <algorithm>

#include "udar/petsc/error.hpp"

namespace udar::io {
namespace {

using Graph = petsc::Handle<PetscSF, PetscSFDestroy>;
using Indices = petsc::Handle<IS, ISDestroy>;

/// From entries dealt to the ranks as `range` says to those that this rank asks for.
void set_graph(MPI_Comm comm, const NodeRange& range, std::span<const PetscInt> asked, Graph& graph) {
  PetscLayout layout = nullptr;
  UDAR_CALL(PetscLayoutCreateFromSizes(comm, range.count(), range.total, 1, &layout));
  UDAR_CALL(PetscSFCreate(comm, graph.put()));
  UDAR_CALL(PetscSFSetGraphLayout(graph, layout, static_cast<PetscInt>(asked.size()), nullptr, PETSC_COPY_VALUES,
                                  asked.data()));
  UDAR_CALL(PetscLayoutDestroy(&layout));
}

std::vector<std::int64_t> numbers_of(const MassPoints& points) {
  std::vector<std::int64_t> numbers(points.points());
  for (std::size_t point = 0; point < numbers.size(); ++point) {
    numbers[point] = points.number(point);
  }
  return numbers;
}

}  // namespace

NodeRange range_of(MPI_Comm comm, PetscInt own) {
  NodeRange range;
  MPI_Scan(&own, &range.end, 1, MPIU_INT, MPI_SUM, comm);
  MPI_Allreduce(&own, &range.total, 1, MPIU_INT, MPI_SUM, comm);
  range.begin = range.end - own;
  return range;
}

PointOrder::PointOrder(const MassPoints& points)
    : PointOrder{
          points.comm(), {.begin = points.begin(), .end = points.end(), .total = points.total()}, numbers_of(points)} {}

PointOrder::PointOrder(MPI_Comm comm, const Topology& cells)
    : PointOrder{comm, range_of(comm, cells.cells()), cells.cell_number} {}

PointOrder::PointOrder(MPI_Comm comm, const NodeRange& points, std::span<const std::int64_t> number)
    : comm_{comm}, range_{points} {
  int same = 1;
  for (std::size_t i = 0; i < number.size(); ++i) {
    same &= number[i] == static_cast<std::int64_t>(points.begin) + static_cast<std::int64_t>(i) ? 1 : 0;
  }
  MPI_Allreduce(MPI_IN_PLACE, &same, 1, MPI_INT, MPI_LAND, comm);
  if (same != 0) {
    return;
  }
  const std::vector<PetscInt> numbers{number.begin(), number.end()};
  Indices all;
  Indices rows;
  UDAR_CALL(ISCreateGeneral(comm, points.count(), numbers.data(), PETSC_USE_POINTER, all.put()));
  UDAR_CALL(ISRenumber(all, nullptr, nullptr, rows.put()));
  const PetscInt* row = nullptr;
  UDAR_CALL(ISGetIndices(rows, &row));
  row_.assign(row, row + points.count());
  set_graph(comm, range_, {row, row_.size()}, moves_);
  UDAR_CALL(ISRestoreIndices(rows, &row));
}

template <class Value>
std::vector<Value> PointOrder::moved(std::span<const Value> own, MPI_Datatype type, int components) const {
  std::vector<Value> ordered{own.begin(), own.end()};
  if (moves_ != nullptr) {
    MPI_Datatype unit = type;
    if (components > 1) {
      MPI_Type_contiguous(components, type, &unit);
      MPI_Type_commit(&unit);
    }
    UDAR_CALL(PetscSFReduceBegin(moves_, unit, own.data(), ordered.data(), MPI_REPLACE));
    UDAR_CALL(PetscSFReduceEnd(moves_, unit, own.data(), ordered.data(), MPI_REPLACE));
    if (components > 1) {
      MPI_Type_free(&unit);
    }
  }
  return ordered;
}

std::vector<double> PointOrder::to_user(std::span<const double> own, int components) const {
  return moved(own, MPI_DOUBLE, components);
}

std::vector<std::int64_t> PointOrder::to_user(std::span<const std::int64_t> own, int components) const {
  return moved(own, MPI_INT64_T, components);
}

std::vector<std::uint8_t> PointOrder::to_user(std::span<const std::uint8_t> own, int components) const {
  return moved(own, MPI_UNSIGNED_CHAR, components);
}

std::vector<double> PointOrder::from_user(std::span<const double> ordered) const {
  std::vector<double> own{ordered.begin(), ordered.end()};
  if (moves_ != nullptr) {
    UDAR_CALL(PetscSFBcastBegin(moves_, MPI_DOUBLE, ordered.data(), own.data(), MPI_REPLACE));
    UDAR_CALL(PetscSFBcastEnd(moves_, MPI_DOUBLE, ordered.data(), own.data(), MPI_REPLACE));
  }
  return own;
}

std::vector<std::int64_t> PointOrder::values_at(std::span<const PetscInt> global,
                                                std::span<const std::int64_t> own) const {
  std::vector<std::int64_t> values(global.size());
  Graph asked;
  set_graph(comm_, range_, global, asked);
  UDAR_CALL(PetscSFBcastBegin(asked, MPI_INT64_T, own.data(), values.data(), MPI_REPLACE));
  UDAR_CALL(PetscSFBcastEnd(asked, MPI_INT64_T, own.data(), values.data(), MPI_REPLACE));
  return values;
}

std::vector<std::int64_t> PointOrder::rows_of(std::span<const PetscInt> global) const {
  return moves_ != nullptr ? values_at(global, row_) : std::vector<std::int64_t>{global.begin(), global.end()};
}

std::vector<double> PointOrder::largest(std::span<const PetscInt> global, std::span<const double> values) const {
  Graph asked;
  set_graph(comm_, range_, global, asked);
  std::vector<double> most(static_cast<std::size_t>(range_.count()), 0.0);
  UDAR_CALL(PetscSFReduceBegin(asked, MPI_DOUBLE, values.data(), most.data(), MPI_MAX));
  UDAR_CALL(PetscSFReduceEnd(asked, MPI_DOUBLE, values.data(), most.data(), MPI_MAX));
  return most;
}

}  // namespace udar::io
