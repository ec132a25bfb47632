#include "udar/dynamics/snapshot_schedule.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "udar/motion/kinks.hpp"

namespace udar {
namespace {

constexpr double kAfterTheEnd = std::numeric_limits<double>::infinity();

/// count times interval; 3 times 0.1 is 0.3, not the product of the rounded 0.1.
double multiple(PetscInt count, double interval) {
  const double per_unit = std::round(1.0 / interval);
  const bool divides = per_unit > 0.0 && 1.0 / per_unit == interval;
  return divides ? static_cast<double>(count) / per_unit : static_cast<double>(count) * interval;
}

}  // namespace

void SnapshotSchedule::add(Observer& observer) {
  observers_.push_back(&observer);
  due_.push_back({.observer = &observer, .next = 0});
}

void SnapshotSchedule::resume(double taken) {
  for (Listener& listener : due_) {
    const double interval = listener.observer->interval();
    if (interval > 0.0) {
      listener.next = static_cast<PetscInt>(std::floor((taken + time_resolution(taken)) / interval)) + 1;
    }
  }
}

double SnapshotSchedule::next() const {
  double first = kAfterTheEnd;
  for (const Listener& listener : due_) {
    first = std::min(first, time_of(listener));
  }
  return first;
}

bool SnapshotSchedule::is_due(double until) const { return next() <= until + time_resolution(until); }

bool SnapshotSchedule::is_due(const Listener& listener, double until) const {
  return time_of(listener) <= until + time_resolution(until);
}

double SnapshotSchedule::time_of(const Listener& listener) const {
  const double interval = listener.observer->interval();
  return interval > 0.0 && !listener.ended ? std::min(multiple(listener.next, interval), end_time_) : kAfterTheEnd;
}

/// @param first its row at hand, if it has had none
double SnapshotSchedule::last_row(const Listener& listener, double first) {
  return listener.next > 0 ? multiple(listener.next - 1, listener.observer->interval()) : first;
}

void SnapshotSchedule::advance(Listener& listener, double time) const {
  ++listener.next;
  listener.ended = time >= end_time_ - time_resolution(end_time_);
}

}  // namespace udar
