#pragma once
/// @file
/// The energy ledger of a motion, and what it says about the integration.

#include <span>
#include <vector>

#include "udar/motion/contact_state.hpp"
#include "udar/motion/dense_output.hpp"
#include "udar/motion/equations.hpp"
#include "udar/motion/kinks.hpp"
#include "udar/motion/motion_state.hpp"
#include "udar/structure/initial_state.hpp"

namespace udar {

/// @brief Keeps the energy ledger from row to row: what is stored, what loads and supports brought in, what is lost.
/// Source: docs/theory.md, "Energy"
class EnergyBalance {
 public:
  /// @brief The state at one time of the step at hand.
  struct Row {
    double time;            ///< [s]
    double step_begin;      ///< [s]
    const LineState& line;  ///< with moment
    const MassState& masses;
  };

  /// The referenced objects must outlive this one.
  EnergyBalance(Equations& equations, const ContactState& contact, const Kinks& kinks);

  /// At the last row.
  [[nodiscard]] const EnergyLedger& ledger() const noexcept { return ledger_; }

  /// @brief Takes the state at t = 0, springs that are pressed there included, as that from which heights, work and
  /// losses count. @param step before it is taken @note Collective.
  void start(const Row& row, const DenseOutput& step);

  /// What forces that change bring in, minus the integral of dF/dt' Yc [J], and what moves masses that travel, this
  /// rank's share.
  struct Work {
    double loads = 0.0;
    double base = 0.0;  ///< by inertia forces, and by places that hold the structure and move
  };
  /// @brief From the start of the step to a time within it. @note Collective.
  [[nodiscard]] Work load_work(const DenseOutput& step, double step_begin, double until) const;
  /// Ends a step in which forces that change brought this in.
  void end_step(const Work& work) noexcept {
    work_.loads += work.loads;
    work_.base += work.base;
  }
  /// @brief Before forces jump, or after: where they do the line follows at once, and what that changes they have done.
  struct Side {
    double energy;              ///< with the potential of all forces, this rank's share [J]
    std::vector<double> place;  ///< of the line [m]
  };
  /// @param[out] line then, with moment @note Collective: a line solve.
  [[nodiscard]] Side side(const Instant& at, std::span<const double> position, std::span<const double> velocity,
                          LineState& line);
  /// @param end of the step at which forces jump @param gained by springs that the integrator alone knows [J]
  void end_jump(const Instant& end, const Side& before, const Side& after, double gained);

  /// @brief Makes the ledger of a row, and keeps it unless an energy is not finite. @param[in,out] besides is added up
  /// over the ranks in the same reduction @param tolerated_energy error that all steps so far may have made [J]
  /// @note Collective: two reductions.
  EnergyLedger update(const Row& row, const DenseOutput& step, std::span<double> besides, double tolerated_energy);

  /// @name For a restart. @note `save` is collective.
  /// @{
  void save(MotionState& state) const;
  void restore(const MotionState& state);
  /// @}

 private:
  [[nodiscard]] double travel_work(const DenseOutput& step, double step_begin, double until) const;
  [[nodiscard]] std::vector<double> changed_by(const LoadPattern& pattern, const DenseOutput& step, double step_begin,
                                               double until, std::span<const double> amplitudes) const;
  [[nodiscard]] bool on_first_rank() const { return equations_->points().begin() == 0; }

  Equations* equations_;
  const ContactState* contact_;
  const Kinks* kinks_;
  bool works_;  // by loads that change, or masses that travel
  bool flows_;  // through supports or dampers
  EnergyLedger ledger_;
  Work work_;  // up to the start of the step
};

}  // namespace udar
