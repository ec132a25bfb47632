#pragma once
/// @file
/// What the filter's operators of structures that are no chain share.

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "udar/filter/operator.hpp"
#include "udar/petsc/handle.hpp"
#include "udar/structure/mass_points.hpp"

namespace udar {

/// @brief S (wf^2 M + C) S with S of powers of two, so that scaled entries keep their digits, in [points | unknowns
/// without mass]; it is solved for the stretch of the filter springs, so that the acceleration of the masses suffers no
/// cancellation but that of C Ym. A fixed point, whose row and column are of the identity, stays where it is
/// unstressed.
class ScaledOperator : public FilterOperator {
 public:
  [[nodiscard]] MPI_Comm comm() const override { return comm_; }
  [[nodiscard]] std::span<const double> mass() const override { return mass_; }
  [[nodiscard]] std::size_t unknowns() const override { return scale_.size(); }
  [[nodiscard]] double largest_unknown(const double* displacement) const override;
  void internal_of(const FilterColumn& column) override;
  [[nodiscard]] const LineData* line() const override { return nullptr; }
  [[nodiscard]] bool definite() const override { return true; }
  [[nodiscard]] std::unique_ptr<ColumnSolver> with_springs(std::span<const ContactSpring> springs) const override;
  [[nodiscard]] double points_moved_together(std::size_t point) const override;

  /// Of each local unknown.
  [[nodiscard]] std::span<const double> scale() const noexcept { return scale_; }

 protected:
  /// @param points whose masses are > 0 @param filter_frequency wf [rad/s]
  ScaledOperator(MPI_Comm comm, const MassPoints& points, double filter_frequency);

  /// @param diagonal of C, local unknowns
  void set_scale(std::span<const double> diagonal);
  /// The matrix. @param stiffness C, `MATAIJ` @note Collective.
  [[nodiscard]] petsc::Matrix assembled(Mat stiffness) const;
  /// wf^2 m of a point, 0 of what has no mass.
  [[nodiscard]] double ground(std::size_t unknown) const {
    return unknown < mass_.size() ? wf2_ * mass_[unknown] : 0.0;
  }
  /// Whether a local point never moves.
  [[nodiscard]] bool fixed(std::size_t point) const { return fixed_[point]; }
  /// The stretch, from the unknowns.
  void extract_stretch(std::span<const double> unknowns, const FilterColumn& column) const;

 private:
  MPI_Comm comm_;
  double wf2_;
  std::vector<double> mass_;
  std::vector<bool> fixed_;    // of each point
  std::vector<double> scale_;  // of each unknown
};

}  // namespace udar
