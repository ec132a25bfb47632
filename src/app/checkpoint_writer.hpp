#pragma once
/// @file
/// restart.h5 of a run: when it is written, and what is accepted to go on from.

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "udar/app/case.hpp"
#include "udar/dynamics/impact_dynamics.hpp"
#include "udar/io/point_order.hpp"
#include "udar/motion/motion_state.hpp"

namespace udar::app {

/// @brief Writes restart.h5 after the first step beyond each multiple of the interval, at the end, and when somebody
/// asks.
class CheckpointWriter final : public Observer {
 public:
  /// @param others what is flushed before, so that no row is missing between this run and the one that goes on
  CheckpointWriter(const ImpactDynamics& dynamics, const Case& input, const Structure& structure,
                   std::span<const std::unique_ptr<Observer>> others);

  void step(const Progress& progress) override;
  void restore(const MotionState& state) override { set_next(state.scalar("time")); }
  void finish() override { write(); }

  /// @note Collective. @throws FileError on all ranks
  void write() const;

 private:
  void set_next(double time);

  const ImpactDynamics* dynamics_;
  io::PointOrder points_;
  io::PointOrder cells_;
  std::string path_;
  double interval_;
  double next_ = 0.0;
  std::vector<Parameter> parameters_;
  std::vector<Observer*> others_;
};

/// @brief The state in `-restart_file`, put into `dynamics`; observers are restored by who owns them.
/// @note Collective. @throws InputError naming each parameter that differs, with both values; FileError
[[nodiscard]] MotionState restore(ImpactDynamics& dynamics, const Case& input, const Structure& structure);

}  // namespace udar::app
