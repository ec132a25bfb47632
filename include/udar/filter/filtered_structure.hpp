#pragma once
/// @file
/// The solve with wf^2 M + C: where the massless line stands for given masses and loads.

#include <algorithm>
#include <cstddef>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "udar/filter/chain_solver.hpp"
#include "udar/filter/corrected_modes.hpp"
#include "udar/filter/filter_column.hpp"
#include "udar/filter/framed_columns.hpp"
#include "udar/filter/moved_points.hpp"
#include "udar/filter/network_solver.hpp"
#include "udar/filter/operator.hpp"
#include "udar/petsc/handle.hpp"
#include "udar/structure/beam_chain.hpp"

namespace udar {

/// @brief The massless elastic structure on its filter springs: an operator under a PETSc `KSP`, and what is asked of
/// its solves whatever the operator is.
///
/// Displacements are those from the place where the structure, its end springs and its foundation are unstressed. Every
/// some solves the residual is computed with the operator's own product. Source: docs/theory.md, "The discrete line".
/// @note Options: `-filter_ksp_type`, `-filter_pc_type`, `-filter_mat_type`, ... (any PETSc solver option with the
/// prefix `filter_`). Default: `preonly` and `chain`, which then solves without forming a right-hand side. Under
/// tension and in the Hermite form: LU of the assembled matrix in natural order on one rank; on several, the same
/// repeated on every rank up to 200 000 nodes, MUMPS beyond; and one refinement step. Of other matrices that are
/// definite: `preonly` and Cholesky, by CHOLMOD on one rank, which orders by AMD or METIS as the factor is smaller, and
/// by MUMPS on several.
class FilteredStructure {
 public:
  FilteredStructure(const FilteredStructure&) = delete;
  FilteredStructure& operator=(const FilteredStructure&) = delete;
  ~FilteredStructure() = default;
  /// Factors. @note Collective.
  /// @throws InputError if wf is not positive, or the chain solver is asked for what it cannot carry; petsc::Error if
  /// PETSc cannot set up the solver asked for
  FilteredStructure(const Structure& structure, const FilterParameters& parameters);

  /// @brief Solves (wf^2 M + C) Yc = wf^2 M Ym + F.
  /// @param[in]  mass_displacement Ym minus the reference axis [m], one value per local node
  /// @param[in]  force             F [N], one value per local node; empty: none
  /// @param[out] stretch           d = Yc - Ym [m]
  /// @param[out] moment            EI w'' [N m], of other structures `FilterOperator::internal_numbers` of each; empty:
  /// not wanted
  /// @note Collective: a message to the neighbours, then what the solver needs.
  /// @throws InputError if `moment` has another size; SolveError if the solver reports divergence (KSP's reason is
  /// named) or the residual check fails
  void solve(std::span<const double> mass_displacement, std::span<const double> force, std::span<double> stretch,
             std::span<double> moment);

  /// @brief The same for several columns at once: the factor is read once for four, or for the pair that is left.
  /// @param columns displacement, force, stretch, moment; the same of them given in all
  void solve(std::span<const FilterColumn> columns);

  /// @brief Internal forces where the points of the structure stand at given places, whatever holds them there.
  /// @param column displacement Yc [m] and kink in, internal forces out, as `solve` gives them
  /// @note Collective: a solve that is none of the line's. @throws InputError if the operator cannot
  void internal_of(const FilterColumn& column);

  /// @brief Makes some modes exact: from now on the stretch that `solve` gives is that of the pull wf^2 d on the
  /// masses, with these modes at their own frequencies w, and its moment is that of the line, rigidly tied to the
  /// masses in these modes. Where that line stands: `line_stretch`. Source: docs/theory.md, "Corrected modes".
  /// @param modes M-orthonormal, frequencies and number equal on every rank
  /// @note Not collective; before any integrator for this line is made. From then on per solve of a column k dot
  /// products and k axpys, per batch one reduction of k numbers a column, 8 k bytes a node; a moment costs a second
  /// solve.
  void correct(std::vector<CorrectedMode> modes);
  [[nodiscard]] std::span<const CorrectedMode> corrected_modes() const noexcept { return corrected_.modes(); }
  /// phi' M d [m kg^(1/2)] of every corrected mode, of a column of the last `solve`; equal on every rank.
  [[nodiscard]] std::span<const double> amplitudes(std::size_t column = 0) const {
    return corrected_.amplitudes(column);
  }
  /// @brief Turns the stretch of the pull on the masses into Yc - Ym of the line.
  /// @param[in] amplitudes as `amplitudes` gave them with it @param[in,out] stretch [m]
  void line_stretch(std::span<const double> amplitudes, std::span<double> stretch) const {
    corrected_.subtract(amplitudes, stretch);
  }
  /// @brief From now on the force of a column at these points, which something holds, is how far that moves them [m];
  /// what their masses do follows from it as from any move of the line. @note Not collective; as `correct`, and not
  /// with it. From then on per batch of solves one reduction of as many numbers a column as there are points, and an
  /// axpy for each that has moved. Source: docs/theory.md, "Motion of held places"
  void move(MovedPoints points) { moved_ = std::move(points); }
  [[nodiscard]] const MovedPoints& moved() const noexcept { return moved_; }
  /// No frequency of the masses on the line is higher [rad/s]: wf, or that of a corrected mode above it.
  [[nodiscard]] double frequency_bound() const noexcept {
    return std::max(parameters_.shift(), corrected_.highest_frequency());
  }

  [[nodiscard]] const Structure& structure() const noexcept { return *structure_; }
  [[nodiscard]] const MassPoints& points() const noexcept { return structure_->points(); }
  [[nodiscard]] const FilterParameters& parameters() const noexcept { return parameters_; }
  /// What is solved with: internal forces, energy, springs at contact points.
  [[nodiscard]] FilterOperator& filter_operator() const noexcept { return *operator_; }
  [[nodiscard]] std::span<const double> mass() const noexcept { return operator_->mass(); }  ///< [kg], local points
  /// wf, without filter 2 / step [rad/s]: `FilterParameters::shift`.
  [[nodiscard]] double filter_frequency() const noexcept { return parameters_.shift(); }
  [[nodiscard]] PetscInt solves() const noexcept { return solves_; }
  [[nodiscard]] KSP solver() const noexcept { return solver_; }      ///< for PETSc calls beyond this class
  [[nodiscard]] Mat op() const noexcept { return operator_->op(); }  ///< its product, scaled, in its own unknowns
  /// The chain solver where it serves, else null: why not is in `FilterOperator::block_form_reason`.
  [[nodiscard]] const ChainSolver* chain() const noexcept { return dynamic_cast<const ChainSolver*>(direct_); }
  /// That of a network where it serves, else null.
  [[nodiscard]] const NetworkSolver* network() const noexcept { return dynamic_cast<const NetworkSolver*>(direct_); }
  /// Largest normwise backward error seen by the residual check so far [-].
  [[nodiscard]] double worst_residual() const noexcept { return worst_residual_; }

 private:
  void configure_solver();
  void right_hand_side(const FilterColumn& column);
  void solve_by_columns(std::span<const FilterColumn> columns);
  void solve_by_ksp(const FilterColumn& column);
  void require_convergence() const;
  void solve_together(std::span<const FilterColumn> columns);
  void solve_filtered(std::span<const FilterColumn> columns);
  void solve_unknowns(std::span<const FilterColumn> columns);
  void correct_internal(std::span<const FilterColumn> columns);
  [[nodiscard]] bool check_due(std::size_t solves) const;
  void check_residual(const double* displacement);

  const Structure* structure_;
  FilterParameters parameters_;
  std::unique_ptr<FilterOperator> operator_;
  petsc::LinearSolver solver_;
  ColumnSolver* direct_ = nullptr;        // the operator's own
  ColumnSolver* columns_ = nullptr;       // what serves, that one or one around it
  std::unique_ptr<ColumnSolver> around_;  // of columns that are not the operator's own; null: they are
  FramedColumns framed_;
  CorrectedModes corrected_;
  MovedPoints moved_;
  petsc::Vector right_hand_side_;
  petsc::Vector unknowns_;
  petsc::Vector residual_;
  petsc::Matrix right_hand_sides_;  // of columns that are solved together
  petsc::Matrix solutions_;
  double matrix_norm_ = 0.0;
  PetscInt solves_ = 0;
  double worst_residual_ = 0.0;
};

}  // namespace udar
