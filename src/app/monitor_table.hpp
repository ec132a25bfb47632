#pragma once
/// @file
/// A table that scrolls on the terminal.

#include <mpi.h>

#include "udar/motion/observer.hpp"

namespace udar::app {

/// @brief Prints a row at each interval of simulated time, its heading behind "#", so that gnuplot follows it.
class MonitorTable final : public Observer {
 public:
  /// @param interval of simulated time [s], above 0
  /// @param inner strikers and pairs, whose faces are the last supports, and whose impulses are none from outside
  MonitorTable(MPI_Comm comm, double interval, std::size_t inner)
      : comm_{comm}, interval_{interval}, inner_{static_cast<std::ptrdiff_t>(inner)} {}

  [[nodiscard]] double interval() const override { return interval_; }
  void snapshot(const Snapshot& state) override;

 private:
  MPI_Comm comm_;
  double interval_;
  std::ptrdiff_t inner_;
  bool headed_ = false;
};

}  // namespace udar::app
