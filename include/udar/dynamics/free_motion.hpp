#pragma once
/// @file
/// The motion between impacts, exactly.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "udar/filter/filtered_line.hpp"

namespace udar {

/// @brief The free masses' motion over a stretch of time without events, by Chebyshev series of the line operator.
///
/// Between impacts z'' = -A z + a0 + t j0 with z(0) = 0, z'(0) = v0 and A = -wf^2 d(.), whose spectrum lies in
/// [0, wf^2], resting masses left out. Its solution is z = S v0 + C a0 + G j0 with entire functions of A, which are
/// Chebyshev series in 2A/wf^2 - 1 with coefficients that depend on time alone: one sequence of line solves gives the
/// motion at any time up to the end. Source: docs/theory.md, "Exact motion between impacts".
class FreeMotion {
 public:
  explicit FreeMotion(FilteredLine& line);

  /// @brief The state to start from, one value per local node.
  struct Start {
    std::span<const double> velocity;      ///< Vm [m/s]
    std::span<const double> acceleration;  ///< wf^2 (Yc - Ym) [m/s^2]
    /// What changing forces add to the acceleration [m/s^3], as wf^2 d' of -load_table's rate; empty: nothing
    std::span<const double> jerk;
    std::span<const std::uint8_t> resting;  ///< nonzero: the mass stays where it is; empty: none
  };
  /// @brief What to add up over all nodes at one time: displacement since the start [m] and velocity [m/s].
  struct Field {
    double time = 0.0;  ///< since the start [s]
    std::span<double> displacement;
    std::span<double> velocity;
  };
  /// @brief Motion of one watched node.
  struct Point {
    double displacement = 0.0;  ///< since the start [m]
    double velocity = 0.0;      ///< [m/s]
    double acceleration = 0.0;  ///< [m/s^2]
  };

  /// @brief Computes the motion up to `duration`.
  /// @param tolerance  error of `Field` and `Point` relative to the largest |v0| t, |a0| t^2 / 2, |j0| t^3 / 6
  /// @param fields     filled; no time beyond `duration`
  /// @param watched    local nodes whose motion `point` can tell afterwards
  /// @note Collective. Cost: `terms(duration, tolerance)` batches of two line solves, three with a jerk.
  void propagate(const Start& start, double duration, double tolerance, std::span<const Field> fields,
                 std::span<const std::size_t> watched);

  /// @brief A watched node at a time from 0 to the last `duration`. @param index in `watched` @note Not collective.
  [[nodiscard]] Point point(std::size_t index, double time) const;

  /// @brief Terms of the series that reach `tolerance` up to `duration`: from the decay of Bessel functions.
  [[nodiscard]] std::size_t terms(double duration, double tolerance) const;

 private:
  using Coefficients = std::vector<double>;
  [[nodiscard]] Coefficients coefficients(int derivative, double time) const;

  FilteredLine* line_;
  std::size_t terms_ = 0;
  std::size_t sequences_ = 0;
  std::vector<double> polynomials_;  // [point][term]: from values in the Chebyshev points to coefficients
  std::vector<double> watched_;      // [watched][sequence][term]
  std::vector<std::vector<double>> last_;
  std::vector<std::vector<double>> current_;
  std::vector<std::vector<double>> stretch_;
};

}  // namespace udar
