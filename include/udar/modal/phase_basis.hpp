#pragma once
/// @file
/// The normal modes of a reduced model while the same points touch.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "udar/modal/reduced_model.hpp"
#include "udar/numerics/complementarity.hpp"

namespace udar {

/// @brief Coordinates z, q = U z, in which the motion with some points touching falls apart, and what decides how long
/// it lasts: a row for every point, the force of one that touches and the gap of one that does not.
class PhaseBasis {
 public:
  /// @param model conservative @param closed W + 1/K @param touches of each point
  PhaseBasis(const ReducedModel& model, Complementarity& closed, const std::vector<std::uint8_t>& touches);

  [[nodiscard]] const std::vector<std::uint8_t>& touches() const noexcept { return touches_; }
  [[nodiscard]] std::span<const double> frequency() const noexcept { return frequency_; }  ///< [rad/s]
  /// What a coordinate does to the row of a point.
  [[nodiscard]] std::span<const double> row(std::size_t point) const {
    return std::span{rows_}.subspan(point * frequency_.size(), frequency_.size());
  }

  /// U' x and U z.
  void reduce(std::span<const double> modal, std::span<double> coordinates) const;
  void expand(std::span<const double> coordinates, std::span<double> modal) const;
  /// What offsets [m] put into the rows, and with a load into the coordinates.
  void offsets(std::span<const double> offset, std::span<double> rows) const;
  void load(std::span<const double> modal_load, std::span<const double> offset, std::span<double> coordinates) const;

 private:
  void diagonalise(const ReducedModel& model, const std::vector<double>& stiff);

  std::vector<std::uint8_t> touches_;
  std::vector<double> frequency_;
  std::vector<double> vectors_;    // U', by rows; empty: the modes themselves
  std::vector<double> rows_;       // points x modes
  std::vector<double> of_offset_;  // points x points
  std::vector<double> pull_;       // points x modes: -b' of the forces that offsets alone cause, in coordinates
};

}  // namespace udar
