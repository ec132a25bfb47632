#pragma once
/// @file
/// The filter's operator of any stiffness matrix.

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "udar/filter/operator.hpp"
#include "udar/petsc/handle.hpp"

namespace udar {

/// @brief wf^2 M + C for a given sparse C in [points | unknowns without mass]; it is solved for the stretch of the
/// filter springs, so that the acceleration of the masses suffers no cancellation but that of C Ym. That product takes
/// differences first: a translation gives nothing but what the sums of rows say.
///
/// Internal numbers: the elastic force F - wf^2 m d on each point [N], half of whose work along the displacements is
/// the strain energy. Source: docs/theory.md, "Imported matrices"
class AssembledOperator final : public FilterOperator {
 public:
  /// @param stiffness C, `MATAIJ`, symmetric [N/m]; each rank's rows are its points, then its unknowns without mass; it
  /// must live as long @param mass of the local points [kg], > 0 @param filter_frequency wf [rad/s]
  /// @note Collective.
  AssembledOperator(Mat stiffness, std::span<const double> mass, double filter_frequency);

  [[nodiscard]] MPI_Comm comm() const override { return comm_; }
  [[nodiscard]] std::span<const double> mass() const override { return mass_; }
  [[nodiscard]] std::size_t unknowns() const override { return scale_.size(); }
  [[nodiscard]] Mat op() const override { return matrix_; }
  [[nodiscard]] Mat matrix() override { return matrix_; }
  [[nodiscard]] double norm() const override;
  void right_hand_side(const FilterColumn& column, std::span<double> values) const override;
  void extract(std::span<const double> unknowns, const FilterColumn& column) const override;
  void unknowns_of(const FilterColumn& column, std::span<double> unknowns) const override;
  [[nodiscard]] double largest_unknown(const double* displacement) const override;
  [[nodiscard]] std::size_t internal_numbers() const override { return 1; }  // the elastic force
  void internal_of(std::span<const double> displacement, std::span<double> internal) override;
  [[nodiscard]] std::span<const FieldInfo> internal_fields() const override;
  void internal_values(std::span<const double> internal, std::span<double> values) const override;
  [[nodiscard]] double strain_energy(std::span<const double> displacement,
                                     std::span<const double> internal) const override;
  [[nodiscard]] const LineData* line() const override { return nullptr; }
  [[nodiscard]] std::string block_form_reason() const override { return "imported matrices"; }
  [[nodiscard]] bool definite() const override { return true; }
  [[nodiscard]] std::unique_ptr<ColumnSolver> with_springs(std::span<const ContactSpring> springs) const override;
  [[nodiscard]] double points_moved_together(std::size_t point) const override;

 private:
  /// An entry of C beside the diagonal, in the column of a point.
  struct Entry {
    std::size_t column;  // in the values gathered for this rank
    double value;
  };
  void collect(Mat stiffness);
  void create_matrix(Mat stiffness);

  MPI_Comm comm_ = MPI_COMM_NULL;
  double wf2_;
  std::vector<double> mass_;
  std::vector<double> scale_;       // of each unknown
  std::vector<double> row_sum_;     // of C over the columns of points
  std::vector<std::size_t> first_;  // entry of each row, and the end
  std::vector<Entry> entries_;
  std::size_t own_ = 0;   // this rank's first unknown among the values gathered
  petsc::Matrix matrix_;  // scaled
  petsc::Vector given_;   // displacements, zero at unknowns without mass
  petsc::Vector needed_;  // those that this rank's rows need: its own and its neighbours'
  petsc::Handle<VecScatter, VecScatterDestroy> gather_;
};

}  // namespace udar
