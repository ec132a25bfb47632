#pragma once
/// @file
/// What a line does that is not free.

#include <cstddef>
#include <span>
#include <vector>

#include "udar/filter/filter_column.hpp"

namespace udar {

/// @brief Turns the free line's answers to the masses into those of a line that is held or has yielded at some points,
/// with a number for each of these points: its row.
class AlteredLine {
 public:
  AlteredLine() = default;
  AlteredLine(const AlteredLine&) = delete;
  AlteredLine& operator=(const AlteredLine&) = delete;
  virtual ~AlteredLine() = default;

  [[nodiscard]] virtual std::size_t points() const noexcept = 0;
  /// No frequency of the masses is higher, whatever the points do [rad/s].
  [[nodiscard]] virtual double frequency_bound() const noexcept = 0;
  /// @brief Turns answers of the free line into those of this one.
  /// @param columns how masses move [m] and the stretch of the free line [m]; the latter becomes that of this one
  /// @param[in,out] amplitudes of it in the corrected modes, by column, then mode
  /// @param[out] rows by column, then point @note Collective: one reduction.
  virtual void hold(std::span<const FilterColumn> columns, std::span<double> amplitudes, std::vector<double>& rows) = 0;
};

}  // namespace udar
