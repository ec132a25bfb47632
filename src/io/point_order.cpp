#include "udar/io/point_order.hpp"

#include <algorithm>

#include "udar/petsc/error.hpp"

namespace udar::io {

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
  PetscLayout layout = nullptr;
  UDAR_CALL(PetscLayoutCreateFromSizes(comm, points.count(), points.total, 1, &layout));
  const std::vector<PetscInt> roots{number.begin(), number.end()};
  UDAR_CALL(PetscSFCreate(comm, moves_.put()));
  UDAR_CALL(PetscSFSetGraphLayout(moves_, layout, points.count(), nullptr, PETSC_USE_POINTER, roots.data()));
  UDAR_CALL(PetscLayoutDestroy(&layout));
}

std::vector<double> PointOrder::to_user(std::span<const double> held) const {
  std::vector<double> ordered{held.begin(), held.end()};
  if (moves_ != nullptr) {
    UDAR_CALL(PetscSFReduceBegin(moves_, MPI_DOUBLE, held.data(), ordered.data(), MPI_REPLACE));
    UDAR_CALL(PetscSFReduceEnd(moves_, MPI_DOUBLE, held.data(), ordered.data(), MPI_REPLACE));
  }
  return ordered;
}

std::vector<double> PointOrder::from_user(std::span<const double> ordered) const {
  std::vector<double> held{ordered.begin(), ordered.end()};
  if (moves_ != nullptr) {
    UDAR_CALL(PetscSFBcastBegin(moves_, MPI_DOUBLE, ordered.data(), held.data(), MPI_REPLACE));
    UDAR_CALL(PetscSFBcastEnd(moves_, MPI_DOUBLE, ordered.data(), held.data(), MPI_REPLACE));
  }
  return held;
}

}  // namespace udar::io
