#pragma once
/// @file
/// Motion of the base that a structure stands on.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "udar/structure/mass_points.hpp"
#include "udar/structure/time_table.hpp"

namespace udar {

/// @brief What a table says of the base.
enum class BaseQuantity : std::uint8_t {
  displacement,  ///< [m]; a cubic spline, at rest before the first row and after the last
  velocity,      ///< [m/s]; linear between the rows, constant outside
  acceleration,  ///< [m/s^2]; linear between the rows, two rows of one time are a jump, none outside; at rest before
};

/// @brief How the base moves along one direction over time: its acceleration is linear between times, at which it may
/// jump. Source: docs/theory.md, "Motion of the base"
class BaseMotion {
 public:
  /// @param time [s], strictly ascending, of accelerations as in a `TimeTable`; at least two @param value as many
  /// @param direction along which, of any length but 0
  /// @throws InputError if they are not so, a number is not finite, or the base moves faster than light
  BaseMotion(BaseQuantity given, std::vector<double> time, std::vector<double> value, const Place& direction = kUp);

  /// Along `direction`, just after a time; displacements of what gives none are counted from t = 0.
  struct State {
    double displacement = 0.0;  ///< [m]
    double velocity = 0.0;      ///< [m/s]
    double acceleration = 0.0;  ///< [m/s^2]
  };
  /// @note O(log rows)
  [[nodiscard]] State at(double time) const;

  /// Unit vector.
  [[nodiscard]] const Place& direction() const noexcept { return direction_; }
  /// [m/s^2], of all times.
  [[nodiscard]] const std::shared_ptr<const TimeTable>& acceleration() const noexcept { return acceleration_; }
  /// The largest acceleration in any direction [m/s^2].
  [[nodiscard]] double peak() const;

 private:
  /// Of the base at its rows.
  struct Rows {
    std::vector<double> time;
    std::vector<double> displacement;
    std::vector<double> velocity;
    std::vector<double> before;  ///< acceleration just before
    std::vector<double> after;
  };
  [[nodiscard]] static Rows by_displacement(std::vector<double> time, std::vector<double> value);
  [[nodiscard]] static Rows by_velocity(std::vector<double> time, std::vector<double> value);
  [[nodiscard]] static Rows by_acceleration(const std::vector<double>& time, const std::vector<double>& value);
  void take(const Rows& rows);

  Place direction_;
  std::shared_ptr<const TimeTable> acceleration_;
  std::vector<double> displacement_;  // at the rows of `acceleration_` [m]
  std::vector<double> velocity_;      // [m/s]
};

/// @brief Where the base is at a time, or how fast it goes, of all its motions together.
[[nodiscard]] Place base_displacement(std::span<const BaseMotion> motions, double time);  ///< [m]
[[nodiscard]] Place base_velocity(std::span<const BaseMotion> motions, double time);      ///< [m/s]

}  // namespace udar
