#pragma once
/// @file
/// Forces on the line: gravity and nodal forces that follow time tables.

#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "udar/structure/mass_points.hpp"

namespace udar {

/// @brief A time and the beginning of the step it belongs to: what jumps or bends at its end is as before that [s].
struct Instant {
  double time;
  double begin;

  /// Just after a time.
  Instant(double now) noexcept : time{now}, begin{now} {}  // NOLINT(google-explicit-constructor): a time is one
  Instant(double now, double step_begin) noexcept : time{now}, begin{step_begin} {}
};

/// @brief A force on the line over time: linear between the points, constant before the first and after the last; where
/// two of them have one time it jumps.
struct NodalLoad {
  double position = 0.0;      ///< [m] from the left end; the nodes beside it share force and moment
  std::vector<double> time;   ///< [s], ascending, at least one, no three equal
  std::vector<double> force;  ///< [N], y up, same size
};

/// @brief The load vector F(t) of the line on this rank's nodes.
class Loads {
 public:
  /// @param gravity [m/s^2], acts downward on every lumped mass
  /// @note Collective; keeps only the loads of this rank's nodes.
  /// @throws InputError if a table is empty, ragged or not ascending, or a position is off the beam
  Loads(const MassPoints& points, double gravity, const std::vector<NodalLoad>& nodal);

  /// @brief F [N], one value per local node; empty: none on this rank.
  /// @param work where it is built if it must be; the result lives as long as this object and `work` do
  [[nodiscard]] std::span<const double> force(const Instant& at, std::vector<double>& work) const;
  /// @brief dF/dt [N/s], in the same way.
  [[nodiscard]] std::span<const double> rate(const Instant& at, std::vector<double>& work) const;
  /// @brief Mean of F [N] from one time to a later one, in the same way.
  [[nodiscard]] std::span<const double> mean(double from, double to, std::vector<double>& work) const;

  [[nodiscard]] double gravity() const noexcept { return gravity_; }
  /// All times at which some table of the whole structure has a kink, ascending, equal on every rank [s].
  [[nodiscard]] const std::vector<double>& kinks() const noexcept { return kinks_; }

  struct LocalLoad {
    std::size_t number = 0;  ///< of the load of the whole structure
    PetscInt local_node = 0;
    double share = 1.0;  ///< of the force that this node takes
    NodalLoad table;
  };
  /// The time-dependent loads on this rank.
  [[nodiscard]] const std::vector<LocalLoad>& local() const noexcept { return local_; }
  /// Loads of the whole structure, weight not counted.
  [[nodiscard]] std::size_t count() const noexcept { return count_; }
  /// Weight [N], one value per local node; empty: none.
  [[nodiscard]] std::span<const double> weight() const noexcept { return weight_; }
  /// How many kinks are not after time t: between two of them all rates are constant.
  [[nodiscard]] std::size_t interval(double time) const;
  /// Whether any load of the whole structure changes in time.
  [[nodiscard]] bool time_dependent() const noexcept { return time_dependent_; }
  /// Whether some force of the whole structure jumps at this time [s].
  [[nodiscard]] bool jumps_at(double time) const;

  /// Force and its rate of one table.
  struct ForceAndRate {
    double force;
    double rate;
  };
  [[nodiscard]] static ForceAndRate evaluate(const NodalLoad& load, const Instant& at);
  /// Calls visit(begin, end) for the pieces of a table in which it is linear, from one time to a later one.
  template <class Visit>
  static void each_piece(const NodalLoad& load, double from, double to, const Visit& visit) {
    double begin = from;
    for (const double kink : load.time) {
      if (kink > just_after(begin) && just_after(kink) < to) {
        visit(begin, kink);
        begin = kink;
      }
    }
    visit(begin, to);
  }

 private:
  /// Steps end at kinks but for the last bits: what follows one must not take the force or the slope before it.
  [[nodiscard]] static double just_after(double time) noexcept {
    constexpr double kInstant = 8.0 * std::numeric_limits<double>::epsilon();
    return time + kInstant * std::abs(time);
  }
  template <class Value>
  [[nodiscard]] std::span<const double> sum(std::vector<double>& work, const Value& value) const;

  double gravity_;
  std::vector<double> weight_;  // empty without gravity
  std::size_t nodes_ = 0;
  std::size_t count_ = 0;
  std::vector<LocalLoad> local_;
  std::vector<double> kinks_;
  std::vector<double> jumps_;  // ascending [s]
  bool time_dependent_ = false;
};

}  // namespace udar
