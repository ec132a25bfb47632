#include "udar/filter/block_line.hpp"

#include <algorithm>
#include <cmath>

#include "udar/filter/chain_solver.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/shell_matrix.hpp"

namespace udar {

BlockLine::BlockLine(const BeamChain& beam, double filter_frequency)
    : beam_{&beam}, wf2_{filter_frequency * filter_frequency} {}

void BlockLine::build() {
  collect_terms();
  create_operator();
}

double BlockLine::spring(std::size_t i) const {
  const double ground = line_.ground_stiffness[i];
  return line_.filter_stiffness[i] + (std::isinf(ground) ? 0.0 : ground);
}

/// @param stiffness filter spring and ground [N/m]
BlockLine::NodeTerms BlockLine::node_terms(PetscInt node, double stiffness) const {
  NodeTerms terms{.diagonal = {stiffness, 0.0}, .present = {!beam_->fixed(node), true}};
  if (const BeamEnd* end = beam_->end_at(node); end != nullptr) {
    add_end(*end, terms);
  }
  return terms;
}

void BlockLine::collect_terms() {
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
std::array<double, 2> BlockLine::scales(const NodeTerms& terms, const BeamElement& left,
                                        const BeamElement& right) const {
  const ElementMatrix before = element_matrix(left);
  const ElementMatrix after = element_matrix(right);
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
void BlockLine::each_entry(const Add& add) const {
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
      const ElementMatrix matrix = element_matrix(element);
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

void BlockLine::create_operator() {
  const BeamChain& beam = *beam_;
  const auto size = 2 * beam.local_nodes();
  operator_ = petsc::symmetric_shell<&BlockLine::multiply>(beam.comm(), size, 2 * beam.nodes(), *this);
  UDAR_CALL(PetscObjectSetName(reinterpret_cast<PetscObject>(static_cast<Mat>(operator_)), "filtered_line"));
  if (line() != nullptr) {
    compose_line(operator_, line_);
  }
}

Mat BlockLine::matrix() {
  if (matrix_ != nullptr) {
    return matrix_;
  }
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
  if (line() != nullptr) {
    compose_line(matrix_, line_);
  }
  return matrix_;
}

double BlockLine::norm() const {
  std::vector<double> sums(2 * mass_.size());
  each_entry([&](PetscInt row, PetscInt /*column*/, double value) {
    sums[static_cast<std::size_t>(row - 2 * beam_->begin())] += std::abs(value);
  });
  double largest = std::ranges::max(sums);
  MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPI_DOUBLE, MPI_MAX, beam_->comm());
  return largest;
}

double BlockLine::largest_unknown(const double* displacement) const {
  double largest = 0.0;
  for (std::size_t i = 0; i < mass_.size(); ++i) {
    largest = std::max(largest, line_.scale[2 * i] != 0.0 ? std::abs(displacement[i] / line_.scale[2 * i]) : 0.0);
  }
  return largest;
}

void BlockLine::internal_values(std::span<const double> internal, std::span<double> values) const {
  std::ranges::copy(internal, values.begin());
  const std::span<double> shear = values.subspan(internal.size());
  const std::size_t count = internal.size();
  const double next = beam_->exchange<1>({internal.front()}, {internal.back()}).right[0];
  for (std::size_t i = 0; i < count; ++i) {
    const BeamElement& element = line_.elements[i + 1];
    const double right = i + 1 < count ? internal[i + 1] : next;
    shear[i] = LineData::present(element) ? (right - internal[i]) / element.length : 0.0;
  }
}

double BlockLine::strain_energy(std::span<const double> displacement, std::span<const double> internal) const {
  const BeamChain& beam = *beam_;
  const auto count = static_cast<std::size_t>(beam.local_nodes());
  const double tension = beam.parameters().tension;
  const auto [next_line, next_moment] =
      beam.exchange<2>({displacement[0], internal[0]}, {displacement[count - 1], internal[count - 1]}).right;
  double energy = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const PetscInt node = beam.begin() + static_cast<PetscInt>(i);
    const double w = displacement[i];
    energy += 0.5 * beam.ground_stiffness(node) * w * w;
    if (const BeamElement& element = line_.elements[i + 1]; LineData::present(element)) {
      const double a = internal[i];
      const double b = i + 1 < count ? internal[i + 1] : next_moment;
      const double rise = (i + 1 < count ? displacement[i + 1] : next_line) - w;
      energy += element.length * element.flexural_compliance / 6.0 * (a * a + a * b + b * b) +
                0.5 * element.shear_compliance / element.length * (b - a) * (b - a) +
                0.5 * tension / element.length * rise * rise;
    }
    if (const BeamEnd* end = beam.end_at(node); end != nullptr && !end->moment_free()) {
      energy += 0.5 * internal[i] * internal[i] / end->rotational_stiffness;
    }
  }
  return energy;
}

std::unique_ptr<ColumnSolver> BlockLine::with_springs(std::span<const ContactSpring> springs) const {
  if (line() == nullptr) {
    throw InputError{"springs at contact nodes need the chain solver, and this line has none (" + block_form_reason() +
                     ")"};
  }
  LineData sprung = line_;
  const std::size_t count = mass_.size();
  std::size_t last = count;
  for (const auto& [node, stiffness] : springs) {
    if (node != last) {
      sprung.ground_stiffness[node] += line_.filter_stiffness[node];
      sprung.filter_stiffness[node] = 0.0;
    }
    sprung.filter_stiffness[node] += stiffness;
    last = node;
  }
  const std::size_t end = count - 1;
  const auto halo = beam_->exchange<2>({sprung.filter_stiffness.front(), sprung.ground_stiffness.front()},
                                       {sprung.filter_stiffness[end], sprung.ground_stiffness[end]});
  if (sprung.filter_stiffness.size() > count) {
    sprung.filter_stiffness.back() = halo.right[0];
    sprung.ground_stiffness.back() = halo.right[1];
  }
  return std::make_unique<ChainSolver>(sprung);
}

double BlockLine::points_moved_together(std::size_t point) const {
  double together = 1.0;
  for (const std::size_t side : {point, point + 1}) {
    const BeamElement& element = line_.elements[side];
    if (LineData::present(element)) {
      const double ratio =
          4.0 / (element.flexural_compliance * line_.filter_stiffness[point] * std::pow(element.length, 3));
      together = std::max(together, std::sqrt(std::sqrt(ratio)));
    }
  }
  return together;
}

}  // namespace udar
