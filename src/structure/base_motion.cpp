#include "udar/structure/base_motion.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <sstream>
#include <string>
#include <utility>

#include "structure/place_algebra.hpp"
#include "udar/numerics/cubic_spline.hpp"
#include "udar/petsc/error.hpp"

namespace udar {
namespace {

Place unit_of(const Place& direction) {
  const double size = norm(direction);
  if (!(size > 0.0) || !std::isfinite(size)) {
    throw InputError{"base motion direction: 0 is not allowed, expected three numbers of which one is not 0"};
  }
  return (1.0 / size) * direction;
}

void require_rows(BaseQuantity given, const std::vector<double>& time, const std::vector<double>& value) {
  const auto strictly = [&] { return std::ranges::adjacent_find(time, std::ranges::greater_equal{}) == time.end(); };
  if (time.size() < 2 || value.size() != time.size() || !(time.front() < time.back()) ||
      (given != BaseQuantity::acceleration && !strictly())) {
    throw InputError{
        "base motion: the motion of the base needs at least two rows of time [s], strictly ascending, and a number"};
  }
}

}  // namespace

BaseMotion::BaseMotion(BaseQuantity given, std::vector<double> time, std::vector<double> value, const Place& direction)
    : direction_{unit_of(direction)} {
  require_rows(given, time, value);
  take(given == BaseQuantity::displacement ? by_displacement(std::move(time), std::move(value))
       : given == BaseQuantity::velocity   ? by_velocity(std::move(time), std::move(value))
                                           : by_acceleration(time, value));
  for (std::size_t row = 0; row < velocity_.size(); ++row) {
    if (!(std::abs(velocity_[row]) < kSpeedOfLight) || !std::isfinite(acceleration_->value()[row]) ||
        !std::isfinite(displacement_[row])) {
      std::ostringstream message;
      message << "base motion: a velocity of " << velocity_[row] << " m/s and an acceleration of "
              << acceleration_->value()[row] << " m/s^2 at t = " << acceleration_->time()[row]
              << " s are not allowed, expected less than the speed of light, " << kSpeedOfLight << " m/s";
      throw InputError{message.str()};
    }
  }
  if (given != BaseQuantity::displacement) {
    const double start = at(0.0).displacement;
    std::ranges::transform(displacement_, displacement_.begin(), [start](double way) { return way - start; });
  }
}

BaseMotion::Rows BaseMotion::by_displacement(std::vector<double> time, std::vector<double> value) {
  std::vector<double> curvature = spline_curvature(time, value);
  Rows rows{.time = std::move(time),
            .displacement = std::move(value),
            .velocity = {0.0},
            .before = curvature,
            .after = std::move(curvature)};
  for (std::size_t i = 1; i < rows.time.size(); ++i) {
    const double length = rows.time[i] - rows.time[i - 1];
    rows.velocity.push_back((rows.displacement[i] - rows.displacement[i - 1]) / length +
                            length / 6.0 * (rows.after[i - 1] + 2.0 * rows.after[i]));
  }
  rows.velocity.back() = 0.0;
  rows.before.front() = 0.0;
  rows.after.back() = 0.0;
  return rows;
}

BaseMotion::Rows BaseMotion::by_velocity(std::vector<double> time, std::vector<double> value) {
  Rows rows{.time = std::move(time), .displacement = {0.0}, .velocity = std::move(value), .before = {0.0}, .after = {}};
  for (std::size_t i = 1; i < rows.time.size(); ++i) {
    const double length = rows.time[i] - rows.time[i - 1];
    const double slope = (rows.velocity[i] - rows.velocity[i - 1]) / length;
    rows.displacement.push_back(rows.displacement.back() + 0.5 * length * (rows.velocity[i - 1] + rows.velocity[i]));
    rows.after.push_back(slope);
    rows.before.push_back(slope);
  }
  rows.after.push_back(0.0);
  return rows;
}

BaseMotion::Rows BaseMotion::by_acceleration(const std::vector<double>& time, const std::vector<double>& value) {
  const TimeTable checked{time, value};  // throws
  Rows rows;
  for (std::size_t i = 0; i < time.size(); ++i) {
    if (i > 0 && time[i] == time[i - 1]) {
      rows.after.back() = value[i];
      continue;
    }
    const double length = i > 0 ? time[i] - rows.time.back() : 0.0;
    const double from = i > 0 ? rows.after.back() : 0.0;
    const double velocity = i > 0 ? rows.velocity.back() : 0.0;
    const double way = i > 0 ? rows.displacement.back() : 0.0;
    rows.time.push_back(time[i]);
    rows.displacement.push_back(way + length * (velocity + length / 6.0 * (2.0 * from + value[i])));
    rows.velocity.push_back(velocity + 0.5 * length * (from + value[i]));
    rows.before.push_back(value[i]);
    rows.after.push_back(value[i]);
  }
  rows.before.front() = 0.0;
  rows.after.back() = 0.0;
  return rows;
}

/// A row of the table for each, two where the acceleration jumps.
void BaseMotion::take(const Rows& rows) {
  std::vector<double> time;
  std::vector<double> value;
  for (std::size_t i = 0; i < rows.time.size(); ++i) {
    for (const bool after : {false, true}) {
      if (!after || rows.after[i] != rows.before[i]) {
        time.push_back(rows.time[i]);
        value.push_back(after ? rows.after[i] : rows.before[i]);
        displacement_.push_back(rows.displacement[i]);
        velocity_.push_back(rows.velocity[i]);
      }
    }
  }
  acceleration_ = time_table(std::move(time), std::move(value));
}

BaseMotion::State BaseMotion::at(double time) const {
  const std::size_t next = acceleration_->row_after(time);
  const std::size_t row = next == 0 ? 0 : next - 1;
  const double elapsed = time - acceleration_->time()[row];
  const auto [acceleration, rate] = acceleration_->at(time);
  const double from = acceleration - rate * elapsed;  // at the row
  return {
      .displacement = displacement_[row] + elapsed * (velocity_[row] + elapsed * (0.5 * from + elapsed * rate / 6.0)),
      .velocity = velocity_[row] + elapsed * (from + 0.5 * elapsed * rate),
      .acceleration = acceleration};
}

double BaseMotion::peak() const {
  double largest = 0.0;
  for (const double value : acceleration_->value()) {
    largest = std::max(largest, std::abs(value));
  }
  return largest;
}

Place base_displacement(std::span<const BaseMotion> motions, double time) {
  Place sum{};
  for (const BaseMotion& motion : motions) {
    sum = sum + motion.at(time).displacement * motion.direction();
  }
  return sum;
}

Place base_velocity(std::span<const BaseMotion> motions, double time) {
  Place sum{};
  for (const BaseMotion& motion : motions) {
    sum = sum + motion.at(time).velocity * motion.direction();
  }
  return sum;
}

}  // namespace udar
