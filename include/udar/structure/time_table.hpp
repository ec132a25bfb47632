#pragma once
/// @file
/// A number over time, given by the rows of a table.

#include <cmath>
#include <limits>
#include <memory>
#include <span>
#include <vector>

namespace udar {

/// What moves faster is a slip in a number or its unit, and asks for steps without end [m/s].
inline constexpr double kSpeedOfLight = 299792458.0;

/// @brief A time and the beginning of the step it belongs to: what jumps or bends at its end is as before that [s].
struct Instant {
  double time;
  double begin;

  /// Just after a time.
  Instant(double now) noexcept : time{now}, begin{now} {}  // NOLINT(google-explicit-constructor): a time is one
  Instant(double now, double step_begin) noexcept : time{now}, begin{step_begin} {}
};

/// @brief Linear between the rows, constant before the first and after the last; where two rows have one time it jumps.
/// Immutable: many share one. Looking up a time costs O(log rows).
class TimeTable {
 public:
  /// @param time [s], ascending, at least one, no three equal @param value as many
  /// @throws InputError if they are not so
  TimeTable(std::vector<double> time, std::vector<double> value);

  [[nodiscard]] std::span<const double> time() const noexcept { return time_; }
  [[nodiscard]] std::span<const double> value() const noexcept { return value_; }
  /// Whether it never changes.
  [[nodiscard]] bool steady() const noexcept { return time_.size() == 1; }
  /// The times of its jumps, ascending [s].
  [[nodiscard]] std::vector<double> jumps() const;

  /// Value and its rate [1/s].
  struct State {
    double value;
    double rate;
  };
  [[nodiscard]] State at(const Instant& at) const;
  /// @brief The first row after the one that holds at the beginning of a step; none: all are before.
  [[nodiscard]] std::size_t row_after(double begin) const;
  /// Calls visit(begin, end) for the pieces in which it is linear, from one time to a later one.
  template <class Visit>
  void each_piece(double from, double to, const Visit& visit) const {
    double begin = from;
    for (std::size_t row = row_after(from); row < time_.size() && just_after(time_[row]) < to; ++row) {
      if (time_[row] > just_after(begin)) {
        visit(begin, time_[row]);
        begin = time_[row];
      }
    }
    visit(begin, to);
  }

  /// Steps end at rows but for the last bits: what follows one must not take the value or the slope before it [s].
  [[nodiscard]] static double just_after(double time) noexcept {
    constexpr double kInstant = 8.0 * std::numeric_limits<double>::epsilon();
    return time + kInstant * std::abs(time);
  }

 private:
  std::vector<double> time_;
  std::vector<double> value_;
};

/// One for many to share. @throws as `TimeTable`
[[nodiscard]] std::shared_ptr<const TimeTable> time_table(std::vector<double> time, std::vector<double> value);

}  // namespace udar
