#include "udar/structure/time_table.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "udar/petsc/error.hpp"

namespace udar {

TimeTable::TimeTable(std::vector<double> time, std::vector<double> value)
    : time_{std::move(time)}, value_{std::move(value)} {
  bool ascending = std::ranges::is_sorted(time_);
  for (std::size_t i = 0; i + 2 < time_.size(); ++i) {
    ascending = ascending && time_[i] < time_[i + 2];
  }
  if (time_.empty() || time_.size() != value_.size() || !ascending) {
    throw InputError{
        "load table: the times [s] of a load table must be ascending, two equal ones for a jump, with a force [N] "
        "each"};
  }
}

std::vector<double> TimeTable::jumps() const {
  std::vector<double> jumps;
  for (std::size_t i = 0; i + 1 < time_.size(); ++i) {
    if (time_[i] == time_[i + 1]) {
      jumps.push_back(time_[i]);
    }
  }
  return jumps;
}

std::size_t TimeTable::row_after(double begin) const {
  return static_cast<std::size_t>(std::ranges::upper_bound(time_, just_after(begin)) - time_.begin());
}

TimeTable::State TimeTable::at(const Instant& at) const {
  const std::size_t right = row_after(at.begin);
  if (right == 0) {
    return {.value = value_.front(), .rate = 0.0};
  }
  if (right == time_.size()) {
    return {.value = value_.back(), .rate = 0.0};
  }
  const double rate = (value_[right] - value_[right - 1]) / (time_[right] - time_[right - 1]);
  return {.value = value_[right - 1] + rate * (at.time - time_[right - 1]), .rate = rate};
}

std::shared_ptr<const TimeTable> time_table(std::vector<double> time, std::vector<double> value) {
  return std::make_shared<const TimeTable>(std::move(time), std::move(value));
}

}  // namespace udar
