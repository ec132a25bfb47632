#pragma once
/// @file
/// The line over a step of the impact integrator.

#include <array>
#include <cstddef>
#include <vector>

#include "udar/integrators/line_forces.hpp"
#include "udar/integrators/sweep.hpp"
#include "udar/motion/contact_state.hpp"
#include "udar/motion/equations.hpp"
#include "udar/motion/motion_state.hpp"

namespace udar {

/// @brief The Legendre series of the line's motion in the sweep: extrapolated into a step, solved for in every sweep.
class SweptLine {
 public:
  /// Both outlive this object; the sweep has its terms, damping and rows.
  SweptLine(Equations& equations, Sweep& sweep);

  /// @brief The line goes on as the masses do. @param velocity Vm [m/s] @param step over which it is a polynomial [s]
  void start(const LineState& line, const ContactState& contact, const double* velocity, double step);
  /// @brief ... or as it has followed masses without a vibration up to now, over the last step of that length [s].
  /// @param velocity Vm [m/s] @param acceleration of a local node [m/s^2]: acceleration(node)
  template <class Acceleration>
  void follow(const double* velocity, double step, const Acceleration& acceleration);
  /// The step of this length [s] is over: the motion counts from the new positions.
  void begin_step(double length);
  /// ... or is taken again: the polynomial is that of the step taken back.
  void take_back() noexcept { from_end_ = false; }

  /// @brief What forces add to the line's motion of this step: all of it but its answer to the masses.
  /// @note Collective: a line solve where it is not known.
  void load(double begin, double step);
  /// @brief With damping by the line's rate: the line's answer to the places at the start, from which the moments of
  /// damped masses count. @note Collective: a line solve.
  void solve_start();
  /// The motion over a new step: the polynomial at hand, gone on with or cut.
  void extrapolate(double step);
  /// @brief The line for all that a sweep has changed, and what drives the masses next.
  /// @param forces of contact on the line; null: there is none @note Collective.
  void solve(LineForces* forces);

  /// Mean of what pulls a mass over a share of the step, from its place at the start [m].
  [[nodiscard]] double mean_stretch(std::size_t node, double tau) const;
  [[nodiscard]] std::vector<double> amplitude_integrals(double tau, double length) const;

  void save(MotionState& state) const;
  void restore(const MotionState& state);

 private:
  [[nodiscard]] bool damps_by_rate() const { return sweep_->line_damping != 0.0; }

  Equations* equations_;
  Sweep* sweep_;
  bool steady_known_ = false;
  std::vector<std::array<double, kMostTerms>> steady_amplitude_;  // of what forces add, as LineSeries::amplitude
  std::vector<double> start_amplitude_;                           // of `LineSeries::start_stretch`
  std::vector<double> work_;
  double polynomial_step_ = 0.0;  // over which the line is a polynomial [s]
  bool from_end_ = true;          // the next step starts at its end, not at its start
};

template <class Acceleration>
void SweptLine::follow(const double* velocity, double step, const Acceleration& acceleration) {
  const double wf2 = sweep_->frequency * sweep_->frequency;
  polynomial_step_ = step;
  from_end_ = true;
  for (std::size_t i = 0; i < sweep_->count; ++i) {
    // d + v s + a s^2 / 2 with s from -step to 0, from the place at the end.
    const double way = step * velocity[i];
    const double bend = step * step * acceleration(i);
    sweep_->series.rows[0][i] = acceleration(i) / wf2 - 0.5 * way + bend / 6.0;
    sweep_->series.rows[1][i] = 0.5 * way - 0.25 * bend;
    for (std::size_t j = 2; j < sweep_->terms; ++j) {
      sweep_->series.rows[j][i] = j == 2 ? bend / 12.0 : 0.0;
    }
  }
}

}  // namespace udar
