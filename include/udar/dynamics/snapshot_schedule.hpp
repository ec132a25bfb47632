#pragma once
/// @file
/// When the observers of a run get their rows.

#include <petscsys.h>

#include <span>
#include <vector>

#include "udar/motion/observer.hpp"

namespace udar {

/// @brief Who listens to a run, and when the next row is due to whom: at t = 0, at every multiple of the listener's
/// interval, exactly, and at the end of the run.
class SnapshotSchedule {
 public:
  /// @param end_time of the run [s]
  explicit SnapshotSchedule(double end_time) : end_time_{end_time} {}

  /// It must outlive this object.
  void add(Observer& observer);
  [[nodiscard]] std::span<Observer* const> observers() const noexcept { return observers_; }

  /// Goes on after a time up to which all rows have been taken [s].
  void resume(double taken);
  /// When the next row is due [s]; infinite: no more.
  [[nodiscard]] double next() const;
  /// Whether that is not after a time [s].
  [[nodiscard]] bool is_due(double until) const;
  /// @brief Gives the row of `next()` to all to whom it is listener.
  /// @param[in,out] row its zone is filled here @param zone of a listener whose last row was at a time [s]
  template <class Zone>
  void tell(Snapshot& row, const Zone& zone) {
    double since = row.time;  // of the zone at hand; most listeners have the same interval, and none a row before the
                              // first
    for (Listener& listener : due_) {
      if (is_due(listener, row.time)) {
        const double last = last_row(listener, row.time);
        if (last != since) {
          row.zone = zone(last);
          since = last;
        }
        advance(listener, row.time);
        listener.observer->snapshot(row);
      }
    }
  }

 private:
  struct Listener {
    Observer* observer = nullptr;
    PetscInt next = 0;   // multiple of its interval
    bool ended = false;  // has had the row at the end of the run
  };

  [[nodiscard]] double time_of(const Listener& listener) const;
  [[nodiscard]] bool is_due(const Listener& listener, double until) const;
  [[nodiscard]] static double last_row(const Listener& listener, double first);
  void advance(Listener& listener, double time) const;

  double end_time_;
  std::vector<Observer*> observers_;
  std::vector<Listener> due_;  // by observer
};

}  // namespace udar
