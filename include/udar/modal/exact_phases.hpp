#pragma once
/// @file
/// The exact motion of a reduced model with few contact points.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <optional>
#include <span>
#include <vector>

#include "udar/modal/phase_basis.hpp"
#include "udar/modal/phase_motion.hpp"
#include "udar/modal/reduced_model.hpp"
#include "udar/numerics/complementarity.hpp"

namespace udar {

/// @brief From one change of contact to the next in closed form; there is no time step, and no error but rounding.
///
/// Source: docs/theory.md, "The modal integrator"
class ExactPhases {
 public:
  /// More contact points than these have too many sets that may touch.
  static constexpr std::size_t kMostPoints = Complementarity::kMostFollowed;

  /// @param model conservative, with at most `kMostPoints`; must outlive this object
  explicit ExactPhases(const ReducedModel& model);

  /// @brief Takes up the motion; forces follow from where the modes are, so that supports may press on it from the
  /// start. Also where the drive changes its course.
  void start(const ModalState& state, const Drive& drive);
  /// @brief Takes the motion up within a phase. @param entered the state at which the phase began
  void resume(const ModalState& entered, const Drive& drive, double time);
  /// @brief Goes on to a time [s], or to the first change of contact before. @return the time reached
  double advance(double until);

  [[nodiscard]] const ModalState& now() const noexcept { return state_; }
  /// The state at a time since the last change of contact or start [s].
  [[nodiscard]] ModalState at(double time) const;
  /// The state then, from which `resume` goes on to the same bits.
  [[nodiscard]] const ModalState& entered() const noexcept { return entered_; }
  /// The motion since then.
  [[nodiscard]] const PhaseMotion& phase() const noexcept { return *motion_; }
  [[nodiscard]] std::size_t changes() const noexcept { return changes_; }
  [[nodiscard]] std::size_t evaluations() const noexcept { return evaluations_ + motion_->evaluations(); }
  [[nodiscard]] const Drive& drive() const noexcept { return drive_; }

 private:
  void enter_phase();
  void change(const std::vector<std::size_t>& due);
  [[nodiscard]] std::vector<double> gap_rates() const;
  [[nodiscard]] std::vector<double> gap_accelerations() const;

  const ReducedModel* model_;
  Complementarity closed_;
  std::list<PhaseBasis> bases_;
  ModalState state_;
  ModalState entered_;
  Drive drive_;
  std::optional<PhaseMotion> motion_;
  std::size_t changes_ = 0;
  std::size_t evaluations_ = 0;
};

}  // namespace udar
