#pragma once
/// @file
/// The line while the same points touch.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "udar/contact/altered_line.hpp"
#include "udar/contact/line_contact.hpp"
#include "udar/filter/filter_column.hpp"

namespace udar {

/// @brief What the line answers to masses that move while a fixed set of contact points touches: a linear map, that of
/// the free line and a correction of the rank of the set.
///
/// Its rows at the points are the force of one that touches [N], and the distance from the support of one that does not
/// [m]. Source: docs/theory.md, "Contact on the line".
class HeldLine final : public AlteredLine {
 public:
  /// @param contact few points (`dense`); its responses are kept from now on; must outlive this object
  /// @note Collective: a line solve for each point.
  explicit HeldLine(LineContact& contact);

  [[nodiscard]] LineContact& contact() const noexcept { return *contact_; }
  [[nodiscard]] std::size_t points() const noexcept override { return touches_.size(); }
  [[nodiscard]] double frequency_bound() const noexcept override { return contact_->frequency_bound(); }

  /// @param touches nonzero: the point touches
  void assume(std::span<const std::uint8_t> touches);
  [[nodiscard]] const std::vector<std::uint8_t>& touches() const noexcept { return touches_; }
  [[nodiscard]] bool any() const noexcept { return !active_.empty(); }

  void hold(std::span<const FilterColumn> columns, std::span<double> amplitudes, std::vector<double>& rows) override;
  /// Rates of the free line's gaps at the points from those of the rows.
  void free_rates(std::span<const double> rows, std::span<double> gaps);

 private:
  LineContact* contact_;
  std::vector<std::uint8_t> touches_;
  std::vector<std::size_t> active_;
  std::vector<double> gap_;  // work
  std::vector<double> free_;
  std::vector<double> force_;
};

}  // namespace udar
