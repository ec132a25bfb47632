#pragma once
/// @file
/// The solve with wf^2 M + C: where the massless line stands for given masses and loads.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "udar/filter/chain_solver.hpp"
#include "udar/petsc/handle.hpp"
#include "udar/structure/beam_chain.hpp"

namespace udar {

/// @brief How the bending line is discretised; both describe the same line.
enum class Formulation : std::uint8_t {
  mixed,    ///< displacement and moment (three-moment equation), keeps its digits on fine meshes
  hermite,  ///< displacement and rotation, for comparison
};

/// @brief What shapes a `FilteredStructure`.
struct FilterParameters {
  double filter_frequency = 0.0;  ///< wf [rad/s], > 0
  Formulation formulation = Formulation::mixed;
  PetscInt check_interval = 50;      ///< every so many solves the residual is computed; 0: never
  double residual_tolerance = 1e-8;  ///< largest normwise backward error that passes the check [-]
  /// The masses are those of the line itself; wf is 2 / time step, for `-ts_type moreau` alone.
  bool unfiltered = false;
};

/// @brief A mode of the beam to which the line answers as if it had no filter springs.
struct CorrectedMode {
  double frequency = 0.0;     ///< w of the lumped beam [rad/s]
  std::vector<double> shape;  ///< phi at the local nodes [kg^(-1/2)], phi' M phi = 1 over all ranks
};

/// @brief The massless elastic line on its filter springs, as a distributed block-2 operator under a PETSc `KSP`.
///
/// Unknowns are displacements from the reference axis, the straight line on which end springs and foundation are
/// unstressed. The operator is scaled on both sides to a diagonal near one; the mixed form solves for the spring
/// stretch d = Yc - Ym, so that the acceleration wf^2 d of the masses suffers no cancellation. The KSP's operator is
/// matrix-free and differences before it multiplies; a matrix is assembled for preconditioners that need one. Source:
/// docs/theory.md, "The discrete line".
/// @note Options: `-filter_ksp_type`, `-filter_pc_type`, `-filter_mat_type`, ... (any PETSc solver option with the
/// prefix `filter_`). Default: `preonly` and `chain`, which then solves without forming a right-hand side. Under
/// tension and in the Hermite form: LU of the assembled matrix in natural order on one rank; on several, the same
/// repeated on every rank up to 200 000 nodes, MUMPS beyond; and one refinement step.
class FilteredStructure {
 public:
  FilteredStructure(const FilteredStructure&) = delete;
  FilteredStructure& operator=(const FilteredStructure&) = delete;
  ~FilteredStructure() = default;
  /// Factors. @note Collective.
  /// @throws InputError if wf is not positive, or the chain solver is asked for what it cannot carry; petsc::Error if
  /// PETSc cannot set up the solver asked for
  FilteredStructure(const BeamChain& beam, const FilterParameters& parameters);

  /// @brief Solves (wf^2 M + C) Yc = wf^2 M Ym + F.
  /// @param[in]  mass_displacement Ym minus the reference axis [m], one value per local node
  /// @param[in]  force             F [N], one value per local node; empty: none
  /// @param[out] stretch           d = Yc - Ym [m]
  /// @param[out] moment            EI w'' [N m]; empty: not wanted
  /// @note Collective: a message to the neighbours, then what the solver needs.
  /// @throws SolveError if the solver reports divergence (KSP's reason is named) or the residual check fails
  void solve(std::span<const double> mass_displacement, std::span<const double> force, std::span<double> stretch,
             std::span<double> moment);

  /// @brief The same for several columns at once: the factor is read once for four, or for the pair that is left.
  /// @param columns displacement, force, stretch, moment; the same of them given in all
  void solve(std::span<const chain::Column> columns);

  /// @brief Bending moments of a line that stands at given places: S mu = T w. @param[in] line_displacement Yc minus
  /// the reference axis [m] @param[out] moment [N m]
  /// @note Collective: a solve with S, a well conditioned tridiagonal matrix; options `-filter_moment_ksp_*`.
  /// @throws InputError in the Hermite form; SolveError if the solver diverges
  void moments_of(std::span<const double> line_displacement, std::span<double> moment);

  /// @brief Makes some modes exact: from now on the stretch that `solve` gives is that of the pull wf^2 d on the
  /// masses, with these modes at their own frequencies w, and its moment is that of the line, rigidly tied to the
  /// masses in these modes. Where that line stands: `line_stretch`. Source: docs/theory.md, "Corrected modes".
  /// @param modes M-orthonormal, frequencies and number equal on every rank
  /// @note Not collective; before any integrator for this line is made. From then on per solve of a column k dot
  /// products and k axpys, per batch one reduction of k numbers a column, 8 k bytes a node; a moment costs a second
  /// solve.
  void correct(std::vector<CorrectedMode> modes);
  [[nodiscard]] std::span<const CorrectedMode> corrected_modes() const noexcept { return corrected_; }
  /// phi' M d [m kg^(1/2)] of every corrected mode, of a column of the last `solve`; equal on every rank.
  [[nodiscard]] std::span<const double> amplitudes(std::size_t column = 0) const {
    return std::span{amplitudes_}.subspan(column * corrected_.size(), corrected_.size());
  }
  /// @brief Turns the stretch of the pull on the masses into Yc - Ym of the line.
  /// @param[in] amplitudes as `amplitudes` gave them with it @param[in,out] stretch [m]
  void line_stretch(std::span<const double> amplitudes, std::span<double> stretch) const;
  /// No frequency of the masses on the line is higher [rad/s]: wf, or that of a corrected mode above it.
  [[nodiscard]] double frequency_bound() const noexcept { return frequency_bound_; }

  /// @brief Elastic energy of the line: bending, shear, tension, foundation and end springs [J], this rank's share.
  /// @param[in] line_displacement Yc minus the reference axis [m], @param[in] moment [N m]
  /// @note Collective: one message to each neighbour.
  [[nodiscard]] double strain_energy(std::span<const double> line_displacement, std::span<const double> moment) const;

  /// @brief dM/dx in the element to the right of each local node [N], exact: the moment is linear in an element; 0 in a
  /// gap and right of the last node. @param[in] moment [N m] @param[out] shear [N]
  /// @note Collective: one message to each neighbour.
  void shear(std::span<const double> moment, std::span<double> shear) const;

  [[nodiscard]] const BeamChain& beam() const noexcept { return *beam_; }
  [[nodiscard]] const MassPoints& points() const noexcept { return beam_->points(); }
  [[nodiscard]] const FilterParameters& parameters() const noexcept { return parameters_; }
  [[nodiscard]] std::span<const double> mass() const noexcept { return mass_; }  ///< [kg], local nodes
  [[nodiscard]] double filter_frequency() const noexcept { return parameters_.filter_frequency; }
  [[nodiscard]] PetscInt solves() const noexcept { return solves_; }
  [[nodiscard]] KSP solver() const noexcept { return solver_; }  ///< for PETSc calls beyond this class
  [[nodiscard]] Mat op() const noexcept { return operator_; }    ///< matrix-free, scaled, two unknowns per node
  /// The same assembled, on first demand. @note Collective.
  [[nodiscard]] Mat matrix();
  /// The chain solver where it serves, else null: why not is in `block_form_reason`.
  [[nodiscard]] const ChainSolver* chain() const noexcept { return chain_; }
  /// Why the assembled block form is solved by default: "tension", "Hermite form", or empty.
  [[nodiscard]] std::string block_form_reason() const;
  /// Largest normwise backward error seen by the residual check so far [-].
  [[nodiscard]] double worst_residual() const noexcept { return worst_residual_; }

 private:
  /// What the products need of an element: 1/h, and the entries of its matrix (side and cross in the Hermite form
  /// only).
  struct ElementTerms {
    double inverse_length = 0.0;
    double diagonal = 0.0;
    double coupling = 0.0;
    double side = 0.0;
    double cross = 0.0;
  };
  /// What a node adds to the diagonal, and which of its two unknowns there are.
  struct NodeTerms {
    std::array<double, 2> diagonal;
    std::array<bool, 2> present;
  };
  /// An entry that only an end of a beam has: of an elastic rotation, or 1 for an unknown that is not there.
  struct EndTerm {
    std::size_t index;
    double value;  // scaled
  };

  [[nodiscard]] ElementTerms element_terms(const BeamElement& element) const;
  [[nodiscard]] std::array<std::array<double, 4>, 4> element_matrix(const ElementTerms& e) const;
  [[nodiscard]] NodeTerms node_terms(PetscInt node, double stiffness) const;
  [[nodiscard]] std::array<double, 2> scales(const NodeTerms& terms, const BeamElement& left,
                                             const BeamElement& right) const;
  [[nodiscard]] double spring(std::size_t i) const;
  void collect_terms();
  template <class Add>
  void each_entry(const Add& add) const;
  void create_operator();
  void assemble();
  void configure_solver();
  void multiply(std::span<const double> unknowns, std::span<double> product) const;
  void right_hand_side(const chain::Column& column);
  void mixed_right_hand_side(const chain::Column& column, std::span<double> values) const;
  void hermite_moments(std::span<const double> unknowns, std::span<double> moment) const;
  void solve_by_chain(std::span<const chain::Column> columns);
  void solve_by_ksp(const chain::Column& column);
  void create_moment_solver();
  void solve_filtered(std::span<const chain::Column> columns);
  void add_correction(std::span<const chain::Column> columns);
  [[nodiscard]] bool check_due(std::size_t solves) const;
  void check_residual(const double* displacement);
  static PetscErrorCode multiply_callback(Mat matrix, Vec unknowns, Vec product);

  const BeamChain* beam_;
  FilterParameters parameters_;
  double wf2_;
  double frequency_bound_;
  std::vector<CorrectedMode> corrected_;
  std::vector<double> amplitudes_;  // [column][mode]
  LineData line_;
  std::vector<double> mass_;
  std::vector<EndTerm> end_terms_;
  petsc::Matrix matrix_;    // assembled, for the preconditioners that need it
  petsc::Matrix operator_;  // the same as a product without rounding of rigid motions
  petsc::LinearSolver solver_;
  ChainSolver* chain_ = nullptr;
  petsc::Vector right_hand_side_;
  petsc::Vector unknowns_;
  petsc::Vector residual_;
  petsc::LinearSolver moment_solver_;
  petsc::Vector moment_right_;
  petsc::Vector moment_unknowns_;
  std::vector<double> checked_moment_;
  double matrix_norm_ = 0.0;
  PetscInt solves_ = 0;
  double worst_residual_ = 0.0;
};

}  // namespace udar
