#pragma once
/// @file
/// What a sweep of the impact integrator works on.

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "udar/filter/filtered_structure.hpp"
#include "udar/local/dense_map.hpp"
#include "udar/local/local_motion.hpp"
#include "udar/local/step_maps.hpp"

namespace udar {

/// Nodes that are treated together, their values in cache.
inline constexpr std::size_t kBlock = 512;
/// Rows of a block that are the same everywhere.
inline constexpr std::array<double, kBlock> kZeros{};
inline constexpr std::array<double, kBlock> kOnes = [] {
  std::array<double, kBlock> ones{};
  ones.fill(1.0);
  return ones;
}();

/// @brief The motion of the line over a step, as far as the masses and what drives them go: Legendre coefficients, by
/// node.
struct LineSeries {
  std::array<std::vector<double>, kMostTerms> rows;  ///< of the line from Ym at the start [m]
  /// What forces add to the first two of these [m]; the second may be empty.
  std::array<std::vector<double>, 2> steady;
  /// @name With line damping alone.
  /// @{
  std::array<std::vector<double>, kMostTerms> rates;   ///< of the line's answer to the masses' velocities [m/s]
  std::array<std::vector<double>, kMostTerms> drives;  ///< of the line and line_damping times that [m]
  std::vector<double> start_stretch;                   ///< what the places at the start give the line [m]: part of it
  std::vector<double> end_stretch;                     ///< what the displacements at the end add
  /// @}
  std::span<const CorrectedMode> corrected;
  std::vector<std::array<double, kMostTerms>> amplitude;  ///< of the stretch in these
};

/// @brief The attempt at a step at hand: this rank's masses at its start and end, and the motion of masses and line
/// over it.
struct Sweep {
  std::size_t terms = 4;          ///< Legendre terms, 2 to 5
  std::size_t count = 0;          ///< local nodes
  double frequency = 0.0;         ///< wf [rad/s]
  double begin = 0.0;             ///< [s]
  double step = 0.0;              ///< [s]
  double drag = 0.0;              ///< -drag Ym' on every mass, over it [1/s]
  double line_damping = 0.0;      ///< line_damping wf^2 d(Ym') on every mass, over it [s]
  bool predict = false;           ///< `series` is a guess, not what the line was solved for
  const double* start = nullptr;  ///< Ym [m], then Vm [m/s]
  double* end = nullptr;          ///< the same after the step
  std::span<const double> axis;   ///< height of the reference axis [m]
  std::span<const double> mass;   ///< [kg]
  DenseMap map;                   ///< of this step
  ResponseBounds reach;
  /// Legendre coefficients of Ym - axis [m]; with line damping of Ym less its start, since rates must not suffer from
  /// the rounding of places, and one more: its value at the end.
  std::array<std::vector<double>, kMostUnknowns> moment_rows;
  LineSeries series;

  /// The values of a block; all of its masses are free.
  [[nodiscard]] BlockRows rows(std::size_t from) {
    BlockRows rows{};
    for (std::size_t j = 0; j < terms; ++j) {
      rows.line[j] = series.rows[j].data() + from;
      rows.drive[j] = drive(j).data() + from;
    }
    for (std::size_t j = 0; j < unknowns(); ++j) {
      rows.moment[j] = moment_rows[j].data() + from;
    }
    rows.damped = line_damping != 0.0;
    rows.steady = {series.steady[0].data() + from,
                   series.steady[1].empty() ? kZeros.data() : series.steady[1].data() + from};
    rows.position = start + from;
    rows.axis = line_damping != 0.0 ? start + from : axis.data() + from;
    rows.velocity = start + count + from;
    rows.free = kOnes.data();
    rows.place = end + from;
    rows.speed = end + count + from;
    return rows;
  }
  [[nodiscard]] double angle() const noexcept { return frequency * step; }
  [[nodiscard]] double line_drag() const noexcept { return line_damping * frequency * frequency; }  ///< [1/s]
  [[nodiscard]] bool damped() const noexcept { return drag != 0.0 || line_damping != 0.0; }
  [[nodiscard]] StepScale scale() const noexcept {
    return {.angle = angle(), .drag = (drag + line_drag()) * step, .damping = line_damping / step};
  }
  [[nodiscard]] std::size_t powers() const { return local::powers_for(scale().angle + scale().drag); }
  /// What a sweep solves the line for, per node.
  [[nodiscard]] std::size_t unknowns() const noexcept { return terms + (line_damping != 0.0 ? 1 : 0); }
  /// Legendre coefficient of the displacement since the start of the step [m], as the line was solved for it; the last
  /// unknown: the displacement at the end.
  [[nodiscard]] double moment(std::size_t j, std::size_t node) const {
    return moment_rows[j][node] - (j == 0 ? base(node) : 0.0);
  }
  void set_moment(std::size_t j, std::size_t node, double value) {
    moment_rows[j][node] = value + (j == 0 ? base(node) : 0.0);
  }
  /// From where the first moment counts to the place at the start [m].
  [[nodiscard]] double base(std::size_t node) const { return line_damping != 0.0 ? 0.0 : start[node] - axis[node]; }
  /// The line's rate from stretches and moments of the sweep at hand. By the moments of the velocities: exactly what
  /// these give, in the mean over the step, so that the masses never gain energy by it.
  void find_rates();
  /// What drives the masses. @param solved whether line_rows are stretches
  void find_drive(bool solved);
  /// Legendre coefficient of what drives the masses, by node.
  [[nodiscard]] const std::vector<double>& drive(std::size_t j) const {
    return line_damping != 0.0 ? series.drives[j] : series.rows[j];
  }
  /// What drives the mass of a node, in powers of tau, from Ym at the start [m].
  [[nodiscard]] std::array<double, kMostTerms> drive_powers(std::size_t node) const {
    return powers([&](std::size_t j) { return drive(j)[node]; });
  }
  /// What of it comes from the line's rate, as acceleration [m per step^2].
  [[nodiscard]] std::array<double, kMostTerms> turn_powers(std::size_t node) const {
    const double scale = line_drag() * step * step;
    return powers([&](std::size_t j) { return line_damping != 0.0 ? scale * series.rates[j][node] : 0.0; });
  }
  /// Legendre coefficient of where the line is: what pulls the masses, less its part in corrected modes [m].
  [[nodiscard]] double line(std::size_t j, std::size_t node) const {
    double value = series.rows[j][node];
    for (std::size_t mode = 0; mode < series.corrected.size(); ++mode) {
      value -= series.amplitude[mode][j] * series.corrected[mode].shape[node];
    }
    return value;
  }
  /// A polynomial of the step in powers of tau from its Legendre coefficients.
  template <class Coefficient>
  [[nodiscard]] std::array<double, kMostTerms> powers(const Coefficient& coefficient) const {
    std::array<double, kMostTerms> sums{};
    for (std::size_t j = 0; j < terms; ++j) {
      for (std::size_t k = 0; k <= j; ++k) {
        sums[k] += coefficient(j) * kLegendre[j][k];
      }
    }
    return sums;
  }
};

}  // namespace udar
