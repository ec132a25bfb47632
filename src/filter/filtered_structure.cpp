#include "udar/filter/filtered_structure.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "udar/filter/pc_chain.hpp"
#include "udar/petsc/array.hpp"
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

}  // namespace

/// The symmetric contribution of an element to the unknowns (a_left, b_left, a_right, b_right).
std::array<std::array<double, 4>, 4> FilteredStructure::element_matrix(const ElementTerms& e) const {
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

FilteredStructure::ElementTerms FilteredStructure::element_terms(const BeamElement& element) const {
  if (!LineData::present(element)) {
    return {};
  }
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

/// @param stiffness filter spring and ground [N/m]
FilteredStructure::NodeTerms FilteredStructure::node_terms(PetscInt node, double stiffness) const {
  NodeTerms terms{.diagonal = {stiffness, 0.0}, .present = {!beam_->fixed(node), true}};
  if (const BeamEnd* end = beam_->end_at(node); end != nullptr) {
    if (parameters_.formulation == Formulation::mixed) {
      terms.present[1] = !end->moment_free();
      terms.diagonal[1] = end->moment_free() ? 0.0 : -1.0 / end->rotational_stiffness;
    } else {
      terms.present[1] = end->rotational_stiffness != BeamEnd::kRigid;
      terms.diagonal[1] = terms.present[1] ? end->rotational_stiffness : 0.0;
    }
  }
  return terms;
}

FilteredStructure::FilteredStructure(const BeamChain& beam, const FilterParameters& parameters)
    : beam_{&beam},
      parameters_{parameters},
      wf2_{parameters.filter_frequency * parameters.filter_frequency},
      frequency_bound_{parameters.filter_frequency} {
  if (!(parameters_.filter_frequency > 0.0) || !std::isfinite(parameters_.filter_frequency)) {
    throw InputError{"filter frequency: " + std::to_string(parameters_.filter_frequency) +
                     " is not allowed, expected a number > 0 [rad/s]"};
  }
  const petsc::LogScope scope{petsc::log_events().assemble};
  collect_terms();
  create_operator();
  configure_solver();
  if (parameters_.unfiltered) {
    create_moment_solver();
  }
}

std::string FilteredStructure::block_form_reason() const {
  if (parameters_.formulation == Formulation::hermite) {
    return "Hermite form";
  }
  return beam_->parameters().tension > 0.0 ? "tension" : "";
}

/// Of a local node on the line: filter spring, foundation and end spring [N/m].
double FilteredStructure::spring(std::size_t i) const {
  const double ground = line_.ground_stiffness[i];
  return line_.filter_stiffness[i] + (std::isinf(ground) ? 0.0 : ground);
}

void FilteredStructure::collect_terms() {
  const BeamChain& beam = *beam_;
  line_.comm = beam.comm();
  line_.begin = beam.begin();
  line_.end = beam.end();
  line_.nodes = beam.nodes();
  line_.left_rotation = beam.parameters().left.rotational_stiffness;
  line_.right_rotation = beam.parameters().right.rotational_stiffness;
  const auto nodes = static_cast<std::size_t>(beam.local_nodes()) + 1;
  line_.elements.reserve(nodes + 1);
  line_.filter_stiffness.reserve(nodes);
  line_.ground_stiffness.reserve(nodes);
  line_.scale.reserve(2 * nodes);
  mass_.reserve(nodes);
  for (PetscInt element = beam.begin() - 1; element <= beam.end(); ++element) {
    line_.elements.push_back(beam.element(element));
  }
  for (PetscInt node = beam.begin(); node < std::min(beam.end() + 1, beam.nodes()); ++node) {
    const double mass = beam.mass(node);
    line_.filter_stiffness.push_back(wf2_ * mass);
    line_.ground_stiffness.push_back(beam.fixed(node) ? BeamEnd::kRigid : beam.ground_stiffness(node));
    const NodeTerms terms = node_terms(node, spring(line_.filter_stiffness.size() - 1));
    const auto local = static_cast<std::size_t>(node - beam.begin());
    const std::array<double, 2> factors = scales(terms, line_.elements[local], line_.elements[local + 1]);
    for (std::size_t a = 0; a < 2; ++a) {
      const double factor = factors[a];
      line_.scale.push_back(factor);
      const auto index = line_.scale.size() - 1;
      if (node == beam.end()) {
        continue;
      }
      if (!terms.present[a]) {
        end_terms_.push_back({.index = index, .value = 1.0});
      } else if (a == 1 && terms.diagonal[a] != 0.0) {
        end_terms_.push_back({.index = index, .value = terms.diagonal[a] * factor * factor});
      }
    }
    if (node < beam.end()) {
      mass_.push_back(mass);
    }
  }
}

/// The factors of a node's unknowns. Powers of two: scaled entries keep their digits.
std::array<double, 2> FilteredStructure::scales(const NodeTerms& terms, const BeamElement& left,
                                                const BeamElement& right) const {
  const auto before = element_matrix(element_terms(left));
  const auto after = element_matrix(element_terms(right));
  std::array<double, 2> factors{};
  for (std::size_t a = 0; a < 2; ++a) {
    if (terms.present[a]) {
      const double diagonal = terms.diagonal[a] + before[a + 2][a + 2] + after[a][a];
      factors[a] = std::exp2(-std::round(0.5 * std::log2(std::abs(diagonal))));
    }
  }
  return factors;
}

/// Calls `add(row, column, value)` for every contribution to this rank's rows of the scaled matrix.
template <class Add>
void FilteredStructure::each_entry(const Add& add) const {
  const BeamChain& beam = *beam_;
  const auto scale_of = [&](PetscInt node, std::size_t a) {
    if (node >= beam.begin()) {
      return line_.scale[static_cast<std::size_t>(2 * (node - beam.begin())) + a];
    }
    const double stiffness = wf2_ * beam.mass(node) + beam.ground_stiffness(node);
    return scales(node_terms(node, stiffness), beam.element(node - 1), beam.element(node))[a];
  };
  for (PetscInt node = beam.begin(); node < beam.end(); ++node) {
    const auto i = static_cast<std::size_t>(node - beam.begin());
    add(2 * node, 2 * node, spring(i) * scale_of(node, 0) * scale_of(node, 0));
    for (const std::size_t side : {std::size_t{0}, std::size_t{1}}) {
      const BeamElement& element = line_.elements[i + side];
      if (!LineData::present(element)) {
        continue;
      }
      const auto matrix = element_matrix(element_terms(element));
      const PetscInt left = node - 1 + static_cast<PetscInt>(side);
      const std::size_t own = side == 1 ? 0 : 2;
      for (std::size_t a = 0; a < 2; ++a) {
        for (std::size_t b = 0; b < 4; ++b) {
          const PetscInt other = left + (b < 2 ? 0 : 1);
          add(2 * node + static_cast<PetscInt>(a), 2 * other + static_cast<PetscInt>(b % 2),
              matrix[own + a][b] * scale_of(node, a) * scale_of(other, b % 2));
        }
      }
    }
  }
  for (const EndTerm& end : end_terms_) {
    const PetscInt row = 2 * beam.begin() + static_cast<PetscInt>(end.index);
    add(row, row, end.value);
  }
}

void FilteredStructure::create_operator() {
  const BeamChain& beam = *beam_;
  const auto size = 2 * beam.local_nodes();
  UDAR_CALL(MatCreateShell(beam.comm(), size, size, 2 * beam.nodes(), 2 * beam.nodes(), this, operator_.put()));
  UDAR_CALL(PetscObjectSetName(reinterpret_cast<PetscObject>(static_cast<Mat>(operator_)), "filtered_line"));
  UDAR_CALL(MatShellSetOperation(operator_, MATOP_MULT, reinterpret_cast<void (*)()>(multiply_callback)));
  UDAR_CALL(MatShellSetOperation(operator_, MATOP_MULT_TRANSPOSE, reinterpret_cast<void (*)()>(multiply_callback)));
  UDAR_CALL(MatSetOption(operator_, MAT_SYMMETRIC, PETSC_TRUE));
  if (block_form_reason().empty()) {
    compose_line(operator_, line_);
  }
}

void FilteredStructure::assemble() {
  const BeamChain& beam = *beam_;
  const auto size = 2 * beam.local_nodes();
  std::vector<PetscInt> rows;
  std::vector<PetscInt> columns;
  std::vector<double> values;
  each_entry([&](PetscInt row, PetscInt column, double value) {
    rows.push_back(row);
    columns.push_back(column);
    values.push_back(value);
  });
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
  if (block_form_reason().empty()) {
    compose_line(matrix_, line_);
  }
}

Mat FilteredStructure::matrix() {
  if (matrix_ == nullptr) {
    assemble();
  }
  return matrix_;
}

PetscErrorCode FilteredStructure::multiply_callback(Mat matrix, Vec unknowns, Vec product) {
  PetscFunctionBeginUser;
  FilteredStructure* self = nullptr;
  const double* from = nullptr;
  double* to = nullptr;
  PetscCall(MatShellGetContext(matrix, static_cast<void*>(&self)));
  PetscCall(VecGetArrayRead(unknowns, &from));
  PetscCall(VecGetArray(product, &to));
  const std::size_t size = 2 * self->mass_.size();
  self->multiply({from, size}, {to, size});
  PetscCall(VecRestoreArray(product, &to));
  PetscCall(VecRestoreArrayRead(unknowns, &from));
  PetscFunctionReturn(0);
}

void FilteredStructure::configure_solver() {
  std::array<char, 64> type{};
  PetscBool given = PETSC_FALSE;
  UDAR_CALL(PetscOptionsGetString(nullptr, "filter_", "-pc_type", type.data(), type.size(), &given));
  const std::string reason = block_form_reason();
  const bool chain = given == PETSC_TRUE ? std::string{kPcChain} == type.data() : reason.empty();
  if (chain && !reason.empty()) {
    throw InputError{"filter pc type: chain cannot carry this line (" + reason + "), use lu, or leave the option out"};
  }
  UDAR_CALL(register_pc_chain());
  UDAR_CALL(KSPCreate(beam_->comm(), solver_.put()));
  UDAR_CALL(KSPSetOptionsPrefix(solver_, "filter_"));
  UDAR_CALL(KSPSetOperators(solver_, operator_, chain ? static_cast<Mat>(operator_) : matrix()));
  PC preconditioner = nullptr;
  UDAR_CALL(KSPGetPC(solver_, &preconditioner));
  if (chain) {
    UDAR_CALL(PCSetType(preconditioner, kPcChain));
    UDAR_CALL(KSPSetType(solver_, KSPPREONLY));
  } else {
    choose_factorisation(preconditioner, beam_->comm(), beam_->nodes());
    // A direct solve and one step of iterative refinement: two Richardson iterations from zero.
    UDAR_CALL(KSPSetType(solver_, KSPRICHARDSON));
  }
  PetscBool other_type = PETSC_FALSE;
  UDAR_CALL(PetscOptionsHasName(nullptr, "filter_", "-ksp_type", &other_type));
  if (other_type == PETSC_TRUE) {
    // 1e-12: what an iterative solver can reach here and the time integration does not notice.
    UDAR_CALL(KSPSetTolerances(solver_, 1e-12, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
  } else if (!chain) {
    UDAR_CALL(KSPSetNormType(solver_, KSP_NORM_NONE));
    UDAR_CALL(KSPSetTolerances(solver_, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT, 2));
  }
  UDAR_CALL(KSPSetFromOptions(solver_));
  UDAR_CALL(KSPSetUp(solver_));
  PetscBool direct = PETSC_FALSE;
  UDAR_CALL(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(static_cast<KSP>(solver_)), KSPPREONLY, &direct));
  if (direct == PETSC_TRUE) {
    chain_ = chain_solver(preconditioner);
  }
  if (chain_ != nullptr) {
    // KSPSolve, which would do this, is not on its way.
    UDAR_CALL(KSPViewFromOptions(solver_, nullptr, "-ksp_view"));
  }
}

void FilteredStructure::multiply(std::span<const double> unknowns, std::span<double> product) const {
  const BeamChain& beam = *beam_;
  const auto count = static_cast<std::size_t>(beam.local_nodes());
  const bool mixed = parameters_.formulation == Formulation::mixed;
  using Pair = std::array<double, 2>;
  // Physical values of node i; the scale of an unknown that is not there is zero.
  const auto values = [&](std::size_t i) {
    return Pair{unknowns[2 * i] * line_.scale[2 * i], unknowns[2 * i + 1] * line_.scale[2 * i + 1]};
  };
  const Pair first = values(0);
  const auto halo = beam.exchange(first, values(count - 1));

  // What an element gives to the rows of its two nodes. Differences come first: they are exact, so that rigid motions
  // give nothing, which the assembled entries cannot promise.
  const auto apply = [&](const BeamElement& element, const Pair& a, const Pair& b, Pair& to_a, Pair& to_b) {
    const ElementTerms e = element_terms(element);
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
  apply(line_.elements[0], halo.left, first, unused, from_left);
  Pair own = first;
  for (std::size_t i = 0; i < count; ++i) {
    Pair from_right{};
    Pair to_next{};
    const Pair next = i + 1 < count ? values(i + 1) : halo.right;
    apply(line_.elements[i + 1], own, next, from_right, to_next);
    product[2 * i] = line_.scale[2 * i] * (spring(i) * own[0] + from_left[0] + from_right[0]);
    product[2 * i + 1] = line_.scale[2 * i + 1] * (from_left[1] + from_right[1]);
    from_left = to_next;
    own = next;
  }
  for (const EndTerm& end : end_terms_) {
    product[end.index] += end.value * unknowns[end.index];
  }
}

void FilteredStructure::mixed_right_hand_side(const chain::Column& column, std::span<double> values) const {
  const BeamChain& beam = *beam_;
  const auto count = static_cast<std::size_t>(beam.local_nodes());
  const double tension = beam.parameters().tension;
  const auto& scale = line_.scale;
  const auto displacement = [&](std::size_t i) { return scale[2 * i] != 0.0 ? column.displacement[i] : 0.0; };
  const auto halo = beam.exchange<1>({displacement(0)}, {displacement(count - 1)});
  const auto slope = [&](std::size_t element, double left, double right) {
    return LineData::present(line_.elements[element]) ? (right - left) / line_.elements[element].length : 0.0;
  };
  double slope_left = slope(0, halo.left[0], displacement(0));  // of the element on the left of the node
  for (std::size_t i = 0; i < count; ++i) {
    const double own = displacement(i);
    const double slope_right = slope(i + 1, own, i + 1 < count ? displacement(i + 1) : halo.right[0]);
    const double bend = slope_right - slope_left;  // (T u)_i
    const double force = column.force != nullptr ? column.force[i] : 0.0;
    const double ground = spring(i) - line_.filter_stiffness[i];
    values[2 * i] = scale[2 * i] * (force - ground * own + tension * bend);
    values[2 * i + 1] = -scale[2 * i + 1] * bend;
    slope_left = slope_right;
  }
}

void FilteredStructure::hermite_moments(std::span<const double> unknowns, std::span<double> moment) const {
  const BeamChain& beam = *beam_;
  const auto count = static_cast<std::size_t>(beam.local_nodes());
  using Pair = std::array<double, 2>;
  const auto values = [&](std::size_t i) {  // (w, theta)
    return Pair{unknowns[2 * i] * line_.scale[2 * i], unknowns[2 * i + 1] * line_.scale[2 * i + 1]};
  };
  const auto halo = beam.exchange(values(0), values(count - 1));
  for (std::size_t i = 0; i < count; ++i) {
    // At the left end of the element on the right, at the last node at the right end of the one on the left.
    const bool last = !LineData::present(line_.elements[i + 1]);
    const BeamElement& element = line_.elements[last ? i : i + 1];
    const double h = element.length;
    const double ratio = shear_ratio(element);
    const double factor = 1.0 / (element.flexural_compliance * h * h * (1.0 + ratio));
    const Pair own = values(i);
    const Pair other = last ? (i > 0 ? values(i - 1) : halo.left) : (i + 1 < count ? values(i + 1) : halo.right);
    const double turn = h * ((4.0 + ratio) * own[1] + (2.0 - ratio) * other[1]);
    moment[i] = factor * (6.0 * (other[0] - own[0]) + (last ? turn : -turn));
  }
}

void FilteredStructure::solve(std::span<const double> mass_displacement, std::span<const double> force,
                              std::span<double> stretch, std::span<double> moment) {
  const chain::Column column{.displacement = mass_displacement.data(),
                             .force = force.empty() ? nullptr : force.data(),
                             .stretch = stretch.data(),
                             .moment = moment.empty() ? nullptr : moment.data()};
  solve({&column, 1});
}

void FilteredStructure::solve(std::span<const chain::Column> columns) {
  const petsc::LogScope scope{petsc::log_events().solve};
  solve_filtered(columns);
  if (!corrected_.empty()) {
    add_correction(columns);
  }
}

void FilteredStructure::correct(std::vector<CorrectedMode> modes) {
  corrected_ = std::move(modes);
  frequency_bound_ = parameters_.filter_frequency;
  for (const CorrectedMode& mode : corrected_) {
    frequency_bound_ = std::max(frequency_bound_, mode.frequency);
  }
}

/// The filtered line stretches by (f - w^2 q) / (wf^2 + w^2) in a mode; that is to be (f - w^2 q) / wf^2.
void FilteredStructure::add_correction(std::span<const chain::Column> columns) {
  const std::size_t count = mass_.size();
  const std::size_t modes = corrected_.size();
  amplitudes_.assign(columns.size() * modes, 0.0);
  for (std::size_t c = 0; c < columns.size(); ++c) {
    for (std::size_t k = 0; k < modes; ++k) {
      const double* shape = corrected_[k].shape.data();
      double sum = 0.0;
      for (std::size_t i = 0; i < count; ++i) {
        sum += mass_[i] * shape[i] * columns[c].stretch[i];
      }
      amplitudes_[c * modes + k] = sum;
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, amplitudes_.data(), static_cast<int>(amplitudes_.size()), MPI_DOUBLE, MPI_SUM,
                beam_->comm());
  for (std::size_t c = 0; c < columns.size(); ++c) {
    for (std::size_t k = 0; k < modes; ++k) {
      const double* shape = corrected_[k].shape.data();
      const double gain = corrected_[k].frequency * corrected_[k].frequency / wf2_;
      double& amplitude = amplitudes_[c * modes + k];
      for (std::size_t i = 0; i < count; ++i) {
        columns[c].stretch[i] += gain * amplitude * shape[i];
      }
      amplitude *= 1.0 + gain;
    }
    if (columns[c].moment != nullptr) {
      // Masses that are displaced by minus the amplitudes put the filtered line where it really is.
      std::vector<double> displacement(columns[c].displacement, columns[c].displacement + count);
      std::vector<double> stretch(count);
      line_stretch(amplitudes(c), displacement);
      chain::Column column = columns[c];
      column.displacement = displacement.data();
      column.stretch = stretch.data();
      solve_filtered({&column, 1});
    }
  }
}

void FilteredStructure::line_stretch(std::span<const double> amplitudes, std::span<double> stretch) const {
  for (std::size_t k = 0; k < corrected_.size(); ++k) {
    const double* shape = corrected_[k].shape.data();
    for (std::size_t i = 0; i < stretch.size(); ++i) {
      stretch[i] -= amplitudes[k] * shape[i];
    }
  }
}

void FilteredStructure::solve_filtered(std::span<const chain::Column> columns) {
  if (chain_ != nullptr) {
    return solve_by_chain(columns);
  }
  for (const chain::Column& column : columns) {
    solve_by_ksp(column);
  }
}

/// Whether the residual check falls among the next solves.
bool FilteredStructure::check_due(std::size_t solves) const {
  const PetscInt interval = parameters_.check_interval;
  return interval > 0 && (solves_ + interval - 1) % interval + static_cast<PetscInt>(solves) >= interval;
}

void FilteredStructure::solve_by_chain(std::span<const chain::Column> columns) {
  if (!check_due(columns.size())) {
    chain_->solve(columns);
    solves_ += static_cast<PetscInt>(columns.size());
    return;
  }
  // The first column's solution, with its moments, is put into the operator that the solver has never seen.
  chain::Column checked = columns.front();
  if (checked.moment == nullptr) {
    checked_moment_.resize(mass_.size());
    checked.moment = checked_moment_.data();
  }
  chain_->solve({&checked, 1});
  chain_->solve(columns.subspan(1));
  solves_ += static_cast<PetscInt>(columns.size());
  right_hand_side(checked);
  double* unknowns = nullptr;
  UDAR_CALL(VecGetArrayWrite(unknowns_, &unknowns));
  for (std::size_t i = 0; i < mass_.size(); ++i) {
    const std::array<double, 2> values{checked.stretch[i], checked.moment[i]};
    for (std::size_t a = 0; a < 2; ++a) {
      unknowns[2 * i + a] = line_.scale[2 * i + a] != 0.0 ? values[a] / line_.scale[2 * i + a] : 0.0;
    }
  }
  UDAR_CALL(VecRestoreArrayWrite(unknowns_, &unknowns));
  check_residual(checked.displacement);
  // 56 bytes per node, seldom needed.
  unknowns_.reset();
  right_hand_side_.reset();
  residual_.reset();
  checked_moment_ = {};
}

void FilteredStructure::right_hand_side(const chain::Column& column) {
  if (unknowns_ == nullptr) {
    UDAR_CALL(MatCreateVecs(operator_, unknowns_.put(), right_hand_side_.put()));
  }
  const std::size_t count = mass_.size();
  double* values = nullptr;
  UDAR_CALL(VecGetArrayWrite(right_hand_side_, &values));
  if (parameters_.formulation == Formulation::mixed) {
    mixed_right_hand_side(column, {values, 2 * count});
  } else {
    for (std::size_t i = 0; i < count; ++i) {
      const double force = column.force != nullptr ? column.force[i] : 0.0;
      values[2 * i] = line_.scale[2 * i] * (line_.filter_stiffness[i] * column.displacement[i] + force);
      values[2 * i + 1] = 0.0;
    }
  }
  UDAR_CALL(VecRestoreArrayWrite(right_hand_side_, &values));
}

void FilteredStructure::create_moment_solver() {
  if (parameters_.formulation != Formulation::mixed) {
    throw InputError{"beam formulation: `filter frequency` none needs mixed, which has the moments of a given line"};
  }
  // Every second unknown of the mixed form: -S, and 1 where a moment is known to be zero.
  petsc::Matrix pointwise;
  petsc::Matrix bending;
  petsc::IndexSet rows;
  UDAR_CALL(MatConvert(matrix(), MATAIJ, MAT_INITIAL_MATRIX, pointwise.put()));
  UDAR_CALL(ISCreateStride(beam_->comm(), beam_->local_nodes(), 2 * beam_->begin() + 1, 2, rows.put()));
  UDAR_CALL(MatCreateSubMatrix(pointwise, rows, rows, MAT_INITIAL_MATRIX, bending.put()));
  // ILU(0) of every rank's block, exact on one rank, and not ICC, which would shift a negative diagonal.
  UDAR_CALL(MatSetOption(bending, MAT_SYMMETRIC, PETSC_FALSE));
  UDAR_CALL(MatCreateVecs(bending, moment_unknowns_.put(), moment_right_.put()));
  UDAR_CALL(KSPCreate(beam_->comm(), moment_solver_.put()));
  UDAR_CALL(KSPSetOptionsPrefix(moment_solver_, "filter_moment_"));
  UDAR_CALL(KSPSetOperators(moment_solver_, bending, bending));
  UDAR_CALL(KSPSetTolerances(moment_solver_, 1e-14, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
  UDAR_CALL(KSPSetFromOptions(moment_solver_));
  UDAR_CALL(KSPSetUp(moment_solver_));
}

void FilteredStructure::moments_of(std::span<const double> line_displacement, std::span<double> moment) {
  const std::size_t count = mass_.size();
  if (moment_solver_ == nullptr) {
    create_moment_solver();
  }
  right_hand_side({.displacement = line_displacement.data()});
  {
    const petsc::ReadArray all{right_hand_side_};
    const petsc::WriteArray right{moment_right_};
    for (std::size_t i = 0; i < count; ++i) {
      right.values()[i] = all.values()[2 * i + 1];
    }
  }
  UDAR_CALL(KSPSolve(moment_solver_, moment_right_, moment_unknowns_));
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  UDAR_CALL(KSPGetConvergedReason(moment_solver_, &reason));
  if (reason <= 0) {
    throw SolveError{std::string{"the solve for bending moments did not converge: "} + KSPConvergedReasons[reason] +
                     " (see -filter_moment_ksp_monitor)"};
  }
  const petsc::ReadArray solution{moment_unknowns_};
  for (std::size_t i = 0; i < count; ++i) {
    moment[i] = solution.values()[i] * line_.scale[2 * i + 1];
  }
}

void FilteredStructure::solve_by_ksp(const chain::Column& column) {
  const std::size_t count = mass_.size();
  right_hand_side(column);
  UDAR_CALL(KSPSolve(solver_, right_hand_side_, unknowns_));
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  UDAR_CALL(KSPGetConvergedReason(solver_, &reason));
  if (reason <= 0) {
    PetscInt iterations = 0;
    UDAR_CALL(KSPGetIterationNumber(solver_, &iterations));
    throw SolveError{std::string{"the line solve did not converge: "} + KSPConvergedReasons[reason] + " after " +
                     std::to_string(iterations) + " iterations (see -filter_ksp_monitor, -filter_ksp_view)"};
  }
  const bool due = check_due(1);
  ++solves_;
  if (due) {
    check_residual(column.displacement);
  }

  const double* solution = nullptr;
  UDAR_CALL(VecGetArrayRead(unknowns_, &solution));
  const bool mixed = parameters_.formulation == Formulation::mixed;
  for (std::size_t i = 0; i < count; ++i) {
    const double scale = line_.scale[2 * i];
    column.stretch[i] = scale * solution[2 * i] - (mixed && scale != 0.0 ? 0.0 : column.displacement[i]);
    if (mixed && column.moment != nullptr) {
      column.moment[i] = line_.scale[2 * i + 1] * solution[2 * i + 1];
    }
  }
  if (!mixed && column.moment != nullptr) {
    hermite_moments({solution, 2 * count}, {column.moment, count});
  }
  UDAR_CALL(VecRestoreArrayRead(unknowns_, &solution));
}

void FilteredStructure::check_residual(const double* displacement) {
  if (residual_ == nullptr) {
    UDAR_CALL(VecDuplicate(right_hand_side_, residual_.put()));
  }
  if (matrix_norm_ == 0.0) {
    std::vector<double> sums(2 * mass_.size());
    each_entry([&](PetscInt row, PetscInt /*column*/, double value) {
      sums[static_cast<std::size_t>(row - 2 * beam_->begin())] += std::abs(value);
    });
    matrix_norm_ = std::ranges::max(sums);
    MPI_Allreduce(MPI_IN_PLACE, &matrix_norm_, 1, MPI_DOUBLE, MPI_MAX, beam_->comm());
  }
  double residual = 0.0;
  double solution = 0.0;
  double given = 0.0;
  UDAR_CALL(MatMult(operator_, unknowns_, residual_));
  UDAR_CALL(VecAYPX(residual_, -1.0, right_hand_side_));
  UDAR_CALL(VecNorm(residual_, NORM_INFINITY, &residual));
  UDAR_CALL(VecNorm(unknowns_, NORM_INFINITY, &solution));
  UDAR_CALL(VecNorm(right_hand_side_, NORM_INFINITY, &given));
  double offset = 0.0;
  for (std::size_t i = 0; i < mass_.size(); ++i) {
    offset = std::max(offset, line_.scale[2 * i] != 0.0 ? std::abs(displacement[i] / line_.scale[2 * i]) : 0.0);
  }
  MPI_Allreduce(MPI_IN_PLACE, &offset, 1, MPI_DOUBLE, MPI_MAX, beam_->comm());
  // A rigid motion has no right-hand side but the rounding of the positions: that much residual says nothing.
  constexpr double kRounding = 64.0 * std::numeric_limits<double>::epsilon();
  const double bound = matrix_norm_ * solution + given;
  const double meaning = std::max(0.0, residual - kRounding * matrix_norm_ * offset);
  const double error = bound > 0.0 ? meaning / bound : 0.0;
  if (!(error <= parameters_.residual_tolerance)) {
    throw SolveError{"the line solve is wrong: backward error " + std::to_string(error) +
                     " exceeds `filter residual tolerance` " + std::to_string(parameters_.residual_tolerance) +
                     " although the solver reported success (see -filter_ksp_view)"};
  }
  worst_residual_ = std::max(worst_residual_, error);
}

double FilteredStructure::strain_energy(std::span<const double> line_displacement,
                                        std::span<const double> moment) const {
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
    if (const BeamElement& element = line_.elements[i + 1]; LineData::present(element)) {
      const double a = moment[i];
      const double b = i + 1 < count ? moment[i + 1] : next_moment;
      const double rise = (i + 1 < count ? line_displacement[i + 1] : next_line) - w;
      energy += element.length * element.flexural_compliance / 6.0 * (a * a + a * b + b * b) +
                0.5 * element.shear_compliance / element.length * (b - a) * (b - a) +
                0.5 * tension / element.length * rise * rise;
    }
    if (const BeamEnd* end = beam.end_at(node); end != nullptr && !end->moment_free()) {
      energy += 0.5 * moment[i] * moment[i] / end->rotational_stiffness;
    }
  }
  return energy;
}

void FilteredStructure::shear(std::span<const double> moment, std::span<double> shear) const {
  const std::size_t count = moment.size();
  const double next = beam_->exchange<1>({moment.front()}, {moment.back()}).right[0];
  for (std::size_t i = 0; i < count; ++i) {
    const BeamElement& element = line_.elements[i + 1];
    const double right = i + 1 < count ? moment[i + 1] : next;
    shear[i] = LineData::present(element) ? (right - moment[i]) / element.length : 0.0;
  }
}

}  // namespace udar
