#pragma once
/// @file
/// The motion of the filtered beam through its impacts, driven by a PETSc `TS`.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "udar/integrators/integrator.hpp"
#include "udar/motion/contact_state.hpp"
#include "udar/motion/equations.hpp"
#include "udar/petsc/handle.hpp"

namespace udar {

/// @brief Sums over the whole run so far; equal on every rank.
struct RunCounts : ContactCounts {
  PetscInt steps = 0;           ///< accepted, repeated steps to an impact not counted
  PetscInt repeated_steps = 0;  ///< steps of exact length taken again to hit an event
  PetscInt rejected_steps = 0;  ///< by the error control
  PetscInt rhs_evaluations = 0;
  PetscInt row_line_solves = 0;  ///< for rows that observers asked for
};

/// @brief Integrates the filtered equations with a PETSc `TS` and lets masses hit, rest on and leave rigid supports.
///
/// `-ts_type chebyshev` (default where at most ten nodes can touch) and `impact` (else) meet impacts themselves; around
/// PETSc's own explicit types `LocatedSteps` does.
/// This class runs them: it takes snapshots from their dense output, keeps the energy ledger and tells the observers.
/// @note Options: all of `-ts_*`. Collective throughout. The referenced objects must outlive this one.
class ImpactDynamics {
 public:
  /// On `ContactSurface::line` the equations' line is held by the supports as long as this object lives.
  /// @throws InputError if a mass starts on the wrong side of a support, or `-ts_type` names an integrator that cannot
  /// be used
  ImpactDynamics(Equations& equations, std::vector<Support> supports, const InitialState& initial,
                 ContactParameters parameters = {});
  ImpactDynamics(const ImpactDynamics&) = delete;
  ImpactDynamics& operator=(const ImpactDynamics&) = delete;
  ~ImpactDynamics();

  /// Adds a listener; it must outlive the run.
  void add_observer(Observer& observer);
  /// Asked on every rank once per step, and between rows where a step has many; when it says true on any rank the run
  /// stops after that step, or before it and goes on after the last row when it is restarted.
  void set_stop_request(std::function<bool()> stop) { stop_requested_ = std::move(stop); }

  /// @brief Runs from the present time to `-ts_max_time`.
  /// @throws SolveError if the integration or a line solve fails; the state is then that of the last good step
  void solve();

  [[nodiscard]] TS stepper() const noexcept { return ts_; }
  [[nodiscard]] double time() const noexcept { return time_; }          ///< [s], of the last good step
  [[nodiscard]] double end_time() const noexcept { return end_time_; }  ///< [s]
  /// Whether the run reached its end (not stopped by a request or by `-ts_max_steps`).
  [[nodiscard]] bool completed() const noexcept { return completed_; }
  [[nodiscard]] RunCounts counts() const;
  /// What the integrator counts of its own, by name.
  [[nodiscard]] std::map<std::string, PetscInt> tally() const { return stepper_->tally(); }
  /// @brief Bytes that the integrator and its line solves so far had to move between memory and this rank; 0: not
  /// known.
  [[nodiscard]] double streamed_bytes() const;
  [[nodiscard]] const ContactState& contact() const noexcept { return contact_; }
  [[nodiscard]] const EnergyLedger& energy() const noexcept { return ledger_; }  ///< at the last snapshot
  /// What snapshots hold, in this order.
  [[nodiscard]] static std::vector<FieldInfo> fields();
  /// Ym and Vm of the local nodes after the last good step [m], [m/s].
  [[nodiscard]] MassState masses() const;

  /// y-up impulse of every support on the masses so far [N s], equal on every rank.
  [[nodiscard]] const std::vector<double>& support_impulses() const noexcept { return contact_.support_impulses(); }
  /// @note Collective; meaningless without supports.
  [[nodiscard]] LineGap smallest_line_gap() const { return contact_.smallest_line_gap(); }

  /// The state after the last good step, with what the observers keep; any number of ranks may read it back.
  [[nodiscard]] MotionState save() const;
  /// Continues from a saved state; observers are restored by who owns them. @note Before `solve`.
  void restore(const MotionState& state);

 private:
  struct Due {
    Observer* observer = nullptr;
    PetscInt next = 0;   // multiple of its interval
    bool ended = false;  // has had the row at the end of the run
  };

  void refuse_overlap(const MassState& masses) const;
  [[nodiscard]] TSType default_type() const;
  void refuse_on_line(const Support& support) const;
  void refuse_supports() const;
  void configure_stepper();
  void refuse_hops_without_length() const;
  void start();
  void after_step();
  [[nodiscard]] std::string fallen_through(double time) const;
  void refuse_standstill(double time);
  [[nodiscard]] double tolerated_energy() const;
  void limit_step(double next_step);
  void tell_events();
  void emit_snapshots(double until);
  [[nodiscard]] bool stop_between_rows(PetscInt rows) const;
  void snapshot(double time, double until);
  [[nodiscard]] std::vector<Field> shown_fields() const;
  [[nodiscard]] double changing_load_work(double until) const;
  [[nodiscard]] double piece_begin(double time) const;
  void jump_loads(double begin);
  [[nodiscard]] bool on_first_rank() const { return equations_->beam().begin() == 0; }
  static PetscErrorCode post_step_callback(TS stepper);

  Equations* equations_;
  std::optional<LineContact> line_contact_;
  std::vector<ContactSet> near_;  // nodes under supports, whoever touches
  ImpactProblem problem_;
  ContactState contact_;
  std::size_t count_;
  petsc::TimeStepper ts_;
  petsc::Vector state_;  // [Ym, Vm] of the local nodes
  std::unique_ptr<Integrator> located_;
  Integrator* stepper_ = nullptr;  // inside ts_, or located_
  double time_ = 0.0;
  double end_time_ = 0.0;
  double wanted_step_ = 0.0;
  bool step_was_cut_ = false;
  PetscInt events_at_once_ = 0;
  PetscInt short_steps_ = 0;

  std::vector<Observer*> observers_;
  std::vector<Due> due_;
  std::function<bool()> stop_requested_;
  double last_row_time_ = 0.0;  // later than time_ only where a stop came between the rows of a step
  MassState shown_;             // of the snapshot at hand
  std::vector<std::uint8_t> shown_resting_;
  LineState shown_line_;
  std::vector<double> shown_shear_;
  std::vector<double> shown_impulse_;  // of each support
  EnergyLedger ledger_;
  PetscInt row_line_solves_ = 0;
  std::vector<double> kinks_;  // of loads and moving supports, ascending [s]
  bool flows_ = false;         // energy flows through supports or dampers
  double load_work_ = 0.0;     // local share up to the start of the step
  PetscInt steps_ = 0;
  PetscInt rejected_steps_ = 0;
  bool started_ = false;
  bool restored_ = false;
  bool completed_ = false;
};

}  // namespace udar
