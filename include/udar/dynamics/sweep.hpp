#pragma once
/// @file
/// What a sweep of the impact integrator works on.

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "udar/dynamics/dense_map.hpp"
#include "udar/dynamics/local_motion.hpp"
#include "udar/filter/filtered_line.hpp"

namespace udar {

/// Nodes that are treated together, their values in cache.
inline constexpr std::size_t kBlock = 512;

/// @brief The attempt at a step at hand: this rank's masses at its start and end, and the motion of masses and line
/// over it.
struct Sweep {
  std::size_t terms = 4;          ///< Legendre terms, 2 to 5
  std::size_t count = 0;          ///< local nodes
  double frequency = 0.0;         ///< wf [rad/s]
  double begin = 0.0;             ///< [s]
  double step = 0.0;              ///< [s]
  double drag = 0.0;              ///< -drag Ym' on every mass, over it [1/s]
  double line_damping = 0.0;      ///< +line_damping wf^2 (Yc' - Ym') on every mass, over it [s]
  bool predict = false;           ///< `line` is a guess, not what the line was solved for
  const double* start = nullptr;  ///< Ym [m], then Vm [m/s]
  double* end = nullptr;          ///< the same after the step
  std::span<const double> axis;   ///< height of the reference axis [m]
  std::span<const double> mass;   ///< [kg]
  DenseMap map;                   ///< of this step
  Reach reach;
  std::array<std::vector<double>, kMostTerms> moment_rows;  ///< Legendre coefficients of Ym - axis [m]
  std::array<std::vector<double>, kMostTerms> line_rows;    ///< of the line from Ym at the start [m]
  std::array<std::vector<double>, 2> steady;  ///< what forces add to the first two of these; the second may be empty
  std::span<const CorrectedMode> corrected;
  std::vector<std::array<double, kMostTerms>> amplitude;  ///< of the stretch in these, Legendre coefficients
  std::array<double, kBlock> nothing{};
  std::array<double, kBlock> all_free{};  ///< ones

  /// The values of a block; all of its masses are free.
  [[nodiscard]] Rows rows(std::size_t from) {
    Rows rows{};
    for (std::size_t j = 0; j < terms; ++j) {
      rows.moment[j] = moment_rows[j].data() + from;
      rows.line[j] = line_rows[j].data() + from;
    }
    rows.steady = {steady[0].data() + from, steady[1].empty() ? nothing.data() : steady[1].data() + from};
    rows.position = start + from;
    rows.axis = axis.data() + from;
    rows.velocity = start + count + from;
    rows.free = all_free.data();
    rows.place = end + from;
    rows.speed = end + count + from;
    return rows;
  }
  [[nodiscard]] double angle() const noexcept { return frequency * step; }
  [[nodiscard]] double line_drag() const noexcept { return line_damping * frequency * frequency; }  ///< [1/s]
  [[nodiscard]] bool damped() const noexcept { return drag != 0.0 || line_damping != 0.0; }
  [[nodiscard]] std::size_t powers() const { return local::powers_for(angle() + (drag + line_drag()) * step); }
  /// Legendre coefficient of the displacement since the start of the step [m], as the line was solved for it.
  [[nodiscard]] double moment(std::size_t j, std::size_t node) const {
    return moment_rows[j][node] - (j == 0 ? start[node] - axis[node] : 0.0);
  }
  void set_moment(std::size_t j, std::size_t node, double value) {
    moment_rows[j][node] = value + (j == 0 ? start[node] - axis[node] : 0.0);
  }
  /// What pulls the mass of a node, in powers of tau, from Ym at the start [m].
  [[nodiscard]] std::array<double, kMostTerms> line_powers(std::size_t node) const {
    return powers([&](std::size_t j) { return line_rows[j][node]; });
  }
  /// Legendre coefficient of where the line is: what pulls the masses, less its part in corrected modes [m].
  [[nodiscard]] double line(std::size_t j, std::size_t node) const {
    double value = line_rows[j][node];
    for (std::size_t mode = 0; mode < corrected.size(); ++mode) {
      value -= amplitude[mode][j] * corrected[mode].shape[node];
    }
    return value;
  }
  /// A polynomial of the step in powers of tau from its Legendre coefficients.
  template <class Coefficient>
  [[nodiscard]] std::array<double, kMostTerms> powers(const Coefficient& coefficient) const {
    std::array<double, kMostTerms> sums{};
    for (std::size_t j = 0; j < terms; ++j) {
      for (std::size_t k = 0; k <= j; ++k) {
        sums[k] += coefficient(j) * local::kLegendre[j][k];
      }
    }
    return sums;
  }
};

}  // namespace udar
