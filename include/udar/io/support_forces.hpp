#pragma once
/// @file
/// The force of each support over time, from the impulses it gave.

#include <cstddef>
#include <deque>
#include <span>
#include <vector>

#include "udar/motion/observer.hpp"

namespace udar::io {

/// @brief Mean forces over a moving window. Impacts are impulses: a force is what they come to over a time that the
/// filtered model resolves, half a period of its highest frequency, `pi / wf`, or longer. Equal on every rank.
class SupportForces {
 public:
  /// @param interval between rows [s], above 0
  /// @param shortest window that makes sense [s]; the window is the least multiple of `interval` that is not shorter
  /// @param sampling between samples, where rows are too far apart to find peaks [s]; 0: rows serve
  SupportForces(std::size_t supports, double interval, double shortest, double sampling = 0.0);

  [[nodiscard]] std::size_t supports() const noexcept { return peak_.size(); }
  [[nodiscard]] double window() const noexcept { return rows_.length; }          ///< of the forces in rows [s]
  [[nodiscard]] double peak_window() const noexcept { return samples_.length; }  ///< of the peaks [s]
  /// Of each support the force of largest size so far [N], y up.
  [[nodiscard]] std::span<const double> peaks() const noexcept { return peak_; }

  /// @brief The force of each support [N], y up, at a row: the mean over the window that ends at `time`. Before the
  /// start of the run no support gave anything.
  /// @param time later than that of the last call [s] @param impulse of each support since the start [N s], y up
  [[nodiscard]] std::vector<double> add(double time, std::span<const double> impulse);
  /// @brief The same at a sample: for the peaks alone.
  void sample(double time, std::span<const double> impulse);

  /// @name For a restart
  /// @{
  void save(MotionState& state) const;
  void restore(const MotionState& state);
  /// @}

 private:
  struct Row {
    double time;
    std::vector<double> impulse;
  };
  struct Window {
    double length;
    double slack;          // what rounding may do to the time between two rows [s]
    std::deque<Row> rows;  // from the last one that is a window old on

    Window(double interval, double shortest);
    [[nodiscard]] std::vector<double> mean(double time, std::span<const double> impulse);
    void save(std::vector<double>& table) const;
    void restore(std::span<const double> table, std::size_t supports);
  };

  void note(std::span<const double> force);

  Window rows_;
  Window samples_;
  std::vector<double> peak_;
};

}  // namespace udar::io
