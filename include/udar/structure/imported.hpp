#pragma once
/// @file
/// Any elastic structure, given by its stiffness and mass matrix.

#include <petscmat.h>

#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "udar/petsc/handle.hpp"
#include "udar/structure/structure.hpp"

namespace udar {

/// @brief How a consistent mass matrix becomes a diagonal one.
enum class Lumping : std::uint8_t {
  row,  ///< sums of rows
  hrz,  ///< diagonal, scaled to the same total (Hinton, Rock, Zienkiewicz 1976): never negative
};

/// @brief Where an imported structure comes from.
struct ImportParameters {
  std::string stiffness;  ///< file, see `read_matrix`; [N/m] of displacements
  std::string mass;       ///< file; [kg] of displacements
  Lumping lumping = Lumping::row;
  PetscInt most_unknowns = std::numeric_limits<PetscInt>::max();  ///< for which there is memory
  std::vector<Place> places{};          ///< of each unknown, equal on every rank; empty: x is its number
  std::vector<Direction> directions{};  ///< the same, which way it moves; empty: all along y
};

/// @brief Masses and stiffness of a structure in scalar unknowns: each unknown that has mass is a point which moves in
/// its own direction, the others follow without inertia.
///
/// Unknowns are numbered from 0 in the order of the files. Each rank has a contiguous piece of them; within it those
/// with mass come first, of these those that move along y. The stiffness may let the whole move rigidly. Source:
/// docs/theory.md, "Imported matrices"
class ImportedStructure final : public Structure {
 public:
  /// Reads, checks, lumps. @note Collective; rank 0 factors the whole stiffness once.
  /// @throws FileError as `read_matrix`; InputError on all ranks if a matrix is not square, sizes differ, a matrix is
  /// not symmetric, a mass is negative, the stiffness is indefinite, an unknown without mass is not held by others, or
  /// there are not as many places as unknowns
  ImportedStructure(MPI_Comm comm, const ImportParameters& parameters);

  /// Numbers are those of the unknowns in the files.
  [[nodiscard]] const MassPoints& points() const override { return *points_; }
  /// Its points.
  [[nodiscard]] Topology topology() const override;
  /// Six, or as many as the factorisation finds.
  [[nodiscard]] PetscInt rigid_modes() const override { return rigid_modes_; }
  /// Whether it has a stiffness against a translation along y.
  [[nodiscard]] bool grounded() const override { return grounded_; }
  void describe(Description& all) const override;
  [[nodiscard]] Mat stiffness() const override { return stiffness_; }
  [[nodiscard]] double largest_ratio() const override;

  [[nodiscard]] PetscInt unknowns() const noexcept { return unknowns_; }    ///< of all ranks
  [[nodiscard]] double total_mass() const noexcept { return total_mass_; }  ///< sum of all entries of the matrix [kg]

 private:
  [[nodiscard]] petsc::Vector lumped(Mat mass, Lumping lumping);
  void check_unknowns(Mat stiffness, Vec mass) const;
  void check_pivots(Mat stiffness, Vec mass);
  [[nodiscard]] bool resists_translation(Mat stiffness, const std::vector<Direction>& directions) const;
  void order(Mat stiffness, Vec mass, const ImportParameters& parameters);

  MPI_Comm comm_;
  PetscInt unknowns_ = 0;
  PetscInt rigid_modes_ = 0;
  bool grounded_ = false;
  double total_mass_ = 0.0;
  std::uint64_t checksum_ = 0;  // to tell two structures apart
  std::unique_ptr<PlacedPoints> points_;
  petsc::Matrix stiffness_;
};

}  // namespace udar
