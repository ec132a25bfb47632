#pragma once
/// @file
/// Impacts located on the steps of PETSc's explicit integrators.

#include <array>
#include <cstdint>
#include <vector>

#include "udar/contact/elastic_touch.hpp"
#include "udar/integrators/integrator.hpp"
#include "udar/numerics/step_polynomial.hpp"
#include "udar/petsc/handle.hpp"

namespace udar {

/// @brief Lets TSRK, TSEULER and TSSSP meet impacts.
///
/// After every accepted step the end state is surveyed on the step's dense output. If a gap closes or a resting mass
/// lifts inside it, the step is taken back and repeated with exactly the length that leads to the first such instant,
/// corrected until the instant is met to round-off; then all masses that are there get their new velocities and the
/// integrator restarts. Source: docs/theory.md, "Contact in the post-step".
class LocatedSteps final : public Integrator {
 public:
  /// Sets the right-hand side of `stepper`, whose solution vector is set: Ym, then Vm of the local nodes.
  LocatedSteps(TS stepper, const ImpactProblem& problem);

  void start(const LineState& line) override;
  void begin_step() override;
  double end_step() override;
  void apply_events() override;
  void return_to_start() override;
  [[nodiscard]] double next_step() const override { return next_step_; }
  void masses(double time, std::span<double> position, std::span<double> velocity,
              std::span<std::uint8_t> resting) const override;
  [[nodiscard]] double line_integral(std::size_t node, double until) const override;
  [[nodiscard]] EnergyFlow flow(double until) const override;
  [[nodiscard]] std::vector<double> amplitude_integrals(double until) const override;
  [[nodiscard]] std::span<const double> start_of_step() const override { return {start_values_, 2 * count_}; }
  [[nodiscard]] PetscInt repeated_steps() const override { return repeated_steps_; }
  [[nodiscard]] PetscInt evaluations() const override { return evaluations_; }
  void save(MotionState& state) const override;
  void restore(const MotionState& state) override;

 private:
  struct Candidate {
    const ContactSet* run = nullptr;
    std::size_t node = 0;
    double time = 0.0;   // on the dense output [s]
    double slope = 0.0;  // of the stretch at a release [m/s]
    bool opens = false;  // a closed gap
    double met = 0.0;    // as the last repeated step corrected its time [s]
  };
  /// What a support gives a mass, over its mass, from the start of the step to a share of it.
  struct Given {
    double push = 0.0;  // [m/s]
    EnergyFlow flow;    // [m^2/s^2]
  };

  void set_absolute_tolerance();
  void right_hand_side(double time, Vec state, Vec rate);
  void load_end(double time);
  double survey(double length);
  void add_candidate(Candidate candidate);
  void survey(const ContactSet& run, std::size_t node, double length);
  double hit(double event_time, double step_end);
  [[nodiscard]] double corrected_time(const Candidate& candidate, double time) const;
  double repeat_step(double time);
  void track_contact();
  void find_accelerations(const double* state, const LineState& line, const std::vector<double>& rate,
                          std::vector<double>& result, std::vector<double>& bend);
  void survey_touch(const ContactSet& run, std::size_t node, double length);
  void ride();
  void change_touches();
  [[nodiscard]] std::size_t index_of(const ContactSet& run) const {
    return static_cast<std::size_t>(&run - contact_->runs().data());
  }
  /// Open where the support is rigid.
  [[nodiscard]] ElasticTouch touch_of(const ContactSet& run, std::size_t node) const {
    return run.elastic() ? touches_[index_of(run)][node - run.first] : ElasticTouch{};
  }
  /// Gap of a mass and its rates.
  [[nodiscard]] Kinematics gap(const ContactSet& run, const Kinematics& mass, std::size_t node, double time) const;
  [[nodiscard]] bool is_due(const Candidate& candidate) const {
    return candidate.met <= end_.time + 2.0 * time_resolution(end_.time);
  }
  /// d' by loads alone over the step at hand [m/s].
  [[nodiscard]] double load_rate(std::size_t node) const { return load_rate_.empty() ? 0.0 : load_rate_[node]; }
  [[nodiscard]] double damper_rate(std::size_t node, double theta) const;
  [[nodiscard]] double resting_stretch(std::size_t node, double theta) const;
  /// Stretch of the line over the step, where the structure is damped.
  [[nodiscard]] StepPolynomial stretch_polynomial(std::size_t node) const;
  [[nodiscard]] double stretch(const ContactSet& run, std::size_t node, double theta) const;
  /// What pulls a mass at rest off its support, as stretch [m], and its rate.
  struct Pull {
    double value;
    double rate;
  };
  [[nodiscard]] Pull pull(const ContactSet& run, std::size_t node, bool at_end) const;
  [[nodiscard]] double contact_acceleration(const ContactSet& run, std::size_t node, const Kinematics& mass,
                                            double time) const;
  [[nodiscard]] Given given(const ContactSet& run, std::size_t node, double theta) const;
  void track_line_contact();
  void save_forces(const LineContact& contact, MotionState& state) const;
  void restore_forces(const LineContact& contact, const MotionState& state, LineState& line) const;
  [[nodiscard]] std::vector<int> layers(const LineContact& contact) const;
  [[nodiscard]] Kinematics kinematics(std::size_t node, const double* state, const LineState& line) const;
  [[nodiscard]] StepPolynomial polynomial(std::size_t node) const;
  [[nodiscard]] double line_gap(const ContactSet& run, std::size_t node, double theta) const;
  [[nodiscard]] double amplitude_offset(std::size_t node, double theta) const;
  static PetscErrorCode rhs_callback(TS stepper, PetscReal time, Vec state, Vec rate, void* context);

  TS stepper_;
  Equations* equations_;
  ContactState* contact_;
  std::size_t count_;
  double wf2_;
  MotionScale scale_;
  petsc::Vector absolute_;  // tolerance; null: -ts_atol
  bool first_stage_at_start_ = false;
  bool last_stage_at_end_ = false;
  Vec state_ = nullptr;
  petsc::Vector start_state_;
  LineState start_;
  LineState end_;
  LineState last_;                  // of the last right-hand side
  std::vector<double> start_rate_;  // d(Vm) [m/s], kept only while a mass rests or the structure is damped
  std::vector<double> end_rate_;
  std::span<const double> load_rate_;  // what changing loads add to both
  bool start_rate_valid_ = false;
  const double* start_values_ = nullptr;  // of start_state_ and state_
  const double* end_values_ = nullptr;
  double next_step_ = 0.0;
  bool event_ = false;
  bool plain_ = true;  // all supports are rigid and at rest, and nothing is damped
  Damping damping_;
  std::vector<double> stage_rate_;  // d(Vm) [m/s] at the stage at hand
  std::vector<double> start_bend_;  // d'' [m/s^2] at both ends, kept where the structure is damped
  std::vector<double> end_bend_;
  std::vector<std::vector<ElasticTouch>> touches_;  // by run that is not rigid, then node
  // By which supports that move and hold the line bring energy in: at the start, middle and end of the step [W].
  std::array<double, 3> power_{};
  std::vector<double> start_acceleration_;  // [m/s^2], kept unless `plain_`
  std::vector<double> end_acceleration_;
  std::vector<Candidate> candidates_;
  PetscInt repeated_steps_ = 0;
  PetscInt evaluations_ = 0;
};

}  // namespace udar
