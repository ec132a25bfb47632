#pragma once
/// @file
/// From the order in which ranks hold points to the user's.

#include <petscsf.h>

#include <cstdint>
#include <span>
#include <vector>

#include "udar/io/layout.hpp"
#include "udar/petsc/handle.hpp"

namespace udar::io {

/// @brief Takes values of points to the user's numbering, in which files keep them, and back. Where both are the same,
/// as in a chain, nothing moves.
class PointOrder {
 public:
  /// @param[in] points of this rank
  /// @param[in] number of each of them in the user's model, not negative, each once over all ranks; files have the
  /// points in ascending order of these; empty: as they stand
  /// @note Collective.
  PointOrder(MPI_Comm comm, const NodeRange& points, std::span<const std::int64_t> number = {});

  /// The points that this rank has in a file: as many as it holds, in the user's numbering.
  [[nodiscard]] const NodeRange& range() const noexcept { return range_; }
  [[nodiscard]] MPI_Comm comm() const noexcept { return comm_; }
  /// @name One value a point @note Collective unless nothing moves.
  /// @{
  [[nodiscard]] std::vector<double> to_user(std::span<const double> own) const;
  [[nodiscard]] std::vector<double> from_user(std::span<const double> ordered) const;
  /// @}

 private:
  MPI_Comm comm_;
  NodeRange range_;
  petsc::Handle<PetscSF, PetscSFDestroy> moves_;  ///< null: nothing moves
};

}  // namespace udar::io
