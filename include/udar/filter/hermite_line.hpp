#pragma once
/// @file
/// The line by displacement and rotation.

#include "udar/filter/block_line.hpp"
#include "udar/structure/beam_matrices.hpp"

namespace udar {

/// @brief Unknowns Yc and its rotation, by the usual beam elements: for comparison, it loses digits on fine meshes.
class HermiteLine final : public BlockLine {
 public:
  /// @note Collective.
  HermiteLine(const BeamChain& beam, double filter_frequency);

  void right_hand_side(const FilterColumn& column, std::span<double> values) const override;
  void extract(std::span<const double> unknowns, const FilterColumn& column) const override;
  void unknowns_of(const FilterColumn& column, std::span<double> unknowns) const override;
  void internal_of(const FilterColumn& column) override;
  [[nodiscard]] std::string block_form_reason() const override { return "Hermite form"; }

 private:
  [[nodiscard]] ElementMatrix element_matrix(const BeamElement& element) const override;
  void add_end(const BeamEnd& end, NodeTerms& terms) const override;
  void multiply(std::span<const double> unknowns, std::span<double> product) const override;
  void moments(std::span<const double> unknowns, std::span<double> moment) const;
};

}  // namespace udar
