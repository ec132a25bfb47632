#include "udar/filter/filtered_structure.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "udar/filter/pc_chain.hpp"
#include "udar/filter/pc_network.hpp"
#include "udar/petsc/array.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/log.hpp"
#include "udar/petsc/options.hpp"

namespace udar {
namespace {

/// Up to this many nodes every rank factors the whole line itself: a hundred times faster than MUMPS, for 100 MB a rank
/// at the most (docs/performance.md). Beyond, no rank holds more than its piece.
constexpr PetscInt kMostRepeatedNodes = 200000;

/// The block form's direct solver, before options.
void choose_factorisation(PC preconditioner, MPI_Comm comm, PetscInt nodes) {
  int size = 1;
  MPI_Comm_size(comm, &size);
  PC factorisation = preconditioner;
  if (size > 1 && nodes <= kMostRepeatedNodes) {
    UDAR_CALL(PCSetType(preconditioner, PCREDUNDANT));
    KSP repeated = nullptr;
    UDAR_CALL(PCRedundantGetKSP(preconditioner, &repeated));
    UDAR_CALL(KSPGetPC(repeated, &factorisation));
  }
  UDAR_CALL(PCSetType(factorisation, PCLU));
  UDAR_CALL(PCFactorSetMatOrderingType(factorisation, MATORDERINGNATURAL));
  if (size > 1 && factorisation == preconditioner) {
    UDAR_CALL(PCFactorSetMatSolverType(preconditioner, MATSOLVERMUMPS));
  }
}

/// That of a definite matrix, before options. CHOLMOD keeps the given ordering where its own by AMD, or by METIS if AMD
/// fills much, gives no smaller factor; reverse Cuthill-McKee does so for what is long and slender.
void choose_cholesky(PC preconditioner, MPI_Comm comm) {
  int size = 1;
  MPI_Comm_size(comm, &size);
  UDAR_CALL(PCSetType(preconditioner, PCCHOLESKY));
  UDAR_CALL(PCFactorSetMatSolverType(preconditioner, size == 1 ? MATSOLVERCHOLMOD : MATSOLVERMUMPS));
  if (size == 1) {
    UDAR_CALL(PCFactorSetMatOrderingType(preconditioner, MATORDERINGRCM));
  }
}

void require_filter_frequency(const FilterParameters& parameters) {
  const auto allowed = [](double value) { return value > 0.0 && std::isfinite(value); };
  if (parameters.filtered() && !allowed(parameters.filter_frequency)) {
    throw InputError{"filter frequency: " + std::to_string(parameters.filter_frequency) +
                     " is not allowed, expected a number > 0 [rad/s]"};
  }
  if (!parameters.filtered() && !allowed(parameters.step)) {
    throw InputError{"time step without filter: " + std::to_string(parameters.step) +
                     " is not allowed, expected a number > 0 [s]"};
  }
}

/// The solver inside a preconditioner that solves for whole columns, null for others.
ColumnSolver* column_solver(PC pc) {
  if (ColumnSolver* chain = chain_solver(pc)) {
    return chain;
  }
  return network_solver(pc);
}

}  // namespace

FilteredStructure::FilteredStructure(const Structure& structure, const FilterParameters& parameters)
    : structure_{&structure}, parameters_{parameters}, framed_{structure.points()} {
  require_filter_frequency(parameters);
  const petsc::LogScope scope{petsc::log_events().assemble};
  operator_ = make_operator(structure, parameters);
  configure_solver();
}

void FilteredStructure::configure_solver() {
  std::array<char, 64> type{};
  PetscBool given = PETSC_FALSE;
  UDAR_CALL(PetscOptionsGetString(nullptr, "filter_", "-pc_type", type.data(), type.size(), &given));
  const std::string reason = operator_->block_form_reason();
  const bool by_columns = given == PETSC_TRUE ? std::string{operator_->solver_type()} == type.data() : reason.empty();
  if (by_columns && !reason.empty()) {
    throw InputError{"filter pc type: chain cannot carry this line (" + reason + "), use lu, or leave the option out"};
  }
  UDAR_CALL(register_pc_chain());
  UDAR_CALL(register_pc_network());
  UDAR_CALL(KSPCreate(operator_->comm(), solver_.put()));
  UDAR_CALL(KSPSetOptionsPrefix(solver_, "filter_"));
  UDAR_CALL(KSPSetOperators(solver_, op(), by_columns ? op() : operator_->matrix()));
  PC preconditioner = nullptr;
  UDAR_CALL(KSPGetPC(solver_, &preconditioner));
  if (by_columns) {
    UDAR_CALL(PCSetType(preconditioner, operator_->solver_type()));
    UDAR_CALL(KSPSetType(solver_, KSPPREONLY));
  } else if (operator_->definite()) {
    choose_cholesky(preconditioner, operator_->comm());
    UDAR_CALL(KSPSetType(solver_, KSPPREONLY));
  } else {
    choose_factorisation(preconditioner, operator_->comm(), points().total());
    // A direct solve and one step of iterative refinement: two Richardson iterations from zero.
    UDAR_CALL(KSPSetType(solver_, KSPRICHARDSON));
  }
  PetscBool other_type = PETSC_FALSE;
  UDAR_CALL(PetscOptionsHasName(nullptr, "filter_", "-ksp_type", &other_type));
  if (other_type == PETSC_TRUE) {
    // 1e-12: what an iterative solver can reach here and the time integration does not notice.
    UDAR_CALL(KSPSetTolerances(solver_, 1e-12, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
  } else if (!by_columns && !operator_->definite()) {
    UDAR_CALL(KSPSetNormType(solver_, KSP_NORM_NONE));
    UDAR_CALL(KSPSetTolerances(solver_, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT, 2));
  }
  UDAR_CALL(KSPSetFromOptions(solver_));
  UDAR_CALL(KSPSetUp(solver_));
  PetscBool direct = PETSC_FALSE;
  UDAR_CALL(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(static_cast<KSP>(solver_)), KSPPREONLY, &direct));
  if (direct == PETSC_TRUE) {
    direct_ = column_solver(preconditioner);
    around_ = direct_ != nullptr ? operator_->around(*direct_) : nullptr;
  }
  if (direct_ != nullptr) {
    // KSPSolve, which would do this, is not on its way.
    UDAR_CALL(KSPViewFromOptions(solver_, nullptr, "-ksp_view"));
  }
  columns_ = around_ != nullptr ? around_.get() : direct_;
}

void FilteredStructure::solve(std::span<const double> mass_displacement, std::span<const double> force,
                              std::span<double> stretch, std::span<double> moment) {
  if (!moment.empty() && moment.size() != mass().size() * operator_->internal_numbers()) {
    throw InputError{"internal forces: room for " + std::to_string(moment.size()) +
                     " numbers is not allowed, expected " +
                     std::to_string(mass().size() * operator_->internal_numbers())};
  }
  const FilterColumn column{.displacement = mass_displacement.data(),
                            .force = force.empty() ? nullptr : force.data(),
                            .stretch = stretch.data(),
                            .internal = moment.empty() ? nullptr : moment.data()};
  solve({&column, 1});
}

void FilteredStructure::solve(std::span<const FilterColumn> columns) {
  const petsc::LogScope scope{petsc::log_events().solve};
  solve_filtered(columns);
  if (!corrected_.empty()) {
    corrected_.apply(operator_->comm(), mass(), columns);
    correct_internal(columns);
  }
}

/// Masses that are displaced by minus the amplitudes put the filtered structure where it really is.
void FilteredStructure::correct_internal(std::span<const FilterColumn> columns) {
  const std::size_t count = mass().size();
  for (std::size_t c = 0; c < columns.size(); ++c) {
    if (columns[c].internal != nullptr) {
      std::vector<double> displacement(columns[c].displacement, columns[c].displacement + count);
      std::vector<double> stretch(count);
      corrected_.subtract(corrected_.amplitudes(c), displacement);
      FilterColumn column = columns[c];
      column.displacement = displacement.data();
      column.stretch = stretch.data();
      solve_filtered({&column, 1});
    }
  }
}

void FilteredStructure::internal_of(const FilterColumn& column) {
  operator_->internal_of(framed_.none() ? column : framed_.of_unknowns({&column, 1}).front());
}

void FilteredStructure::correct(std::vector<CorrectedMode> modes) {
  corrected_ = CorrectedModes{std::move(modes), parameters_.shift()};
}

void FilteredStructure::solve_filtered(std::span<const FilterColumn> columns) {
  const std::span<const FilterColumn> at_rest = moved_.empty() ? columns : moved_.at_rest(mass().size(), columns);
  if (framed_.none()) {
    solve_unknowns(at_rest);
  } else {
    solve_unknowns(framed_.of_unknowns(at_rest));
    framed_.stretches_of_points(at_rest);
  }
  if (!moved_.empty()) {
    moved_.apply(operator_->comm(), mass().size(), operator_->internal_numbers(), columns);
  }
}

void FilteredStructure::solve_unknowns(std::span<const FilterColumn> columns) {
  const bool kinked = std::ranges::any_of(columns, [](const FilterColumn& column) { return column.kink != nullptr; });
  if (columns_ != nullptr && !kinked) {
    return solve_by_columns(columns);
  }
  if (columns.size() > 1 && operator_->definite()) {
    return solve_together(columns);
  }
  for (const FilterColumn& column : columns) {
    solve_by_ksp(column);
  }
}

/// Whether the residual check falls among the next solves.
bool FilteredStructure::check_due(std::size_t solves) const {
  const PetscInt interval = parameters_.check_interval;
  return interval > 0 && (solves_ + interval - 1) % interval + static_cast<PetscInt>(solves) >= interval;
}

void FilteredStructure::solve_by_columns(std::span<const FilterColumn> columns) {
  if (!check_due(columns.size())) {
    columns_->solve(columns);
    solves_ += static_cast<PetscInt>(columns.size());
    return;
  }
  // The first column's solution, with its internal forces, is put into the operator that the solver has never seen.
  FilterColumn checked = columns.front();
  std::vector<double> internal(checked.internal == nullptr ? mass().size() * operator_->internal_numbers() : 0);
  if (checked.internal == nullptr) {
    checked.internal = internal.data();
  }
  columns_->solve({&checked, 1});
  columns_->solve(columns.subspan(1));
  solves_ += static_cast<PetscInt>(columns.size());
  right_hand_side(checked);
  {
    const petsc::WriteArray unknowns{unknowns_};
    operator_->unknowns_of(checked, {unknowns.values(), operator_->unknowns()});
  }
  check_residual(checked.displacement);
  // 48 bytes per node, seldom needed.
  unknowns_.reset();
  right_hand_side_.reset();
  residual_.reset();
}

void FilteredStructure::right_hand_side(const FilterColumn& column) {
  if (unknowns_ == nullptr) {
    UDAR_CALL(MatCreateVecs(op(), unknowns_.put(), right_hand_side_.put()));
  }
  const petsc::WriteArray right{right_hand_side_};
  operator_->right_hand_side(column, {right.values(), operator_->unknowns()});
}

void FilteredStructure::require_convergence() const {
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  UDAR_CALL(KSPGetConvergedReason(solver_, &reason));
  if (reason <= 0) {
    PetscInt iterations = 0;
    UDAR_CALL(KSPGetIterationNumber(solver_, &iterations));
    throw SolveError{std::string{"the line solve did not converge: "} + KSPConvergedReasons[reason] + " after " +
                     std::to_string(iterations) + " iterations (see -filter_ksp_monitor, -filter_ksp_view)"};
  }
}

void FilteredStructure::solve_by_ksp(const FilterColumn& column) {
  right_hand_side(column);
  UDAR_CALL(KSPSolve(solver_, right_hand_side_, unknowns_));
  require_convergence();
  const bool due = check_due(1);
  ++solves_;
  if (due) {
    check_residual(column.displacement);
  }

  const petsc::ReadArray solution{unknowns_};
  operator_->extract({solution.values(), operator_->unknowns()}, column);
}

/// A direct solver reads its factor once for all columns.
void FilteredStructure::solve_together(std::span<const FilterColumn> columns) {
  const auto rows = static_cast<PetscInt>(operator_->unknowns());
  const auto count = static_cast<PetscInt>(columns.size());
  PetscInt columns_before = 0;
  if (right_hand_sides_ != nullptr) {
    UDAR_CALL(MatGetSize(right_hand_sides_, nullptr, &columns_before));
  }
  if (columns_before != count) {
    PetscInt all = 0;
    UDAR_CALL(MatGetSize(op(), &all, nullptr));
    for (petsc::Matrix* block : {&right_hand_sides_, &solutions_}) {
      UDAR_CALL(MatCreateDense(operator_->comm(), rows, PETSC_DECIDE, all, count, nullptr, block->put()));
    }
  }
  PetscInt pitch = 0;
  double* values = nullptr;
  UDAR_CALL(MatDenseGetLDA(right_hand_sides_, &pitch));
  UDAR_CALL(MatDenseGetArrayWrite(right_hand_sides_, &values));
  for (std::size_t c = 0; c < columns.size(); ++c) {
    operator_->right_hand_side(columns[c], {values + static_cast<PetscInt>(c) * pitch, operator_->unknowns()});
  }
  UDAR_CALL(MatDenseRestoreArrayWrite(right_hand_sides_, &values));
  UDAR_CALL(KSPMatSolve(solver_, right_hand_sides_, solutions_));
  require_convergence();
  const bool due = check_due(columns.size());
  solves_ += count;
  const double* solution = nullptr;
  UDAR_CALL(MatDenseGetLDA(solutions_, &pitch));
  UDAR_CALL(MatDenseGetArrayRead(solutions_, &solution));
  for (std::size_t c = 0; c < columns.size(); ++c) {
    operator_->extract({solution + static_cast<PetscInt>(c) * pitch, operator_->unknowns()}, columns[c]);
  }
  if (due) {
    right_hand_side(columns.front());
    const petsc::WriteArray unknowns{unknowns_};
    std::copy_n(solution, operator_->unknowns(), unknowns.values());
  }
  UDAR_CALL(MatDenseRestoreArrayRead(solutions_, &solution));
  if (due) {
    check_residual(columns.front().displacement);
  }
}

void FilteredStructure::check_residual(const double* displacement) {
  if (residual_ == nullptr) {
    UDAR_CALL(VecDuplicate(right_hand_side_, residual_.put()));
  }
  if (matrix_norm_ == 0.0) {
    matrix_norm_ = operator_->norm();
  }
  double residual = 0.0;
  double solution = 0.0;
  double given = 0.0;
  double sum = 0.0;  // largest values over the ranks may lose what is not a number
  UDAR_CALL(MatMult(op(), unknowns_, residual_));
  UDAR_CALL(VecAYPX(residual_, -1.0, right_hand_side_));
  UDAR_CALL(VecNorm(residual_, NORM_1, &sum));
  UDAR_CALL(VecNorm(residual_, NORM_INFINITY, &residual));
  UDAR_CALL(VecNorm(unknowns_, NORM_INFINITY, &solution));
  UDAR_CALL(VecNorm(right_hand_side_, NORM_INFINITY, &given));
  double offset = operator_->largest_unknown(displacement);
  MPI_Allreduce(MPI_IN_PLACE, &offset, 1, MPI_DOUBLE, MPI_MAX, operator_->comm());
  // A rigid motion has no right-hand side but the rounding of the positions: that much residual says nothing.
  constexpr double kRounding = 64.0 * std::numeric_limits<double>::epsilon();
  const double bound = matrix_norm_ * solution + given;
  const double rounding = kRounding * matrix_norm_ * offset;
  const double error = residual <= rounding ? 0.0 : (residual - rounding) / bound;
  if (!(error <= parameters_.residual_tolerance) || !std::isfinite(sum)) {
    throw SolveError{"the line solve is wrong: backward error " + std::to_string(error) +
                     " exceeds `filter residual tolerance` " + std::to_string(parameters_.residual_tolerance) +
                     " although the solver reported success (see -filter_ksp_view)"};
  }
  worst_residual_ = std::max(worst_residual_, error);
}

}  // namespace udar
