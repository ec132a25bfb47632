#pragma once
/// @file
/// The exact motion of a reduced model with few contact points.

#include <cstddef>
#include <cstdint>
#include <list>
#include <optional>
#include <span>
#include <vector>

#include "udar/modal/modal_motion.hpp"
#include "udar/modal/phase_basis.hpp"
#include "udar/modal/phase_motion.hpp"
#include "udar/modal/reduced_model.hpp"
#include "udar/numerics/complementarity.hpp"

namespace udar {

/// @brief From one change of contact to the next in closed form; there is no time step, and no error but rounding.
///
/// Source: docs/theory.md, "The modal integrator"
class ExactPhases final : public ModalMotion {
 public:
  /// More contact points than these have too many sets that may touch.
  static constexpr std::size_t kMostPoints = Complementarity::kMostFollowed;

  /// @param model conservative, with at most `kMostPoints`; must outlive this object
  explicit ExactPhases(const ReducedModel& model);

  void start(const ModalState& state, const Drive& drive) override;
  /// @pre nothing moves
  void turn(const Drive& drive, bool /*jump*/) override { start(state_, drive); }
  /// To a time [s], or to the first change of contact before.
  double advance(double until) override;
  void take_back() override { resume(before_, drive_, last_begin_); }

  [[nodiscard]] const ModalState& now() const noexcept override { return state_; }
  [[nodiscard]] ModalState at(double time) const override;
  [[nodiscard]] std::vector<ModalContact> contacts() const override;
  [[nodiscard]] ModalFlow flow(double until) const override;
  [[nodiscard]] ModalMemory memory() const override { return {.entered = entered_}; }
  void resume(const ModalMemory& memory, const Drive& drive, double time) override;
  [[nodiscard]] std::size_t count() const noexcept override { return changes_; }
  [[nodiscard]] std::size_t evaluations() const noexcept { return evaluations_ + motion_->evaluations(); }

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
  std::optional<PhaseMotion> last_;  // of the last step
  double last_begin_ = 0.0;
  double last_end_ = 0.0;
  ModalMemory before_;  // that step
  std::size_t changes_ = 0;
  std::size_t evaluations_ = 0;
};

}  // namespace udar
