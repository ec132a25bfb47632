#pragma once
/// @file
/// The filter's operator of any stiffness matrix.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "udar/filter/operator.hpp"
#include "udar/petsc/handle.hpp"
#include "udar/structure/matrix_file.hpp"

namespace udar {

/// @brief wf^2 M + C for a given sparse C in [points | unknowns without mass]; it is solved for the stretch of the
/// filter springs, so that the acceleration of the masses suffers no cancellation but that of C Ym. That product takes
/// differences first: a translation gives nothing but what the sums of rows say. A fixed point, whose row and column
/// must be of the identity, stays where it is unstressed.
///
/// Internal numbers: the elastic force F - wf^2 m d on each point [N], 0 where it is fixed; half of its work along the
/// displacements is the strain energy. Source: docs/theory.md, "Imported matrices"
class AssembledOperator : public FilterOperator {
 public:
  /// @brief What is called a translation: points have one displacement all, or one for each direction in which they
  /// move.
  enum class Translation : std::uint8_t { of_all, by_direction };

  /// @param stiffness C, `MATAIJ`, symmetric [N/m]; each rank's rows are its points, then its unknowns without mass; it
  /// must live as long @param points whose masses are > 0 @param filter_frequency wf [rad/s]
  /// @note Collective.
  AssembledOperator(Mat stiffness, const MassPoints& points, double filter_frequency,
                    Translation translation = Translation::of_all);

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
  [[nodiscard]] std::string block_form_reason() const override { return "an assembled matrix"; }
  [[nodiscard]] bool definite() const override { return true; }
  [[nodiscard]] std::unique_ptr<ColumnSolver> with_springs(std::span<const ContactSpring> springs) const override;
  [[nodiscard]] double points_moved_together(std::size_t point) const override;

  /// Of each local unknown: the matrix is S (wf^2 M + C) S with S of powers of two.
  [[nodiscard]] std::span<const double> scale() const noexcept { return scale_; }

 protected:
  /// Whether a local point never moves.
  [[nodiscard]] bool fixed(std::size_t point) const { return fixed_[point]; }

 private:
  /// An entry of C beside the diagonal, in the column of a point.
  struct Entry {
    std::size_t column;  // in the values gathered for this rank
    double value;
  };
  /// The entries of a row in the columns of points that translate together.
  struct Group {
    std::size_t first = 0;  // entry
    std::size_t last = 0;   // and the one behind
    std::size_t near = 0;   // the displacement from which theirs are counted, in the values gathered
    double sum = 0.0;       // of the entries, the diagonal's too
  };
  void collect(Mat stiffness, const MassPoints& points, Translation translation);
  void add_row(PetscInt row, std::span<const MatrixEntry> entries, std::span<const PetscInt> columns,
               const double* groups);
  void create_matrix(Mat stiffness);

  MPI_Comm comm_ = MPI_COMM_NULL;
  double wf2_;
  std::vector<double> mass_;
  std::vector<bool> fixed_;               // of each point
  std::vector<double> scale_;             // of each unknown
  std::vector<std::size_t> first_group_;  // of each row, and the end
  std::vector<Group> groups_;
  std::vector<Entry> entries_;
  petsc::Matrix matrix_;  // scaled
  petsc::Vector given_;   // displacements, zero at unknowns without mass
  petsc::Vector needed_;  // those that this rank's rows need: its own and its neighbours'
  petsc::Handle<VecScatter, VecScatterDestroy> gather_;
};

}  // namespace udar
