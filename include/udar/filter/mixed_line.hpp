#pragma once
/// @file
/// The line by displacement and moment.

#include "udar/filter/block_line.hpp"

namespace udar {

/// @brief Unknowns d = Yc - Ym and moment (three-moment equation): the acceleration wf^2 d of the masses suffers no
/// cancellation. Source: docs/theory.md, "The discrete line".
class MixedLine final : public BlockLine {
 public:
  /// @note Collective.
  MixedLine(const BeamChain& beam, double filter_frequency);

  void right_hand_side(const FilterColumn& column, std::span<double> values) const override;
  void extract(std::span<const double> unknowns, const FilterColumn& column) const override;
  void unknowns_of(const FilterColumn& column, std::span<double> unknowns) const override;
  /// S mu = T w, a well conditioned tridiagonal matrix; options `-filter_moment_ksp_*`.
  void internal_of(const FilterColumn& column) override;
  [[nodiscard]] std::string block_form_reason() const override;

 private:
  /// What the products need of an element; all zero of one that is not there.
  struct ElementTerms {
    double inverse_length = 0.0;
    double diagonal = 0.0;
    double coupling = 0.0;
  };
  [[nodiscard]] static ElementTerms element_terms(const BeamElement& element);
  [[nodiscard]] ElementMatrix element_matrix(const BeamElement& element) const override;
  void add_end(const BeamEnd& end, NodeTerms& terms) const override;
  void multiply(std::span<const double> unknowns, std::span<double> product) const override;
  void create_moment_solver();

  petsc::LinearSolver moment_solver_;
  petsc::Vector moment_right_;
  petsc::Vector moment_unknowns_;
};

}  // namespace udar
