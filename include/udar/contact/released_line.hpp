#pragma once
/// @file
/// The line while certain hinges yield.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "udar/contact/altered_line.hpp"
#include "udar/contact/hinged_line.hpp"
#include "udar/numerics/complementarity.hpp"

namespace udar {

/// @brief Answers of a line whose yielding hinges turn so that X = mu - H theta stays what it is there.
///
/// Rows are the rotation of a hinge that yields, and X of one that does not. Moments of the free line follow from the
/// masses' displacements u by reciprocity, mu_k = wf^2 g_k' M u with the response g_k to a unit rotation.
/// Source: docs/theory.md, "A beam that yields"
class ReleasedLine final : public AlteredLine {
 public:
  /// @note Collective on first demand of the hinges' rows: a line solve for each.
  ReleasedLine(FilteredStructure& line, HingedLine& hinges);

  [[nodiscard]] std::size_t points() const noexcept override { return yields_.size(); }
  [[nodiscard]] double frequency_bound() const noexcept override { return line_->frequency_bound(); }
  /// @param yields not zero: the hinge yields
  void assume(std::span<const std::int8_t> yields);
  [[nodiscard]] bool yields(std::size_t hinge) const { return yields_[hinge] != 0; }
  [[nodiscard]] bool any() const noexcept { return any_; }

  void hold(std::span<const FilterColumn> columns, std::span<double> amplitudes, std::vector<double>& rows) override;
  /// @brief Rows of values of X of the free line. @param[in,out] values
  void release(std::span<double> values);
  /// Adds what rotations of hinges do to the stretch [m].
  void turn(std::span<const double> rotations, std::span<double> stretch) const;

  /// @brief Moments of the line without rotations [N m], of displacements and forces. @param fields pairs of them, one
  /// value per local node; empty: none @param[out] moments by field, then hinge @note Collective: one reduction.
  struct Field {
    std::span<const double> displacement;
    std::span<const double> force;
  };
  void moments(std::span<const Field> fields, std::vector<double>& moments) const;
  /// X of moments without rotations, with rotations.
  void subtract(std::span<const double> rotations, std::span<double> moments) const;

 private:
  FilteredStructure* line_;
  HingedLine* hinges_;
  Complementarity problem_;
  std::vector<std::int8_t> yields_;
  bool any_ = false;
  std::vector<double> value_;  // work
  std::vector<double> turn_;
  std::vector<double> moments_;
};

/// The matrix K + H of hinges alone.
[[nodiscard]] std::vector<double> yielding_matrix(HingedLine& hinges);

}  // namespace udar
