#pragma once
/// @file
/// From the order in which ranks hold points to the user's.

#include <petscsf.h>

#include <cstdint>
#include <span>
#include <vector>

#include "udar/petsc/handle.hpp"
#include "udar/structure/field.hpp"
#include "udar/structure/mass_points.hpp"

namespace udar::io {

/// @brief What this rank has of a dataset: `[begin, end)` of `total`; the ranks hold consecutive ranges in their order.
struct NodeRange {
  PetscInt begin = 0;
  PetscInt end = 0;
  PetscInt total = 0;  ///< over all ranks

  [[nodiscard]] PetscInt count() const noexcept { return end - begin; }
};

/// @brief What this rank has where each has so many. @note Collective.
[[nodiscard]] NodeRange range_of(MPI_Comm comm, PetscInt own);

/// @brief Takes values of points, or of nodes or cells in their place, to the user's numbering, in which files keep
/// them, and back. Where both are the same, as in a chain, nothing moves. Numbers may leave some out: rows of a file do
/// not.
class PointOrder {
 public:
  /// @param[in] points of this rank
  /// @param[in] number of each of them in the user's model, >= 0, each once over all ranks; empty: as they stand
  /// @note Collective.
  PointOrder(MPI_Comm comm, const NodeRange& points, std::span<const std::int64_t> number = {});
  /// Of all points of a structure. @note Collective.
  explicit PointOrder(const MassPoints& points);
  /// Of all cells of a structure. @note Collective.
  PointOrder(MPI_Comm comm, const Topology& cells);

  /// The points that this rank has in a file: as many as it holds, in the user's numbering.
  [[nodiscard]] const NodeRange& range() const noexcept { return range_; }
  [[nodiscard]] MPI_Comm comm() const noexcept { return comm_; }
  [[nodiscard]] bool same() const noexcept { return moves_ == nullptr; }
  /// @name Values of points, `components` of each one behind the other @note Collective unless nothing moves.
  /// @{
  [[nodiscard]] std::vector<double> to_user(std::span<const double> own, int components = 1) const;
  [[nodiscard]] std::vector<std::int64_t> to_user(std::span<const std::int64_t> own, int components = 1) const;
  [[nodiscard]] std::vector<std::uint8_t> to_user(std::span<const std::uint8_t> own, int components = 1) const;
  [[nodiscard]] std::vector<double> from_user(std::span<const double> ordered) const;
  /// @}
  /// Values of global points, any rank's. @param[in] own one for each of this rank's points @note Collective.
  [[nodiscard]] std::vector<std::int64_t> values_at(std::span<const PetscInt> global,
                                                    std::span<const std::int64_t> own) const;
  /// Rows in a file of global points, any rank's. @note Collective unless nothing moves.
  [[nodiscard]] std::vector<std::int64_t> rows_of(std::span<const PetscInt> global) const;
  /// Of each of this rank's points the largest of the values, all >= 0, that any ranks have for it; 0 where there is
  /// none. @param[in] global the point of each value @note Collective.
  [[nodiscard]] std::vector<double> largest(std::span<const PetscInt> global, std::span<const double> values) const;

 private:
  template <class Value>
  [[nodiscard]] std::vector<Value> moved(std::span<const Value> own, MPI_Datatype type, int components) const;

  MPI_Comm comm_;
  NodeRange range_;
  std::vector<std::int64_t> row_;                 ///< of this rank's points; empty: nothing moves
  petsc::Handle<PetscSF, PetscSFDestroy> moves_;  ///< null: nothing moves
};

}  // namespace udar::io
