#pragma once
/// @file
/// The supports as the masses meet them in a step of the impact integrator.

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "udar/contact/support.hpp"
#include "udar/integrators/law_history.hpp"
#include "udar/integrators/sweep.hpp"
#include "udar/local/local_motion.hpp"
#include "udar/motion/contact_state.hpp"

namespace udar {

/// @brief A mass near its supports, and the support behind each stop: the first it meets, and the one it rests on.
struct StopProblem {
  local::Problem problem;
  std::array<const ContactSet*, 2> sets{};
};

/// @brief Which supports are near a block of nodes, where they are over the step, and what a mass has to do with them.
/// @note Not collective.
class StepSupports {
 public:
  /// All outlive this object.
  StepSupports(const Sweep& sweep, const ContactState& contact, const LawHistory& history);

  /// The step of the sweep, or another length of it.
  void begin();
  /// Runs that have nodes in the block of a node, by index.
  [[nodiscard]] std::span<const std::size_t> sets_at(std::size_t node) const;
  /// How a contact set is lifted, in powers of tau [m].
  [[nodiscard]] const std::array<double, 4>& lift(std::size_t set) const { return lifts_[set]; }
  /// Lowest and highest bound of that over the step [m].
  [[nodiscard]] std::array<double, 2> bounds_of_lift(std::size_t set) const;
  /// @brief The motion of a mass among its stops. @param resting support + 1 that it rests on at the start; 0: none
  [[nodiscard]] StopProblem problem(std::size_t node, std::int32_t resting) const;

 private:
  const Sweep* sweep_;
  const ContactState* contact_;
  const LawHistory* history_;
  std::vector<std::size_t> block_runs_;       // of every block, by index
  std::vector<std::size_t> first_run_;        // of a block, in `block_runs_`
  std::vector<std::array<double, 4>> lifts_;  // of every contact set in powers of tau [m]
  double lifted_at_ = -1.0;                   // begin and length of the step they belong to [s]
  double lifted_over_ = 0.0;
};

}  // namespace udar
