#pragma once
/// @file
/// Few contact points of the line in steps of the Chebyshev integrator: who touches, and until when.

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "udar/contact/held_line.hpp"
#include "udar/integrators/series_search.hpp"
#include "udar/motion/contact_state.hpp"
#include "udar/motion/equations.hpp"
#include "udar/motion/motion_scale.hpp"
#include "udar/motion/motion_state.hpp"

namespace udar {

/// @brief While the same points touch the motion is linear, and their forces and the gaps of the others are known from
/// the terms of its series: the rows of `HeldLine`. A step ends at the first zero of one of these; who touches then is
/// the complementarity problem of their rates.
///
/// All that is not of this rank's points is equal on every rank. Source: docs/theory.md, "Contact on the line"
class TouchingPoints {
 public:
  /// @param equations with contact of few points on the line @note Collective: a line solve for each point.
  TouchingPoints(Equations& equations, ContactState& contact, const MotionScale& scale);

  [[nodiscard]] HeldLine& line() noexcept { return held_; }
  /// Whether any point touches in the step.
  [[nodiscard]] bool any() const noexcept { return held_.any(); }

  /// @brief Finds who touches, whatever was before. @param line with its contact forces
  /// @note Collective: two line solves if some gap is zero without a force.
  void start(const LineState& line, std::span<const double> position, std::span<const double> velocity);
  /// @brief Begins a step. @param[in,out] rate of the free line by changing loads, which becomes that of the held one
  /// @note Collective: a reduction, one more with a rate.
  void begin_step(const LineState& line, std::span<const double> position, LoadRate& rate);

  /// When the first row could turn negative, if its second derivative stayed [s]; the series knows its first terms.
  [[nodiscard]] double guess(const FreeMotion& motion) const;
  /// @brief The first zero of a row between two times of the step [s]; infinite: none.
  [[nodiscard]] double search(const FreeMotion& motion, double from, double to);
  /// @brief Ends the step after a time [s]: finds who touches in the next one if `search` found a zero there.
  /// @note Collective if loads change: a reduction, and a line solve at a kink of theirs.
  void end_step(const FreeMotion& motion, double length);
  void take_back();

  /// Adds what the supports gave from the start of the step to a time in it [N s], y up, this rank's share.
  void add_impulses(const FreeMotion& motion, double time, std::span<double> sums) const;
  /// Of the step that `end_step` ended.
  void write_journal(const FreeMotion& motion, double length);

  void save(MotionState& state) const;
  void restore(const MotionState& state);

 private:
  /// Who touches, and whose row is zero at the start of a step.
  struct Status {
    std::vector<std::uint8_t> touches;
    std::vector<std::uint8_t> due;
  };

  [[nodiscard]] Kinematics row(const FreeMotion& motion, std::size_t point, const SeriesSample& at) const;
  [[nodiscard]] bool is_zero(std::size_t point, double value) const;
  void gather_gaps(const LineState& line, std::span<const double> position);
  [[nodiscard]] std::vector<double> gap_rates_of(std::span<const double> velocity, std::span<const double> stretch,
                                                 std::span<const double> amplitude) const;
  void follow(std::span<const double> rates, std::span<const double> accelerations);
  void track_gaps(const FreeMotion& motion, double length);

  Equations* equations_;
  ContactState* contact_;
  double velocity_;  // of the motion [m/s]
  HeldLine held_;
  std::vector<double> give_;        // of the line and the support together under a unit force at the point [m/N]
  std::vector<double> resolution_;  // of gaps [m]
  Status next_;                     // at the end of the step, which the next one starts with
  Status now_;                      // in the step
  double begin_ = 0.0;              // [s]
  std::vector<double> constant_;    // of the rows
  std::vector<double> steady_;      // their rates by changing loads
  std::vector<double> load_rate_;   // of the free gaps
  std::vector<double> zero_at_;     // time in the step [s]; infinite: none found
  std::vector<double> gap_;         // work
};

}  // namespace udar
