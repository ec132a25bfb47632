#pragma once
/// @file
/// What contact on the line does in a step of PETSc's explicit integrators.

#include <array>
#include <cstddef>
#include <vector>

#include "udar/integrators/step_motion.hpp"

namespace udar {

/// @brief Impulses, work and times of the contact forces on the line over a step, by Simpson's rule, and these forces
/// in a restart file.
class LineContactRecord {
 public:
  /// All outlive this object; the equations have contact on the line.
  LineContactRecord(Equations& equations, ContactState& contact) : equations_{&equations}, contact_{&contact} {}

  /// A new step has begun.
  void begin_step() noexcept { power_ = {}; }
  /// @brief Writes the journal of the step. @note Collective: one more line solve.
  void track(const StepMotion& motion);
  /// What supports that move brought in up to a share of the step [J], this rank's share.
  [[nodiscard]] double work(double length, double share) const;

  /// @note Collective.
  void save(const LineState& line, std::size_t count, MotionState& state) const;
  void restore(const MotionState& state, std::size_t count, LineState& line) const;

 private:
  [[nodiscard]] std::vector<int> layers(std::size_t count) const;

  Equations* equations_;
  ContactState* contact_;
  // Of supports that move and press on the line: at the start, middle and end of the step [W].
  std::array<double, 3> power_{};
};

}  // namespace udar
