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

  /// @brief Minus the integral of dF/dt' Yc from the start of the step to a time within it [J], this rank's share: what
  /// changing loads bring in. @note Collective.
  [[nodiscard]] double load_work(const DenseOutput& step, double step_begin, double until) const;
  /// Ends a step in which changing loads brought this in [J], this rank's share.
  void end_step(double load_work) noexcept { load_work_ += load_work; }
  /// @brief This rank's share of the energy at an instant [J]: where loads jump the line follows at once, and what that
  /// changes they have done. @param[out] line then, with moment @note Collective: a line solve.
  [[nodiscard]] double energy(const Instant& at, std::span<const double> position, std::span<const double> velocity,
                              LineState& line);

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
  [[nodiscard]] std::vector<double> changed_by(const LoadPattern& pattern, const DenseOutput& step, double step_begin,
                                               double until, std::span<const double> amplitudes) const;
  [[nodiscard]] bool on_first_rank() const { return equations_->points().begin() == 0; }

  Equations* equations_;
  const ContactState* contact_;
  const Kinks* kinks_;
  bool flows_;  // through supports or dampers
  EnergyLedger ledger_;
  double load_work_ = 0.0;  // local share up to the start of the step
};

}  // namespace udar
