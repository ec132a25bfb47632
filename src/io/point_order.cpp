#include "udar/io/point_order.hpp"

#include <algorithm>
#include <numeric>

#include "udar/petsc/error.hpp"

namespace udar::io {
namespace {

using Moves = petsc::Handle<PetscSF, PetscSFDestroy>;

/// How many numbers of all ranks are below each of these.
std::vector<PetscInt> places_of(MPI_Comm comm, std::span<const std::int64_t> number) {
  PetscInt end = 0;
  for (const std::int64_t own : number) {
    end = std::max(end, static_cast<PetscInt>(own) + 1);
  }
  MPI_Allreduce(MPI_IN_PLACE, &end, 1, MPIU_INT, MPI_MAX, comm);
  PetscLayout layout = nullptr;
  UDAR_CALL(PetscLayoutCreateFromSizes(comm, PETSC_DECIDE, end, 1, &layout));
  PetscInt local = 0;
  UDAR_CALL(PetscLayoutGetLocalSize(layout, &local));
  const std::vector<PetscInt> roots{number.begin(), number.end()};
  Moves moves;
  UDAR_CALL(PetscSFCreate(comm, moves.put()));
  UDAR_CALL(PetscSFSetGraphLayout(moves, layout, static_cast<PetscInt>(roots.size()), nullptr, PETSC_USE_POINTER,
                                  roots.data()));
  UDAR_CALL(PetscLayoutDestroy(&layout));
  const std::vector<PetscInt> one(roots.size(), 1);
  std::vector<PetscInt> there(static_cast<std::size_t>(local), 0);
  UDAR_CALL(PetscSFReduceBegin(moves, MPIU_INT, one.data(), there.data(), MPI_REPLACE));
  UDAR_CALL(PetscSFReduceEnd(moves, MPIU_INT, one.data(), there.data(), MPI_REPLACE));
  const PetscInt here = std::accumulate(there.begin(), there.end(), PetscInt{0});
  PetscInt before = 0;
  MPI_Exscan(&here, &before, 1, MPIU_INT, MPI_SUM, comm);
  std::exclusive_scan(there.begin(), there.end(), there.begin(), before);
  std::vector<PetscInt> places(roots.size());
  UDAR_CALL(PetscSFBcastBegin(moves, MPIU_INT, there.data(), places.data(), MPI_REPLACE));
  UDAR_CALL(PetscSFBcastEnd(moves, MPIU_INT, there.data(), places.data(), MPI_REPLACE));
  return places;
}

}  // namespace

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
  const std::vector<PetscInt> roots = places_of(comm, number);
  PetscLayout layout = nullptr;
  UDAR_CALL(PetscLayoutCreateFromSizes(comm, points.count(), points.total, 1, &layout));
  UDAR_CALL(PetscSFCreate(comm, moves_.put()));
  UDAR_CALL(PetscSFSetGraphLayout(moves_, layout, points.count(), nullptr, PETSC_USE_POINTER, roots.data()));
  UDAR_CALL(PetscLayoutDestroy(&layout));
}

std::vector<double> PointOrder::to_user(std::span<const double> own) const {
  std::vector<double> ordered{own.begin(), own.end()};
  if (moves_ != nullptr) {
    UDAR_CALL(PetscSFReduceBegin(moves_, MPI_DOUBLE, own.data(), ordered.data(), MPI_REPLACE));
    UDAR_CALL(PetscSFReduceEnd(moves_, MPI_DOUBLE, own.data(), ordered.data(), MPI_REPLACE));
  }
  return ordered;
}

std::vector<double> PointOrder::from_user(std::span<const double> ordered) const {
  std::vector<double> own{ordered.begin(), ordered.end()};
  if (moves_ != nullptr) {
    UDAR_CALL(PetscSFBcastBegin(moves_, MPI_DOUBLE, ordered.data(), own.data(), MPI_REPLACE));
    UDAR_CALL(PetscSFBcastEnd(moves_, MPI_DOUBLE, ordered.data(), own.data(), MPI_REPLACE));
  }
  return own;
}

}  // namespace udar::io
