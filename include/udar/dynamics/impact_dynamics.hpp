#pragma once
/// @file
/// The motion of the filtered beam through its impacts, driven by a PETSc `TS`.

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "udar/contact/gap.hpp"
#include "udar/contact/support.hpp"
#include "udar/dynamics/equations.hpp"
#include "udar/petsc/handle.hpp"

namespace udar {

/// @brief What shapes the treatment of contact.
struct ContactParameters {
  double hop_tolerance = 1e-10;  ///< a mass whose next hop would stay below this rests instead [m], > 0
};

/// @brief Sums over the whole run so far; equal on every rank.
struct RunCounts {
  PetscInt steps = 0;           ///< accepted, repeated steps to an impact not counted
  PetscInt repeated_steps = 0;  ///< steps of exact length taken again to hit an event
  PetscInt rejected_steps = 0;  ///< by the error control
  PetscInt rhs_evaluations = 0;
  PetscInt impacts = 0;
  PetscInt rests = 0;
  PetscInt releases = 0;
  PetscInt resting = 0;              ///< masses at rest now
  double first_contact_time = -1.0;  ///< [s]; negative: none yet
  double last_contact_time = -1.0;   ///< last impact, or last instant some mass rested [s]; negative: none yet
};

/// @brief Smallest distance of the line from a support, over all contact points and steps.
struct LineGap {
  double gap = 0.0;   ///< [m]; negative: the line sank through
  double x = 0.0;     ///< [m]
  double time = 0.0;  ///< [s]
};

/// @brief Everything needed to go on from a step's end as if nothing had happened.
struct MotionState {
  std::map<std::string, std::vector<double>> fields;  ///< one value per local node
  std::map<std::string, double> scalars;              ///< equal on every rank
  std::map<std::string, std::vector<double>> tables;  ///< equal on every rank
};

/// @brief Integrates the filtered equations with a PETSc `TS` and lets masses hit, rest on and leave rigid supports.
///
/// After every step the end state is surveyed on the step's dense output. If a gap closes or a resting mass lifts
/// inside it, the step is taken back and repeated with exactly the length that leads to the first such instant,
/// corrected until the instant is met to round-off; then all masses that are there get their new velocities and the
/// integrator restarts. Source: docs/theory.md, "Contact in the post-step".
/// @note Options: all of `-ts_*`. Collective throughout. The referenced objects must outlive this one.
class ImpactDynamics {
 public:
  /// @throws InputError if a mass starts on the wrong side of a support, or `-ts_type` names an integrator that cannot
  /// be used
  ImpactDynamics(Equations& equations, std::vector<Support> supports, const InitialState& initial,
                 ContactParameters parameters = {});

  /// Adds a listener; it must outlive the run.
  void add_observer(Observer& observer);
  /// Asked once per step on every rank; when it says true on any rank the run stops after that step.
  void set_stop_request(std::function<bool()> stop) { stop_requested_ = std::move(stop); }

  /// @brief Runs from the present time to `-ts_max_time`.
  /// @throws SolveError if the integration or a line solve fails; the state is then that of the last good step
  void solve();

  [[nodiscard]] TS stepper() const noexcept { return stepper_; }
  [[nodiscard]] double time() const noexcept { return start_.time; }    ///< [s], of the last good step
  [[nodiscard]] double end_time() const noexcept { return end_time_; }  ///< [s]
  /// Whether the run reached its end (not stopped by a request or by `-ts_max_steps`).
  [[nodiscard]] bool completed() const noexcept { return completed_; }
  [[nodiscard]] const RunCounts& counts() const noexcept { return counts_; }
  [[nodiscard]] const std::vector<Support>& supports() const noexcept { return supports_; }
  [[nodiscard]] const EnergyLedger& energy() const noexcept { return ledger_; }  ///< at the last snapshot
  /// Ym and Vm of the local nodes after the last good step [m], [m/s].
  [[nodiscard]] MassState masses() const;

  /// y-up impulse of every support on the masses so far [N s]. @note Collective.
  [[nodiscard]] std::vector<double> support_impulses() const;
  /// @note Collective; meaningless without supports.
  [[nodiscard]] LineGap smallest_line_gap() const;

  /// The state after the last good step; any number of ranks may read it back.
  [[nodiscard]] MotionState save() const;
  /// Continues from a saved state. @note Before `solve`.
  void restore(const MotionState& state);

 private:
  struct Candidate {
    std::size_t point;
    double time;   // on the dense output [s]
    double slope;  // of the stretch at a release [m/s]
  };
  struct Due {
    Observer* observer;
    PetscInt next;  // multiple of its interval
  };

  void configure_stepper();
  void start();
  void right_hand_side(double time, Vec state, Vec rate);
  void after_step();

  void load_end(double time);
  double survey(double length);
  double hit(double event_time, double step_end);
  [[nodiscard]] double corrected_time(const Candidate& candidate, double time) const;
  double repeat_step(double time);
  void return_to_start();
  void resolve(double time, double resolution);
  void finish_step(double time, double next_step);
  void emit_snapshots(double until);
  void track_line_gap(double until);
  void track_resting_impulse(double until);
  [[nodiscard]] double changing_load_work(double until) const;

  [[nodiscard]] Kinematics kinematics(std::size_t node, const double* state, const LineState& line) const;
  [[nodiscard]] StepPolynomial polynomial(std::size_t node) const;
  [[nodiscard]] double line_gap(const ContactPoint& point, double theta) const;

  static PetscErrorCode rhs_callback(TS stepper, PetscReal time, Vec state, Vec rate, void* context);
  static PetscErrorCode post_step_callback(TS stepper);

  Equations* equations_;
  std::vector<Support> supports_;
  ContactParameters parameters_;
  std::vector<ContactPoint> points_;
  std::vector<std::uint8_t> resting_;  // per local node
  std::size_t count_;
  double wf2_;

  petsc::TimeStepper stepper_;
  petsc::Vector state_;        // [Ym, Vm] of the local nodes
  petsc::Vector start_state_;  // the same at the start of the step
  LineState start_;
  LineState end_;
  LineState last_;  // of the last right-hand side
  LineState scratch_;
  std::vector<double> start_rate_;  // d' [m/s], kept only while a mass rests
  std::vector<double> end_rate_;
  bool start_rate_valid_ = false;
  const double* start_values_ = nullptr;  // of start_state_ and state_ during the post-step
  const double* end_values_ = nullptr;
  bool first_stage_at_start_ = false;
  bool last_stage_at_end_ = false;
  double end_time_ = 0.0;
  double wanted_step_ = 0.0;
  bool step_was_cut_ = false;
  PetscInt events_at_once_ = 0;

  std::vector<Candidate> candidates_;
  std::vector<ImpactRecord> impacts_;
  std::vector<RestRecord> rests_;
  std::vector<double> impulse_;  // per support, local share
  LineGap line_gap_;             // local smallest

  std::vector<Observer*> observers_;
  std::vector<Due> due_;
  std::function<bool()> stop_requested_;
  EnergyLedger ledger_;
  double largest_kinetic_ = 0.0;
  double load_work_ = 0.0;  // local share up to the start of the step
  RunCounts counts_;
  bool started_ = false;
  bool restored_ = false;
  bool completed_ = false;
};

}  // namespace udar
