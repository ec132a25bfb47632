#pragma once
/// @file
/// What both forms of the bending line share: two unknowns per node of a chain.

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "udar/filter/bending_fields.hpp"
#include "udar/filter/operator.hpp"
#include "udar/petsc/handle.hpp"
#include "udar/structure/beam_chain.hpp"

namespace udar {

/// @brief The massless line of a beam on its filter springs: a displacement and one more unknown per node, scaled on
/// both sides. Matrices of its elements are what a form adds. Source: docs/theory.md, "The discrete line".
class BlockLine : public FilterOperator {
 public:
  [[nodiscard]] MPI_Comm comm() const override { return beam_->comm(); }
  [[nodiscard]] std::span<const double> mass() const override { return mass_; }
  [[nodiscard]] std::size_t unknowns() const override { return 2 * mass_.size(); }
  [[nodiscard]] Mat op() const override { return operator_; }
  [[nodiscard]] Mat matrix() override;
  [[nodiscard]] double norm() const override;
  [[nodiscard]] double largest_unknown(const double* displacement) const override;
  [[nodiscard]] std::size_t internal_numbers() const override { return 1; }  // the moment
  [[nodiscard]] std::span<const FieldInfo> internal_fields() const override { return kBendingFields; }
  void internal_values(std::span<const double> internal, std::span<double> values) const override;
  [[nodiscard]] double strain_energy(std::span<const double> displacement,
                                     std::span<const double> internal) const override;
  [[nodiscard]] const LineData* line() const override { return block_form_reason().empty() ? &line_ : nullptr; }
  [[nodiscard]] bool definite() const override { return false; }  // repeated LU in natural order is faster for a chain
  [[nodiscard]] std::unique_ptr<ColumnSolver> with_springs(std::span<const ContactSpring> springs) const override;
  [[nodiscard]] double points_moved_together(std::size_t point) const override;

 protected:
  /// Of an element, for the unknowns (displacement, other) at its left and right end.
  using ElementMatrix = std::array<std::array<double, 4>, 4>;
  /// Values (displacement, other) of a node.
  using Pair = std::array<double, 2>;
  /// What a node adds to the diagonal, and which of its two unknowns there are.
  struct NodeTerms {
    std::array<double, 2> diagonal;
    std::array<bool, 2> present;
  };

  BlockLine(const BeamChain& beam, double filter_frequency);
  /// Collects terms and creates the product: what the constructor cannot do before the form is there.
  void build();

  [[nodiscard]] virtual ElementMatrix element_matrix(const BeamElement& element) const = 0;
  /// Unknown and diagonal of an end's rotational spring. @param stiffness of it [N m/rad]
  virtual void add_end(const BeamEnd& end, NodeTerms& terms) const = 0;
  /// The product, see `multiply_by`.
  virtual void multiply(std::span<const double> unknowns, std::span<double> product) const = 0;
  /// @param apply what an element gives to the rows of its two nodes: (element, left, right, to left, to right)
  template <class Apply>
  void multiply_by(std::span<const double> unknowns, std::span<double> product, const Apply& apply) const;

  [[nodiscard]] const BeamChain& beam() const noexcept { return *beam_; }
  [[nodiscard]] const LineData& terms() const noexcept { return line_; }
  /// Filter spring, foundation and end spring of a local node [N/m].
  [[nodiscard]] double spring(std::size_t i) const;
  /// Physical values of a local node; zero for an unknown that is not there.
  [[nodiscard]] Pair values_at(std::span<const double> unknowns, std::size_t i) const {
    return {unknowns[2 * i] * line_.scale[2 * i], unknowns[2 * i + 1] * line_.scale[2 * i + 1]};
  }

 private:
  /// An entry that only an end of a beam has: of an elastic rotation, or 1 for an unknown that is not there.
  struct EndTerm {
    std::size_t index;
    double value;  // scaled
  };

  [[nodiscard]] NodeTerms node_terms(PetscInt node, double stiffness) const;
  [[nodiscard]] std::array<double, 2> scales(const NodeTerms& terms, const BeamElement& left,
                                             const BeamElement& right) const;
  void collect_terms();
  void create_operator();
  template <class Add>
  void each_entry(const Add& add) const;

  const BeamChain* beam_;
  double wf2_;
  LineData line_;
  std::vector<double> mass_;
  std::vector<EndTerm> end_terms_;
  petsc::Matrix operator_;  // a product without rounding of rigid motions
  petsc::Matrix matrix_;    // assembled, for the preconditioners that need it
};

template <class Apply>
void BlockLine::multiply_by(std::span<const double> unknowns, std::span<double> product, const Apply& apply) const {
  const std::size_t count = mass_.size();
  const Pair first = values_at(unknowns, 0);
  const auto halo = beam_->exchange(first, values_at(unknowns, count - 1));
  Pair from_left{};
  Pair unused{};
  apply(line_.elements[0], halo.left, first, unused, from_left);
  Pair own = first;
  for (std::size_t i = 0; i < count; ++i) {
    Pair from_right{};
    Pair to_next{};
    const Pair next = i + 1 < count ? values_at(unknowns, i + 1) : halo.right;
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

}  // namespace udar
