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
  MonitorTable(MPI_Comm comm, double interval) : comm_{comm}, interval_{interval} {}

  [[nodiscard]] double interval() const override { return interval_; }
  void snapshot(const Snapshot& state) override;

 private:
  MPI_Comm comm_;
  double interval_;
  bool headed_ = false;
};

}  // namespace udar::app
