#pragma once
/// @file
/// The motion of the filtered beam through its impacts, driven by a PETSc `TS`.

#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "udar/dynamics/guards.hpp"
#include "udar/dynamics/model.hpp"
#include "udar/dynamics/run_checks.hpp"
#include "udar/dynamics/snapshot_schedule.hpp"
#include "udar/integrators/configure.hpp"
#include "udar/motion/contact_state.hpp"
#include "udar/motion/energy_balance.hpp"
#include "udar/motion/kinks.hpp"
#include "udar/motion/motion_state.hpp"
#include "udar/petsc/handle.hpp"

namespace udar {

/// @brief Sums over the whole run so far; equal on every rank.
struct RunCounts : ContactCounts {
  PetscInt steps = 0;           ///< accepted, repeated steps to an impact not counted
  PetscInt repeated_steps = 0;  ///< steps of exact length taken again to hit an event
  PetscInt rejected_steps = 0;  ///< by the error control
  PetscInt rhs_evaluations = 0;
  PetscInt row_line_solves = 0;    ///< for rows that observers asked for
  PetscInt line_solves = 0;        ///< since the first step, those for rows included
  PetscInt setup_line_solves = 0;  ///< before it, in this program
};

/// @brief Runs a model with a PETSc `TS`: its masses hit, rest on and leave supports.
///
/// `configure_stepping` chooses the integrator. This class takes snapshots from its dense output, ends steps at kinks
/// and events, keeps the energy balance and tells the observers.
/// @note Options: all of `-ts_*`. Collective throughout.
class ImpactDynamics {
 public:
  /// @param model must outlive this object
  /// @throws InputError if a mass starts on the wrong side of a support, or `-ts_type` names an integrator that cannot
  /// be used
  explicit ImpactDynamics(Model& model);
  ImpactDynamics(const ImpactDynamics&) = delete;
  ImpactDynamics& operator=(const ImpactDynamics&) = delete;
  ~ImpactDynamics() = default;

  /// Adds a listener; it must outlive the run.
  void add_observer(Observer& observer) { schedule_.add(observer); }
  /// Asked on every rank once per step, and between rows where a step has many; when it says true on any rank the run
  /// stops after that step, or before it and goes on after the last row when it is restarted.
  void set_stop_request(std::function<bool()> stop) { requests_.stop = std::move(stop); }
  /// Asked after every step on every rank: any answer of true is in the `Progress` of all.
  void set_checkpoint_request(std::function<bool()> wanted) { requests_.checkpoint = std::move(wanted); }
  /// The folder in which what happens in a step waits that is too much to be held; by default the system's for such
  /// files. @see StepRecords
  void set_scratch_folder(const std::string& folder) { contact_.set_scratch_folder(folder); }
  /// What becomes of a run that is worth a warning; by default nothing, as where errors are what is looked for.
  void set_guard(GuardMode mode) noexcept { guards_.set_mode(mode); }

  /// @brief Runs from the present time to `-ts_max_time`, and tells the observers that this was all.
  /// @throws SolveError if the integration or a line solve fails, or a guard ends the run; the state is then that of
  /// the last good step
  void solve();
  /// @brief The same up to the end of the first step that reaches a time [s], or to where the run ends: steps are those
  /// of a run in one go, to the bit. Observers are not told of an end.
  /// @throws as `solve`
  void advance(double until);
  /// @brief One step, whatever its length. @throws as `solve`
  void step() { advance(time_ + 2.0 * time_resolution(time_) + std::numeric_limits<double>::min()); }

  [[nodiscard]] TS stepper() const noexcept { return stepping_.ts; }
  [[nodiscard]] double time() const noexcept { return time_; }                           ///< [s], of the last good step
  [[nodiscard]] double end_time() const noexcept { return stepping_.end_time; }          ///< [s]
  [[nodiscard]] double motion_length() const noexcept { return problem_.scale.length; }  ///< that of its scale [m]
  /// Whether the run reached its end (not stopped by a request or by `-ts_max_steps`).
  [[nodiscard]] bool completed() const noexcept { return completed_; }
  [[nodiscard]] RunCounts counts() const;
  /// What the integrator counts of its own, by name, since t = 0.
  [[nodiscard]] std::map<std::string, PetscInt> tally() const;
  /// @brief Bytes that the integrator and its line solves so far had to move between memory and this rank; 0: not
  /// known.
  [[nodiscard]] double streamed_bytes() const;
  [[nodiscard]] const ContactState& contact() const noexcept { return contact_; }
  [[nodiscard]] const EnergyLedger& energy() const noexcept { return balance_.ledger(); }  ///< at the last snapshot
  /// What snapshots hold, in this order.
  [[nodiscard]] std::vector<FieldInfo> fields() const;
  /// Ym and Vm of the local nodes after the last good step [m], [m/s].
  [[nodiscard]] MassState masses() const;
  /// @brief Yc of the local nodes then [m]. @note Collective: a line solve.
  [[nodiscard]] std::vector<double> line_position() {
    const std::vector<double> position = masses().position;
    LineState line;
    model_->equations.evaluate(time_, position, line);
    return model_->equations.line_position(line, position);
  }

  /// y-up impulse of every support on the masses so far [N s], equal on every rank.
  [[nodiscard]] const std::vector<double>& support_impulses() const noexcept { return contact_.support_impulses(); }
  /// @note Collective; meaningless without supports.
  /// Null: the line stays elastic.
  [[nodiscard]] const HingedLine* hinges() const noexcept { return model_->equations.hinges(); }
  [[nodiscard]] LineGap smallest_line_gap() const { return contact_.smallest_line_gap(); }

  /// The state after the last good step, with what the observers keep; any number of ranks may read it back.
  [[nodiscard]] MotionState save() const;
  /// Continues from a saved state, of another integrator from its masses and contact alone; observers are restored by
  /// who owns them. @note Before `solve`; collective.
  void restore(const MotionState& state);
  /// `-ts_type`, and whether it goes on bit by bit from what one of that name has saved.
  [[nodiscard]] std::string integrator() const { return stepping_.name(); }
  [[nodiscard]] bool goes_on_from(std::string_view integrator) const { return stepping_.goes_on_from(integrator); }

 private:
  /// What observers see of one time.
  struct Row {
    MassState masses;
    std::vector<std::uint8_t> resting;
    std::vector<std::uint8_t> touched;  ///< since the last row of the listener at hand
    LineState line;
    std::vector<double> line_position;
    std::vector<double> internal;    ///< of the operator's internal fields, one behind the other
    std::vector<double> rotation{};  ///< plastic, of the local nodes; empty: the line stays elastic
    std::vector<double> support_impulse;
    std::vector<PlaceState> places{};  ///< that hold the structure and move
    std::vector<RiderState> riders{};
  };

  [[nodiscard]] petsc::Vector place_masses(const InitialState& initial);
  void start();
  void take_over();
  void settle_at_start();
  void after_step();
  struct Asked {
    bool stop = false;
    bool checkpoint = false;
  };
  [[nodiscard]] Asked judge_step(double time);
  void limit_step(double next_step);
  void tell_events();
  void tell_progress(bool checkpoint);
  [[nodiscard]] std::map<std::string, PetscInt> counted_here() const;
  [[nodiscard]] std::map<std::string, PetscInt> counted() const;
  void emit_snapshots(double until);
  [[nodiscard]] bool stop_between_rows(PetscInt rows) const;
  void fill(Row& row, double time, double until);
  [[nodiscard]] std::vector<Field> fields_of(const Row& row) const;
  [[nodiscard]] double tolerated_energy() const;
  void jump_loads(double begin);
  [[nodiscard]] std::size_t count() const { return model_->line.mass().size(); }
  static PetscErrorCode post_step_callback(TS stepper);

  Model* model_;
  ImpactProblem problem_;
  ContactState contact_;
  Kinks kinks_;
  EnergyBalance balance_;
  Guards guards_;
  petsc::Vector state_;  // [Ym, Vm] of the local nodes
  Stepping stepping_;
  SnapshotSchedule schedule_;
  StandstillGuard standstill_;
  struct Requests {
    std::function<bool()> stop;
    std::function<bool()> checkpoint;
    double until = 0.0;  // a step that reaches this time is the last for now [s]
  } requests_;
  double time_ = 0.0;
  double wanted_step_ = 0.0;
  bool step_was_cut_ = false;
  double last_row_time_ = 0.0;  // later than time_ only where a stop came between the rows of a step
  struct Counters {
    PetscInt row_line_solves = 0;
    PetscInt rejected_steps = 0;
    PetscInt setup_line_solves = 0;
    std::map<std::string, PetscInt> before;  // in earlier programs, less than what was counted here before
  } counters_;
  PetscInt steps_ = 0;
  enum class Phase : std::uint8_t { fresh, restored, running } phase_ = Phase::fresh;
  bool completed_ = false;
};

}  // namespace udar
