#include "udar/filter/filtered_line.hpp"

#include <array>
#include <cmath>
#include <string>

#include "udar/petsc/error.hpp"
#include "udar/petsc/options.hpp"
#include "udar/petsc/session.hpp"

namespace udar {
namespace {

/// Up to this many nodes every rank factors the whole line itself, at most some 10 MB: twenty times faster than MUMPS,
/// whose latency dominates there (docs/performance.md). Beyond, no rank holds more than its piece.
constexpr PetscInt kMostRepeatedNodes = 20000;

/// Symmetric contribution of one element to the unknowns (a_left, b_left, a_right, b_right).
using ElementMatrix = std::array<std::array<double, 4>, 4>;

ElementMatrix mixed_element(const BeamElement& element, double tension) {
  const double h = element.length;
  const double bend = h * element.flexural_compliance / 6.0;
  const double shear = element.shear_compliance / h;
  const double pull = tension / h;
  const double diagonal = -(2.0 * bend + shear);
  const double coupling = -(bend - shear);
  return {{{pull, -1.0 / h, -pull, 1.0 / h},
           {-1.0 / h, diagonal, 1.0 / h, coupling},
           {-pull, 1.0 / h, pull, -1.0 / h},
           {1.0 / h, coupling, -1.0 / h, diagonal}}};
}

/// Ratio 12 EI / (kGA h^2) of bending to shear stiffness.
double shear_ratio(const BeamElement& element) {
  return 12.0 * element.shear_compliance / (element.flexural_compliance * element.length * element.length);
}

ElementMatrix hermite_element(const BeamElement& element, double tension) {
  const double h = element.length;
  const double ratio = shear_ratio(element);
  const double base = 1.0 / (element.flexural_compliance * h * h * h * (1.0 + ratio));
  const double pull = tension / h;
  const double near = (4.0 + ratio) * h * h * base;
  const double far = (2.0 - ratio) * h * h * base;
  const double cross = 6.0 * h * base;
  const double side = 12.0 * base + pull;
  return {{{side, cross, -side, cross}, {cross, near, -cross, far}, {-side, -cross, side, -cross}, {cross, far, -cross, near}}};
}

/// What a node adds to the diagonal, and which of its two unknowns are free.
struct NodeTerms {
  std::array<double, 2> diagonal{};
  std::array<bool, 2> active{true, true};
};

NodeTerms node_terms(const BeamChain& beam, PetscInt node, const FilterParameters& parameters) {
  const double spring = parameters.filter_frequency * parameters.filter_frequency * beam.mass(node);
  NodeTerms terms{.diagonal = {spring + beam.ground_stiffness(node), 0.0}, .active = {!beam.held(node), true}};
  if (node == 0 || node == beam.elements()) {
    const BeamEnd& end = beam.end_at(node);
    if (parameters.formulation == Formulation::mixed) {
      terms.active[1] = !end.moment_free();
      terms.diagonal[1] = end.moment_free() ? 0.0 : -1.0 / end.rotational_stiffness;
    } else {
      terms.active[1] = end.rotational_stiffness != BeamEnd::kRigid;
      terms.diagonal[1] = terms.active[1] ? end.rotational_stiffness : 0.0;
    }
  }
  return terms;
}

}  // namespace

FilteredLine::FilteredLine(const BeamChain& beam, FilterParameters parameters) : beam_{&beam}, parameters_{parameters} {
  if (!(parameters_.filter_frequency > 0.0) || !std::isfinite(parameters_.filter_frequency)) {
    throw InputError{"option -filter_frequency: " + std::to_string(parameters_.filter_frequency) +
                     " is not allowed, expected a number > 0 [rad/s]"};
  }
  const petsc::LogScope scope{petsc::log_events().assemble};
  mass_.reserve(static_cast<std::size_t>(beam.local_nodes()));
  for (PetscInt node = beam.begin(); node < beam.end(); ++node) {
    mass_.push_back(beam.mass(node));
  }
  assemble();
  configure_solver();
}

void FilteredLine::assemble() {
  const BeamChain& beam = *beam_;
  const auto element_matrix = [&](PetscInt element) {
    return parameters_.formulation == Formulation::mixed
               ? mixed_element(beam.element(element), beam.parameters().tension)
               : hermite_element(beam.element(element), beam.parameters().tension);
  };
  const auto diagonal = [&](PetscInt node, std::size_t a) {
    double value = node_terms(beam, node, parameters_).diagonal[a];
    if (node > 0) {
      value += element_matrix(node - 1)[a + 2][a + 2];
    }
    if (node < beam.elements()) {
      value += element_matrix(node)[a][a];
    }
    return value;
  };
  const auto scale = [&](PetscInt node, std::size_t a) { return 1.0 / std::sqrt(std::abs(diagonal(node, a))); };

  const auto size = 2 * beam.local_nodes();
  scale_.reserve(static_cast<std::size_t>(size));
  std::vector<PetscInt> rows;
  std::vector<PetscInt> columns;
  std::vector<double> values;
  for (PetscInt node = beam.begin(); node < beam.end(); ++node) {
    const std::array<double, 2> own_scale{scale(node, 0), scale(node, 1)};
    scale_.insert(scale_.end(), own_scale.begin(), own_scale.end());
    const NodeTerms own = node_terms(beam, node, parameters_);
    for (PetscInt other = std::max<PetscInt>(node - 1, 0); other <= std::min(node + 1, beam.elements()); ++other) {
      const NodeTerms theirs = node_terms(beam, other, parameters_);
      for (std::size_t a = 0; a < 2; ++a) {
        for (std::size_t b = 0; b < 2; ++b) {
          double value = 0.0;
          if (node == other && a == b) {
            value = diagonal(node, a);
          } else if (own.active[a] && theirs.active[b]) {
            if (node == other) {
              value = (node > 0 ? element_matrix(node - 1)[a + 2][b + 2] : 0.0) +
                      (node < beam.elements() ? element_matrix(node)[a][b] : 0.0);
            } else {
              value = other > node ? element_matrix(node)[a][b + 2] : element_matrix(other)[a + 2][b];
            }
          }
          rows.push_back(2 * node + static_cast<PetscInt>(a));
          columns.push_back(2 * other + static_cast<PetscInt>(b));
          values.push_back(value * own_scale[a] * scale(other, b));
        }
      }
    }
  }

  UDAR_CALL(MatCreate(beam.comm(), matrix_.put()));
  UDAR_CALL(PetscObjectSetName(reinterpret_cast<PetscObject>(static_cast<Mat>(matrix_)), "filtered_line"));
  UDAR_CALL(MatSetOptionsPrefix(matrix_, "filter_"));
  UDAR_CALL(MatSetSizes(matrix_, size, size, PETSC_DETERMINE, PETSC_DETERMINE));
  UDAR_CALL(MatSetBlockSize(matrix_, 2));
  UDAR_CALL(MatSetType(matrix_, MATBAIJ));
  UDAR_CALL(MatSetFromOptions(matrix_));
  UDAR_CALL(MatSetPreallocationCOO(matrix_, static_cast<PetscCount>(rows.size()), rows.data(), columns.data()));
  UDAR_CALL(MatSetValuesCOO(matrix_, values.data(), INSERT_VALUES));
  UDAR_CALL(MatSetOption(matrix_, MAT_SYMMETRIC, PETSC_TRUE));
  UDAR_CALL(MatNorm(matrix_, NORM_INFINITY, &matrix_norm_));
  UDAR_CALL(MatCreateVecs(matrix_, unknowns_.put(), right_hand_side_.put()));
}

void FilteredLine::configure_solver() {
  UDAR_CALL(KSPCreate(beam_->comm(), solver_.put()));
  UDAR_CALL(KSPSetOptionsPrefix(solver_, "filter_"));
  UDAR_CALL(KSPSetOperators(solver_, matrix_, matrix_));
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

void FilteredLine::mixed_right_hand_side(std::span<const double> mass_displacement, std::span<const double> force,
                                         std::span<double> values) const {
  const BeamChain& beam = *beam_;
  const auto count = static_cast<std::size_t>(beam.local_nodes());
  const double tension = beam.parameters().tension;
  const auto displacement = [&](std::size_t i) {
    return beam.held(beam.begin() + static_cast<PetscInt>(i)) ? 0.0 : mass_displacement[i];
  };
  std::array<double, 2> edges{displacement(0), displacement(count - 1)};
  const BeamChain::Halo halo = beam.exchange(edges);
  double slope_left = 0.0;  // of the element on the left of the node, zero beyond the beam
  if (beam.begin() > 0) {
    slope_left = (edges[0] - halo.left) / beam.element(beam.begin() - 1).length;
  }
  for (std::size_t i = 0; i < count; ++i) {
    const PetscInt node = beam.begin() + static_cast<PetscInt>(i);
    double slope_right = 0.0;
    if (node < beam.elements()) {
      const double next = i + 1 < count ? displacement(i + 1) : halo.right;
      slope_right = (next - displacement(i)) / beam.element(node).length;
    }
    const double bend = slope_right - slope_left;  // (T u)_i
    values[2 * i] =
        scale_[2 * i] * (force[i] - beam.ground_stiffness(node) * displacement(i) + tension * bend);
    values[2 * i + 1] = -scale_[2 * i + 1] * bend;
    slope_left = slope_right;
  }
  for (const PetscInt node : {PetscInt{0}, beam.elements()}) {
    if (node >= beam.begin() && node < beam.end()) {
      const auto i = static_cast<std::size_t>(node - beam.begin());
      const NodeTerms terms = node_terms(beam, node, parameters_);
      values[2 * i] = terms.active[0] ? values[2 * i] : 0.0;
      values[2 * i + 1] = terms.active[1] ? values[2 * i + 1] : 0.0;
    }
  }
}

void FilteredLine::hermite_moments(std::span<const double> unknowns, std::span<double> moment) const {
  const BeamChain& beam = *beam_;
  const auto count = static_cast<std::size_t>(beam.local_nodes());
  // (w, theta) of node i; the right neighbour's first node comes from its rank.
  const auto w = [&](std::size_t i) { return unknowns[2 * i] * scale_[2 * i]; };
  const auto theta = [&](std::size_t i) { return unknowns[2 * i + 1] * scale_[2 * i + 1]; };
  const double next_w = beam.exchange(std::array{w(0), w(count - 1)}).right;
  const double next_theta = beam.exchange(std::array{theta(0), theta(count - 1)}).right;
  for (std::size_t i = 0; i < count; ++i) {
    const PetscInt node = beam.begin() + static_cast<PetscInt>(i);
    const bool last = node == beam.elements();
    const BeamElement element = beam.element(last ? node - 1 : node);
    const double h = element.length;
    const double ratio = shear_ratio(element);
    const double factor = 1.0 / (element.flexural_compliance * h * h * (1.0 + ratio));
    const std::size_t a = last && i > 0 ? i - 1 : i;
    const double rise = a + 1 < count ? w(a + 1) - w(a) : next_w - w(a);
    const double theta_a = theta(a);
    const double theta_b = a + 1 < count ? theta(a + 1) : next_theta;
    moment[i] = last ? factor * (-6.0 * rise + h * ((2.0 - ratio) * theta_a + (4.0 + ratio) * theta_b))
                     : factor * (6.0 * rise - h * ((4.0 + ratio) * theta_a + (2.0 - ratio) * theta_b));
  }
}

void FilteredLine::solve(std::span<const double> mass_displacement, std::span<const double> force,
                         std::span<double> stretch, std::span<double> moment) {
  const petsc::LogScope scope{petsc::log_events().solve};
  const auto count = static_cast<std::size_t>(beam_->local_nodes());
  const double wf2 = parameters_.filter_frequency * parameters_.filter_frequency;
  double* values = nullptr;
  UDAR_CALL(VecGetArrayWrite(right_hand_side_, &values));
  if (parameters_.formulation == Formulation::mixed) {
    mixed_right_hand_side(mass_displacement, force, {values, 2 * count});
  } else {
    for (std::size_t i = 0; i < count; ++i) {
      const bool held = beam_->held(beam_->begin() + static_cast<PetscInt>(i));
      values[2 * i] = held ? 0.0 : scale_[2 * i] * (wf2 * mass_[i] * mass_displacement[i] + force[i]);
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
  UDAR_CALL(MatMult(matrix_, unknowns_, residual_));
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
  const double next_moment = beam.exchange(std::array{moment[0], moment[count - 1]}).right;
  const double next_line = beam.exchange(std::array{line_displacement[0], line_displacement[count - 1]}).right;
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
