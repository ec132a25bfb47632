#include "udar/contact/support_motion.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <sstream>
#include <utility>

#include "udar/petsc/error.hpp"

namespace udar {

SupportMotion::SupportMotion(std::vector<double> time, std::vector<double> height, std::vector<double> velocity)
    : time_{std::move(time)}, height_{std::move(height)}, velocity_{std::move(velocity)} {
  if (time_.size() < 2 || height_.size() != time_.size() || (!velocity_.empty() && velocity_.size() != time_.size()) ||
      std::ranges::adjacent_find(time_, std::ranges::greater_equal{}) != time_.end()) {
    throw InputError{
        "option -support_motion: the motion of a support needs at least two rows of time [s], strictly ascending, and "
        "height [m]"};
  }
  if (velocity_.empty()) {
    velocity_.assign(time_.size(), 0.0);
    for (std::size_t i = 1; i + 1 < time_.size(); ++i) {
      const double before = time_[i] - time_[i - 1];
      const double after = time_[i + 1] - time_[i];
      velocity_[i] = ((height_[i] - height_[i - 1]) / before * after + (height_[i + 1] - height_[i]) / after * before) /
                     (before + after);
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
    message << "option -support_motion: a velocity of " << (starts ? velocity_.front() : velocity_.back())
            << " m/s at t = " << (starts ? time_.front() : time_.back()) << " s is not allowed in the "
            << (starts ? "first" : "last")
            << " row, expected 0 or rows from t = 0 to -ts_max_time: beside its rows the support stands still [s]";
    throw InputError{message.str()};
  }
}

}  // namespace udar
