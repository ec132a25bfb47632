#include "udar/contact/support_motion.hpp"

// Before pchip.hpp, which in Boost 1.74 calls an isnan that is in no namespace.
#include <math.h>  // NOLINT(modernize-deprecated-headers)

#include <algorithm>
#include <boost/math/interpolators/pchip.hpp>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <sstream>
#include <utility>

#include "udar/petsc/error.hpp"
#include "udar/structure/time_table.hpp"

namespace udar {
namespace {

/// Slopes that keep the cubics between two rows within these: by a library, for the rows as they stand, with a row at
/// rest on either side, which makes the slopes of the first and the last row zero.
std::vector<double> shape_preserving_slopes(const std::vector<double>& time, const std::vector<double>& height) {
  const double length = time.back() - time.front();
  std::vector<double> t{time.front() - length};
  std::vector<double> y{height.front()};
  t.insert(t.end(), time.begin(), time.end());
  y.insert(y.end(), height.begin(), height.end());
  t.push_back(time.back() + length);
  y.push_back(height.back());
  const boost::math::interpolators::pchip<std::vector<double>> curve{std::move(t), std::move(y)};
  std::vector<double> slopes;
  slopes.reserve(time.size());
  for (const double at : time) {
    slopes.push_back(curve.prime(at));
  }
  return slopes;
}

/// How far a cubic leaves the range of its two ends. @param v0, v1 slopes over the whole length
double overshoot(double y0, double y1, double v0, double v1) {
  const double rise = y1 - y0;
  // The slope is a parabola in s: v0 + 2 b s + 3 c s^2.
  const double b = 3.0 * rise - 2.0 * v0 - v1;
  const double c = v0 + v1 - 2.0 * rise;
  const double root = std::sqrt(std::max(b * b - 3.0 * c * v0, 0.0));
  const double q = -(b + std::copysign(root, b));
  double most = 0.0;
  for (const double s : {q / (3.0 * c), v0 / q}) {
    if (s > 0.0 && s < 1.0) {
      const double y = y0 + s * (v0 + s * (b + s * c));
      most = std::max({most, y - std::max(y0, y1), std::min(y0, y1) - y});
    }
  }
  return most;
}

}  // namespace

SupportMotion::SupportMotion(std::vector<double> time, std::vector<double> height, std::vector<double> velocity)
    : time_{std::move(time)}, height_{std::move(height)}, velocity_{std::move(velocity)} {
  if (time_.size() < 2 || height_.size() != time_.size() || (!velocity_.empty() && velocity_.size() != time_.size()) ||
      std::ranges::adjacent_find(time_, std::ranges::greater_equal{}) != time_.end()) {
    throw InputError{
        "support motion: the motion of a support needs at least two rows of time [s], strictly ascending, and "
        "height [m]"};
  }
  if (velocity_.empty()) {
    velocity_ = shape_preserving_slopes(time_, height_);
  } else {
    refuse_overshoot();
  }
  refuse_speeds();
}

/// Faster than light is no motion of a support but a slip in a time or a unit.
void SupportMotion::refuse_speeds() const {
  for (std::size_t i = 0; i + 1 < time_.size(); ++i) {
    const double speed = std::abs(height_[i + 1] - height_[i]) / (time_[i + 1] - time_[i]);
    if (!(std::max({speed, std::abs(velocity_[i]), std::abs(velocity_[i + 1])}) < kSpeedOfLight)) {
      std::ostringstream message;
      message << "support motion: rows " << i + 1 << " and " << i + 2 << " of numbers (t = " << time_[i] << " s, "
              << time_[i + 1] - time_[i] << " s apart) are not allowed: the support would move by "
              << std::max({speed, std::abs(velocity_[i]), std::abs(velocity_[i + 1])})
              << " m/s, expected less than the speed of light, " << kSpeedOfLight << " m/s";
      throw InputError{message.str()};
    }
  }
}

/// Velocities that do not belong to the heights carry the support far beyond them.
void SupportMotion::refuse_overshoot() const {
  const auto [lowest, highest] = std::ranges::minmax(height_);
  for (std::size_t i = 0; i + 1 < time_.size(); ++i) {
    const double h = time_[i + 1] - time_[i];
    const double beyond = overshoot(height_[i], height_[i + 1], h * velocity_[i], h * velocity_[i + 1]);
    if (!(beyond <= highest - lowest)) {
      const std::size_t row = std::abs(velocity_[i]) > std::abs(velocity_[i + 1]) ? i : i + 1;
      std::ostringstream message;
      message << "support motion: a velocity of " << velocity_[row] << " m/s in row " << row + 1
              << " of numbers (t = " << time_[row] << " s) is not allowed: between rows " << i + 1 << " and " << i + 2
              << " it carries the support " << beyond << " m beyond their heights, expected at most "
              << highest - lowest
              << " m, the range of the whole table; give velocities that belong to the heights, more rows, or no "
                 "velocities";
      throw InputError{message.str()};
    }
  }
}

std::array<double, 4> SupportMotion::cubic(double begin, double length) const {
  const double middle = begin + 0.5 * length;
  const auto after = std::ranges::upper_bound(time_, middle);
  if (after == time_.begin()) {
    return {height_.front()};
  }
  if (after == time_.end()) {
    return {height_.back()};
  }
  const auto right = static_cast<std::size_t>(after - time_.begin());
  const double h = time_[right] - time_[right - 1];
  const double rise = height_[right] - height_[right - 1];
  const double v0 = h * velocity_[right - 1];
  const double v1 = h * velocity_[right];
  std::array<double, 4> c{height_[right - 1], v0, 3.0 * rise - 2.0 * v0 - v1, v0 + v1 - 2.0 * rise};
  const double at = (begin - time_[right - 1]) / h;
  const double ratio = length / h;
  c = {c[0] + at * (c[1] + at * (c[2] + at * c[3])), c[1] + at * (2.0 * c[2] + 3.0 * at * c[3]), c[2] + 3.0 * at * c[3],
       c[3]};
  return {c[0], c[1] * ratio, c[2] * ratio * ratio, c[3] * ratio * ratio * ratio};
}

SupportMotion::State SupportMotion::at(double time, double begin) const {
  const auto after = std::ranges::upper_bound(time_, begin);
  if (after == time_.begin()) {
    return {.height = height_.front()};
  }
  if (after == time_.end()) {
    return {.height = height_.back(), .velocity = time == time_.back() ? velocity_.back() : 0.0};
  }
  const double row = *std::prev(after);
  const double length = *after - row;
  const auto c = cubic(row, length);
  const double s = (time - row) / length;
  return {.height = c[0] + s * (c[1] + s * (c[2] + s * c[3])),
          .velocity = (c[1] + s * (2.0 * c[2] + 3.0 * s * c[3])) / length,
          .acceleration = (2.0 * c[2] + 6.0 * s * c[3]) / (length * length)};
}

void SupportMotion::require_smooth(double end) const {
  const bool starts = time_.front() > 0.0 && velocity_.front() != 0.0;
  const bool stops = time_.back() < end && velocity_.back() != 0.0;
  if (starts || stops) {
    std::ostringstream message;
    message << "support motion: a velocity of " << (starts ? velocity_.front() : velocity_.back())
            << " m/s at t = " << (starts ? time_.front() : time_.back()) << " s is not allowed in the "
            << (starts ? "first" : "last")
            << " row, expected 0 or rows from t = 0 to -ts_max_time: beside its rows the support stands still [s]";
    throw InputError{message.str()};
  }
}

}  // namespace udar
