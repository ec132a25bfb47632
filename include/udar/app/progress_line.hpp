#pragma once
/// @file
/// A line on the terminal that shows where a long run stands.

#include <mpi.h>

#include <chrono>

#include "udar/motion/observer.hpp"

namespace udar::app {

/// @brief One line that shows where a long run stands; silent unless standard output is a terminal.
class ProgressLine final : public Observer {
 public:
  explicit ProgressLine(MPI_Comm comm);
  void step(const Progress& progress) override;
  void finish() override;

 private:
  using Clock = std::chrono::steady_clock;
  bool visible_ = false;
  bool printed_ = false;
  double first_time_ = -1.0;
  Clock::time_point begin_;
  Clock::time_point last_;
};

}  // namespace udar::app
