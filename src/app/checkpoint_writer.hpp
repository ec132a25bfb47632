#pragma once
/// @file
/// restart.h5 of a run: when it is written, and what is accepted to go on from.

#include <chrono>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "udar/app/case.hpp"
#include "udar/dynamics/impact_dynamics.hpp"
#include "udar/io/point_order.hpp"
#include "udar/motion/motion_state.hpp"

namespace udar::app {

/// @brief Writes restart.h5 after the first step beyond each multiple of the interval, by the clock, at the end, and
/// when somebody asks.
///
/// It comes before all others of the run: what they add when they finish is no part of a run that goes on.
class CheckpointWriter final : public Observer {
 public:
  CheckpointWriter(const ImpactDynamics& dynamics, const Case& input, const Structure& structure);

  /// What is flushed before, so that rows and restart file fit together. It must outlive this object.
  void flush_before(Observer& other) { others_.push_back(&other); }

  void step(const Progress& progress) override;
  void restore(const MotionState& state) override;
  void finish() override { write(); }

  /// Whether the clock asks for one; rank 0's counts.
  [[nodiscard]] bool due() const;
  /// @note Collective. @throws FileError on all ranks
  void write();
  /// One without a state: from now on it is known what run this is. @note Collective. @throws FileError on all ranks
  void write_head() const;

 private:
  void set_next(double time);

  const ImpactDynamics* dynamics_;
  io::PointOrder points_;
  io::PointOrder cells_;
  std::string path_;
  double interval_;
  double next_ = 0.0;
  std::chrono::steady_clock::duration pause_;  ///< of the clock, between two; zero: none
  std::chrono::steady_clock::time_point written_;
  bool first_rank_;
  std::vector<Parameter> parameters_;
  std::vector<double> gauges_;                ///< x, y, z of each [m]
  std::map<std::string, std::string> texts_;  ///< to go on by
  std::vector<Observer*> others_;
};

/// @brief The state in `-restart_file`, put into `dynamics`; observers are restored by who owns them.
/// @note Collective. @throws InputError naming each parameter that differs, with both values; FileError
[[nodiscard]] MotionState restore(ImpactDynamics& dynamics, const Case& input, const Structure& structure);

}  // namespace udar::app
