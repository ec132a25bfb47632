#pragma once
/// @file
/// wf^2 M + C of a structure with what strikes it, and with masses that travel along it.

#include <memory>
#include <vector>

#include "udar/filter/operator.hpp"
#include "udar/structure/mass_points.hpp"

namespace udar {

/// @brief Columns of a structure and of its strikers, as columns of the structure alone: nothing ties a striker, so
/// that its line stands off it by the force on it over wf^2 times its mass. Nothing ties a mass that travels, either,
/// before `CarriedMasses` does.
class StruckColumns {
 public:
  /// @param points must live as long @param shift wf [rad/s]
  StruckColumns(const MassPoints& points, double shift);

  /// Displacements of the structure's own points, valid until the next call. @param[in] values local points, null: none
  [[nodiscard]] const double* displacement(const double* values, std::size_t column = 0);
  /// Forces on them, in the same way.
  [[nodiscard]] const double* force(const double* values, std::size_t column = 0);
  /// A column with both of them. @param index of the column in its batch
  [[nodiscard]] FilterColumn of_structure(FilterColumn column, std::size_t index = 0);
  /// @brief Completes a stretch of the structure's own points. @param[in] force on all points, null: none
  void complete(const double* force, double* stretch) const;
  /// The way back, in place.
  void reduce(double* stretch) const;

 private:
  const double* copy(const double* values, std::size_t column, std::vector<std::vector<double>>& copies) const;

  const MassPoints* points_;
  double shift2_;
  std::vector<std::vector<double>> displacement_;  // by column
  std::vector<std::vector<double>> force_;
};

/// @brief The operator of the structure alone, seen from the points of both. Source: docs/theory.md, "Strikers"
class StruckOperator final : public FilterOperator {
 public:
  /// @param points of structure and strikers, must live as long @param shift wf [rad/s]
  StruckOperator(std::unique_ptr<FilterOperator> structure, const MassPoints& points, double shift);

  [[nodiscard]] MPI_Comm comm() const override { return structure_->comm(); }
  [[nodiscard]] std::span<const double> mass() const override { return points_->mass(); }
  [[nodiscard]] std::size_t unknowns() const override { return structure_->unknowns(); }
  [[nodiscard]] Mat op() const override { return structure_->op(); }
  [[nodiscard]] Mat matrix() override { return structure_->matrix(); }
  [[nodiscard]] double norm() const override { return structure_->norm(); }
  void right_hand_side(const FilterColumn& column, std::span<double> values) const override;
  void extract(std::span<const double> unknowns, const FilterColumn& column) const override;
  void unknowns_of(const FilterColumn& column, std::span<double> unknowns) const override;
  [[nodiscard]] double largest_unknown(const double* displacement) const override;
  [[nodiscard]] std::size_t internal_numbers() const override { return structure_->internal_numbers(); }
  void internal_of(const FilterColumn& column) override;
  [[nodiscard]] std::span<const FieldInfo> internal_fields() const override { return structure_->internal_fields(); }
  [[nodiscard]] std::size_t internal_places() const override;
  void internal_values(std::span<const double> internal, std::span<double> values) const override;
  [[nodiscard]] double strain_energy(std::span<const double> displacement,
                                     std::span<const double> internal) const override;
  /// None: what works on its nodes one by one knows no strikers.
  [[nodiscard]] const LineData* line() const override { return nullptr; }
  [[nodiscard]] const char* solver_type() const override { return structure_->solver_type(); }
  [[nodiscard]] std::string block_form_reason() const override { return structure_->block_form_reason(); }
  [[nodiscard]] bool definite() const override { return structure_->definite(); }
  [[nodiscard]] std::unique_ptr<ColumnSolver> around(ColumnSolver& solver) const override;
  [[nodiscard]] std::unique_ptr<ColumnSolver> with_springs(std::span<const ContactSpring> springs) const override;
  [[nodiscard]] double points_moved_together(std::size_t point) const override;

 private:
  [[nodiscard]] std::span<const double> own_internal(std::span<const double> internal) const;

  std::unique_ptr<FilterOperator> structure_;
  const MassPoints* points_;
  double shift_;
  mutable StruckColumns columns_;  // what it gives lives until the next call
};

}  // namespace udar
