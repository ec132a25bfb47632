#include "udar/filter/filtered_line.hpp"

#include <array>
#include <cmath>
#include <string>

#include "udar/petsc/error.hpp"
#include "udar/petsc/options.hpp"
#include "udar/petsc/session.hpp"

namespace udar {
namespace {

/// Up to this many nodes every rank factors the whole line itself: a hundred times faster than MUMPS, for 100 MB a rank
/// at the most (docs/performance.md). Beyond, no rank holds more than its piece.
constexpr PetscInt kMostRepeatedNodes = 200000;

/// Ratio 12 EI / (kGA h^2) of bending to shear stiffness.
double shear_ratio(const BeamElement& element) {
  return 12.0 * element.shear_compliance / (element.flexural_compliance * element.length * element.length);
}

}  // namespace

/// The symmetric contribution of an element to the unknowns (a_left, b_left, a_right, b_right).
std::array<std::array<double, 4>, 4> FilteredLine::element_matrix(const ElementTerms& e) const {
  if (parameters_.formulation == Formulation::mixed) {
    const double t = e.inverse_length;
    const double pull = beam_->parameters().tension * t;
    return {
        {{pull, -t, -pull, t}, {-t, e.diagonal, t, e.coupling}, {-pull, t, pull, -t}, {t, e.coupling, -t, e.diagonal}}};
  }
  return {{{e.side, e.cross, -e.side, e.cross},
           {e.cross, e.diagonal, -e.cross, e.coupling},
           {-e.side, -e.cross, e.side, -e.cross},
           {e.cross, e.coupling, -e.cross, e.diagonal}}};
}

FilteredLine::ElementTerms FilteredLine::element_terms(PetscInt number) const {
  const BeamElement element = beam_->element(number);
  const double h = element.length;
  ElementTerms terms{.inverse_length = 1.0 / h};
  if (parameters_.formulation == Formulation::mixed) {
    const double bend = h * element.flexural_compliance / 6.0;
    const double shear = element.shear_compliance / h;
    terms.diagonal = -(2.0 * bend + shear);
    terms.coupling = -(bend - shear);
  } else {
    const double ratio = shear_ratio(element);
    const double base = 1.0 / (element.flexural_compliance * h * h * h * (1.0 + ratio));
    terms.side = 12.0 * base + beam_->parameters().tension / h;
    terms.cross = 6.0 * h * base;
    terms.diagonal = (4.0 + ratio) * h * h * base;
    terms.coupling = (2.0 - ratio) * h * h * base;
  }
  return terms;
}

FilteredLine::NodeTerms FilteredLine::node_terms(PetscInt node) const {
  NodeTerms terms{.diagonal = {wf2_ * beam_->mass(node) + beam_->ground_stiffness(node), 0.0},
                  .present = {!beam_->held(node), true}};
  if (node == 0 || node == beam_->elements()) {
    const BeamEnd& end = beam_->end_at(node);
    if (parameters_.formulation == Formulation::mixed) {
      terms.present[1] = !end.moment_free();
      terms.diagonal[1] = end.moment_free() ? 0.0 : -1.0 / end.rotational_stiffness;
    } else {
      terms.present[1] = end.rotational_stiffness != BeamEnd::kRigid;
      terms.diagonal[1] = terms.present[1] ? end.rotational_stiffness : 0.0;
    }
  }
  return terms;
}

FilteredLine::FilteredLine(const BeamChain& beam, FilterParameters parameters)
    : beam_{&beam}, parameters_{parameters}, wf2_{parameters.filter_frequency * parameters.filter_frequency} {
  if (!(parameters_.filter_frequency > 0.0) || !std::isfinite(parameters_.filter_frequency)) {
    throw InputError{"option -filter_frequency: " + std::to_string(parameters_.filter_frequency) +
                     " is not allowed, expected a number > 0 [rad/s]"};
  }
  const petsc::LogScope scope{petsc::log_events().assemble};
  collect_terms();
  assemble();
  configure_solver();
}

/// Where `elements_` keeps an element that touches a local node.
std::size_t FilteredLine::slot(PetscInt element) const {
  const PetscInt index = element + 1 - beam_->begin();
  return static_cast<std::size_t>(index);
}

void FilteredLine::collect_terms() {
  const BeamChain& beam = *beam_;
  const auto count = static_cast<std::size_t>(beam.local_nodes());
  elements_.resize(count + 1);
  for (PetscInt element = std::max<PetscInt>(beam.begin() - 1, 0); element < std::min(beam.end(), beam.elements());
       ++element) {
    elements_[slot(element)] = element_terms(element);
  }
  for (PetscInt node = beam.begin(); node < beam.end(); ++node) {
    const NodeTerms terms = node_terms(node);
    mass_.push_back(beam.mass(node));
    springs_.push_back(terms.diagonal[0]);
    for (std::size_t a = 0; a < 2; ++a) {
      scale_.push_back(terms.present[a] ? scale(node, a) : 0.0);
      const auto index = scale_.size() - 1;
      if (!terms.present[a]) {
        end_terms_.push_back({.index = index, .value = 1.0});
      } else if (a == 1 && terms.diagonal[a] != 0.0) {
        end_terms_.push_back({.index = index, .value = terms.diagonal[a] * scale_[index] * scale_[index]});
      }
    }
  }
}

/// The factor of one unknown, on any rank. Powers of two: scaled entries keep their digits.
double FilteredLine::scale(PetscInt node, std::size_t a) const {
  double diagonal = node_terms(node).diagonal[a];
  if (node > 0) {
    diagonal += element_matrix(element_terms(node - 1))[a + 2][a + 2];
  }
  if (node < beam_->elements()) {
    diagonal += element_matrix(element_terms(node))[a][a];
  }
  return std::exp2(-std::round(0.5 * std::log2(std::abs(diagonal))));
}

void FilteredLine::assemble() {
  const BeamChain& beam = *beam_;
  const auto size = 2 * beam.local_nodes();
  std::vector<PetscInt> rows;
  std::vector<PetscInt> columns;
  std::vector<double> values;
  const auto add = [&](PetscInt row, PetscInt column, double value) {
    rows.push_back(row);
    columns.push_back(column);
    values.push_back(value);
  };
  const auto own_scale = [&](PetscInt node, std::size_t a) {
    return scale_[static_cast<std::size_t>(2 * (node - beam.begin())) + a];
  };
  const auto any_scale = [&](PetscInt node, std::size_t a) {
    if (node >= beam.begin() && node < beam.end()) {
      return own_scale(node, a);
    }
    return node_terms(node).present[a] ? scale(node, a) : 0.0;
  };
  for (PetscInt node = beam.begin(); node < beam.end(); ++node) {
    const auto i = static_cast<std::size_t>(node - beam.begin());
    add(2 * node, 2 * node, springs_[i] * own_scale(node, 0) * own_scale(node, 0));
    for (const PetscInt element : {node - 1, node}) {
      if (element < 0 || element == beam.elements()) {
        continue;
      }
      const auto matrix = element_matrix(elements_[slot(element)]);
      const std::size_t own = element == node ? 0 : 2;
      for (std::size_t a = 0; a < 2; ++a) {
        for (std::size_t b = 0; b < 4; ++b) {
          const PetscInt other = element + (b < 2 ? 0 : 1);
          add(2 * node + static_cast<PetscInt>(a), 2 * other + static_cast<PetscInt>(b % 2),
              matrix[own + a][b] * own_scale(node, a) * any_scale(other, b % 2));
        }
      }
    }
  }
  for (const EndTerm& end : end_terms_) {
    const PetscInt row = 2 * beam.begin() + static_cast<PetscInt>(end.index);
    add(row, row, end.value);
  }

  UDAR_CALL(MatCreate(beam.comm(), matrix_.put()));
  UDAR_CALL(PetscObjectSetName(reinterpret_cast<PetscObject>(static_cast<Mat>(matrix_)), "filtered_line"));
  UDAR_CALL(MatSetOptionsPrefix(matrix_, "filter_"));
  UDAR_CALL(MatSetSizes(matrix_, size, size, PETSC_DETERMINE, PETSC_DETERMINE));
  UDAR_CALL(MatSetBlockSize(matrix_, 2));
  UDAR_CALL(MatSetType(matrix_, MATBAIJ));
  UDAR_CALL(MatSetFromOptions(matrix_));
  UDAR_CALL(MatSetPreallocationCOO(matrix_, static_cast<PetscCount>(rows.size()), rows.data(), columns.data()));
  UDAR_CALL(MatSetValuesCOO(matrix_, values.data(), ADD_VALUES));
  UDAR_CALL(MatSetOption(matrix_, MAT_SYMMETRIC, PETSC_TRUE));
  UDAR_CALL(MatNorm(matrix_, NORM_INFINITY, &matrix_norm_));
  UDAR_CALL(MatCreateVecs(matrix_, unknowns_.put(), right_hand_side_.put()));

  UDAR_CALL(MatCreateShell(beam.comm(), size, size, 2 * beam.nodes(), 2 * beam.nodes(), this, operator_.put()));
  UDAR_CALL(MatShellSetOperation(operator_, MATOP_MULT, reinterpret_cast<void (*)()>(multiply_callback)));
}

PetscErrorCode FilteredLine::multiply_callback(Mat matrix, Vec unknowns, Vec product) {
  PetscFunctionBeginUser;
  FilteredLine* self = nullptr;
  const double* from = nullptr;
  double* to = nullptr;
  PetscCall(MatShellGetContext(matrix, static_cast<void*>(&self)));
  PetscCall(VecGetArrayRead(unknowns, &from));
  PetscCall(VecGetArray(product, &to));
  self->multiply({from, self->scale_.size()}, {to, self->scale_.size()});
  PetscCall(VecRestoreArray(product, &to));
  PetscCall(VecRestoreArrayRead(unknowns, &from));
  PetscFunctionReturn(0);
}

void FilteredLine::configure_solver() {
  UDAR_CALL(KSPCreate(beam_->comm(), solver_.put()));
  UDAR_CALL(KSPSetOptionsPrefix(solver_, "filter_"));
  UDAR_CALL(KSPSetOperators(solver_, operator_, matrix_));
  PC preconditioner = nullptr;
  UDAR_CALL(KSPGetPC(solver_, &preconditioner));
  int size = 1;
  MPI_Comm_size(beam_->comm(), &size);
  PC factorisation = preconditioner;
  if (size > 1 && beam_->nodes() <= kMostRepeatedNodes) {
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
  PetscBool other_type = PETSC_FALSE;
  UDAR_CALL(PetscOptionsHasName(nullptr, "filter_", "-ksp_type", &other_type));
  if (other_type == PETSC_FALSE) {
    // A direct solve and one step of iterative refinement: two Richardson iterations from zero.
    UDAR_CALL(KSPSetType(solver_, KSPRICHARDSON));
    UDAR_CALL(KSPSetNormType(solver_, KSP_NORM_NONE));
    UDAR_CALL(KSPSetTolerances(solver_, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT, 2));
  } else {
    // 1e-12: what an iterative solver can reach here and the time integration does not notice.
    UDAR_CALL(KSPSetTolerances(solver_, 1e-12, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
  }
  UDAR_CALL(KSPSetFromOptions(solver_));
  UDAR_CALL(KSPSetUp(solver_));
}

void FilteredLine::multiply(std::span<const double> unknowns, std::span<double> product) const {
  const BeamChain& beam = *beam_;
  const auto count = static_cast<std::size_t>(beam.local_nodes());
  const bool mixed = parameters_.formulation == Formulation::mixed;
  using Pair = std::array<double, 2>;
  // Physical values of node i; the scale of an unknown that is not there is zero.
  const auto values = [&](std::size_t i) {
    return Pair{unknowns[2 * i] * scale_[2 * i], unknowns[2 * i + 1] * scale_[2 * i + 1]};
  };
  const Pair first = values(0);
  const auto halo = beam.exchange(first, values(count - 1));

  // What an element gives to the rows of its two nodes. Differences come first: they are exact, so that rigid motions
  // give nothing, which the assembled entries cannot promise.
  const auto apply = [&](const ElementTerms& e, const Pair& a, const Pair& b, Pair& to_a, Pair& to_b) {
    if (mixed) {
      const double slope = (b[0] - a[0]) * e.inverse_length;
      const double shear = (b[1] - a[1]) * e.inverse_length - beam.parameters().tension * slope;
      to_a = {shear, slope + e.diagonal * a[1] + e.coupling * b[1]};
      to_b = {-shear, -slope + e.coupling * a[1] + e.diagonal * b[1]};
    } else {
      const double rise = e.side * (a[0] - b[0]);
      const double turn = e.cross * (a[1] + b[1]);
      to_a = {rise + turn, e.cross * (a[0] - b[0]) + e.diagonal * a[1] + e.coupling * b[1]};
      to_b = {-rise - turn, e.cross * (a[0] - b[0]) + e.coupling * a[1] + e.diagonal * b[1]};
    }
  };
  Pair from_left{};
  Pair unused{};
  if (beam.begin() > 0) {
    apply(elements_[0], halo.left, first, unused, from_left);
  }
  Pair own = first;
  for (std::size_t i = 0; i < count; ++i) {
    Pair from_right{};
    Pair to_next{};
    const Pair next = i + 1 < count ? values(i + 1) : halo.right;
    if (beam.begin() + static_cast<PetscInt>(i) < beam.elements()) {
      apply(elements_[i + 1], own, next, from_right, to_next);
    }
    product[2 * i] = scale_[2 * i] * (springs_[i] * own[0] + from_left[0] + from_right[0]);
    product[2 * i + 1] = scale_[2 * i + 1] * (from_left[1] + from_right[1]);
    from_left = to_next;
    own = next;
  }
  for (const EndTerm& end : end_terms_) {
    product[end.index] += end.value * unknowns[end.index];
  }
}

void FilteredLine::mixed_right_hand_side(std::span<const double> mass_displacement, std::span<const double> force,
                                         std::span<double> values) const {
  const BeamChain& beam = *beam_;
  const auto count = static_cast<std::size_t>(beam.local_nodes());
  const double tension = beam.parameters().tension;
  const auto displacement = [&](std::size_t i) { return scale_[2 * i] != 0.0 ? mass_displacement[i] : 0.0; };
  const auto halo = beam.exchange<1>({displacement(0)}, {displacement(count - 1)});
  double slope_left =  // of the element on the left of the node, zero beyond the beam
      beam.begin() > 0 ? (displacement(0) - halo.left[0]) * elements_[0].inverse_length : 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    double slope_right = 0.0;
    if (beam.begin() + static_cast<PetscInt>(i) < beam.elements()) {
      const double next = i + 1 < count ? displacement(i + 1) : halo.right[0];
      slope_right = (next - displacement(i)) * elements_[i + 1].inverse_length;
    }
    const double bend = slope_right - slope_left;  // (T u)_i
    const double ground = springs_[i] - wf2_ * mass_[i];
    values[2 * i] = scale_[2 * i] * (force[i] - ground * displacement(i) + tension * bend);
    values[2 * i + 1] = -scale_[2 * i + 1] * bend;
    slope_left = slope_right;
  }
}

void FilteredLine::hermite_moments(std::span<const double> unknowns, std::span<double> moment) const {
  const BeamChain& beam = *beam_;
  const auto count = static_cast<std::size_t>(beam.local_nodes());
  using Pair = std::array<double, 2>;
  const auto values = [&](std::size_t i) {  // (w, theta)
    return Pair{unknowns[2 * i] * scale_[2 * i], unknowns[2 * i + 1] * scale_[2 * i + 1]};
  };
  const auto halo = beam.exchange(values(0), values(count - 1));
  for (std::size_t i = 0; i < count; ++i) {
    // At the left end of the element on the right, at the last node at the right end of the one on the left.
    const PetscInt node = beam.begin() + static_cast<PetscInt>(i);
    const bool last = node == beam.elements();
    const BeamElement element = beam.element(last ? node - 1 : node);
    const double h = element.length;
    const double ratio = shear_ratio(element);
    const double factor = 1.0 / (element.flexural_compliance * h * h * (1.0 + ratio));
    const Pair own = values(i);
    const Pair other = last ? (i > 0 ? values(i - 1) : halo.left) : (i + 1 < count ? values(i + 1) : halo.right);
    const double turn = h * ((4.0 + ratio) * own[1] + (2.0 - ratio) * other[1]);
    moment[i] = factor * (6.0 * (other[0] - own[0]) + (last ? turn : -turn));
  }
}

void FilteredLine::solve(std::span<const double> mass_displacement, std::span<const double> force,
                         std::span<double> stretch, std::span<double> moment) {
  const petsc::LogScope scope{petsc::log_events().solve};
  const auto count = static_cast<std::size_t>(beam_->local_nodes());
  double* values = nullptr;
  UDAR_CALL(VecGetArrayWrite(right_hand_side_, &values));
  if (parameters_.formulation == Formulation::mixed) {
    mixed_right_hand_side(mass_displacement, force, {values, 2 * count});
  } else {
    for (std::size_t i = 0; i < count; ++i) {
      values[2 * i] = scale_[2 * i] * (wf2_ * mass_[i] * mass_displacement[i] + force[i]);
      values[2 * i + 1] = 0.0;
    }
  }
  UDAR_CALL(VecRestoreArrayWrite(right_hand_side_, &values));

  UDAR_CALL(KSPSolve(solver_, right_hand_side_, unknowns_));
  ++solves_;
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  UDAR_CALL(KSPGetConvergedReason(solver_, &reason));
  if (reason <= 0) {
    PetscInt iterations = 0;
    UDAR_CALL(KSPGetIterationNumber(solver_, &iterations));
    throw SolveError{std::string{"the line solve did not converge: "} + KSPConvergedReasons[reason] + " after " +
                     std::to_string(iterations) + " iterations (see -filter_ksp_monitor, -filter_ksp_view)"};
  }
  if (parameters_.check_interval > 0 && (solves_ - 1) % parameters_.check_interval == 0) {
    check_residual();
  }

  const double* solution = nullptr;
  UDAR_CALL(VecGetArrayRead(unknowns_, &solution));
  const bool mixed = parameters_.formulation == Formulation::mixed;
  if (mixed) {
    for (std::size_t i = 0; i < count; ++i) {
      stretch[i] = scale_[2 * i] * solution[2 * i];
      moment[i] = scale_[2 * i + 1] * solution[2 * i + 1];
    }
  } else {
    for (std::size_t i = 0; i < count; ++i) {
      stretch[i] = scale_[2 * i] * solution[2 * i] - mass_displacement[i];
    }
    hermite_moments({solution, 2 * count}, moment);
  }
  UDAR_CALL(VecRestoreArrayRead(unknowns_, &solution));
  for (const PetscInt node : {PetscInt{0}, beam_->elements()}) {
    if (beam_->held(node) && node >= beam_->begin() && node < beam_->end()) {
      const auto i = static_cast<std::size_t>(node - beam_->begin());
      stretch[i] = -mass_displacement[i];
    }
  }
}

void FilteredLine::check_residual() {
  if (residual_ == nullptr) {
    UDAR_CALL(VecDuplicate(right_hand_side_, residual_.put()));
  }
  double residual = 0.0;
  double solution = 0.0;
  double given = 0.0;
  UDAR_CALL(MatMult(operator_, unknowns_, residual_));
  UDAR_CALL(VecAYPX(residual_, -1.0, right_hand_side_));
  UDAR_CALL(VecNorm(residual_, NORM_INFINITY, &residual));
  UDAR_CALL(VecNorm(unknowns_, NORM_INFINITY, &solution));
  UDAR_CALL(VecNorm(right_hand_side_, NORM_INFINITY, &given));
  const double bound = matrix_norm_ * solution + given;
  const double error = bound > 0.0 ? residual / bound : 0.0;
  if (!(error <= parameters_.residual_tolerance)) {
    throw SolveError{"the line solve is wrong: backward error " + std::to_string(error) +
                     " exceeds -filter_residual_tolerance " + std::to_string(parameters_.residual_tolerance) +
                     " although the solver reported success (see -filter_ksp_view)"};
  }
  worst_residual_ = std::max(worst_residual_, error);
}

double FilteredLine::strain_energy(std::span<const double> line_displacement, std::span<const double> moment) const {
  const BeamChain& beam = *beam_;
  const auto count = static_cast<std::size_t>(beam.local_nodes());
  const double tension = beam.parameters().tension;
  const auto [next_line, next_moment] =
      beam.exchange<2>({line_displacement[0], moment[0]}, {line_displacement[count - 1], moment[count - 1]}).right;
  double energy = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const PetscInt node = beam.begin() + static_cast<PetscInt>(i);
    const double w = line_displacement[i];
    energy += 0.5 * beam.ground_stiffness(node) * w * w;
    if (node < beam.elements()) {
      const BeamElement element = beam.element(node);
      const double a = moment[i];
      const double b = i + 1 < count ? moment[i + 1] : next_moment;
      const double rise = (i + 1 < count ? line_displacement[i + 1] : next_line) - w;
      energy += element.length * element.flexural_compliance / 6.0 * (a * a + a * b + b * b) +
                0.5 * element.shear_compliance / element.length * (b - a) * (b - a) +
                0.5 * tension / element.length * rise * rise;
    }
    if ((node == 0 || node == beam.elements()) && !beam.end_at(node).moment_free()) {
      energy += 0.5 * moment[i] * moment[i] / beam.end_at(node).rotational_stiffness;
    }
  }
  return energy;
}

}  // namespace udar
