#pragma once
/// @file
/// Supports that move.

#include <array>
#include <span>
#include <vector>

namespace udar {

/// @brief A height over time: a cubic between every two rows of a table, with a continuous velocity; it stands still
/// before the first row and after the last. Source: docs/theory.md, "Supports that move"
class SupportMotion {
 public:
  /// @param time [s], strictly ascending, at least two @param height [m]
  /// @param velocity [m/s], as many; empty: such that no height leaves the range of the two rows around it, zero
  /// in the first and last row (Fritsch and Butland 1984)
  /// @throws InputError naming -support_motion and the row, if velocities carry the support further beyond the heights
  /// than all these are apart, or it moves faster than light
  SupportMotion(std::vector<double> time, std::vector<double> height, std::vector<double> velocity = {});

  /// @brief Height [m], velocity [m/s] and acceleration [m/s^2] just after a time [s].
  struct State {
    double height = 0.0;
    double velocity = 0.0;
    double acceleration = 0.0;
  };
  [[nodiscard]] State at(double time) const { return at(time, time); }
  /// The same at the end of a step without rows from `begin` on, before what a row there changes.
  [[nodiscard]] State at(double time, double begin) const;

  /// @brief Height over an interval in which there is no row, in powers of (t - begin) / length [m].
  [[nodiscard]] std::array<double, 4> cubic(double begin, double length) const;

  /// @throws InputError if a run from 0 to `end` [s] meets a jump of the velocity where the table begins or ends
  void require_smooth(double end) const;

  [[nodiscard]] std::span<const double> time() const noexcept { return time_; }
  [[nodiscard]] std::span<const double> height() const noexcept { return height_; }
  [[nodiscard]] std::span<const double> velocity() const noexcept { return velocity_; }

 private:
  void refuse_overshoot() const;
  void refuse_speeds() const;

  std::vector<double> time_;
  std::vector<double> height_;
  std::vector<double> velocity_;
};

}  // namespace udar
