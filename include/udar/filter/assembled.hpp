#pragma once
/// @file
/// The filter's operator of any stiffness matrix.

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "udar/filter/scaled_operator.hpp"
#include "udar/petsc/handle.hpp"
#include "udar/structure/matrix_file.hpp"

namespace udar {

/// @brief wf^2 M + C for a given sparse C, whose fixed points have rows and columns of the identity. The product with
/// displacements takes differences first: a translation gives nothing but what the sums of rows say.
///
/// Internal numbers: the elastic force F - wf^2 m d on each point [N], 0 where it is fixed; half of its work along the
/// displacements is the strain energy. Source: docs/theory.md, "Imported matrices"
class AssembledOperator final : public ScaledOperator {
 public:
  /// @param stiffness C, `MATAIJ`, symmetric [N/m]; each rank's rows are its points, then its unknowns without mass; it
  /// must live as long @param points whose masses are > 0 @param filter_frequency wf [rad/s]
  /// @note Collective.
  AssembledOperator(Mat stiffness, const MassPoints& points, double filter_frequency);

  [[nodiscard]] Mat op() const override { return matrix_; }
  [[nodiscard]] Mat matrix() override { return matrix_; }
  [[nodiscard]] double norm() const override;
  void right_hand_side(const FilterColumn& column, std::span<double> values) const override;
  void extract(std::span<const double> unknowns, const FilterColumn& column) const override;
  void unknowns_of(const FilterColumn& column, std::span<double> unknowns) const override;
  [[nodiscard]] std::size_t internal_numbers() const override { return 1; }  // the elastic force
  [[nodiscard]] std::span<const FieldInfo> internal_fields() const override;
  void internal_values(std::span<const double> internal, std::span<double> values) const override;
  [[nodiscard]] double strain_energy(std::span<const double> displacement,
                                     std::span<const double> internal) const override;
  [[nodiscard]] std::string block_form_reason() const override { return "an assembled matrix"; }

 private:
  /// An entry of C beside the diagonal, in the column of a point.
  struct Entry {
    std::size_t column;  // in the values gathered for this rank
    double value;
  };
  /// The entries of a row in the columns of points.
  struct Row {
    std::size_t first = 0;  // entry
    std::size_t last = 0;   // and the one behind
    std::size_t near = 0;   // the displacement from which theirs are counted, in the values gathered
    double sum = 0.0;       // of the entries, the diagonal's too
  };
  void collect(Mat stiffness);
  void add_row(PetscInt row, std::span<const MatrixEntry> entries, std::span<const PetscInt> columns,
               const double* points);

  std::vector<Row> rows_;
  std::vector<Entry> entries_;
  petsc::Matrix matrix_;  // scaled
  petsc::Vector given_;   // displacements, zero at unknowns without mass
  petsc::Vector needed_;  // those that this rank's rows need: its own and its neighbours'
  petsc::Handle<VecScatter, VecScatterDestroy> gather_;
};

}  // namespace udar
