#pragma once
/// @file
/// Impacts located on the steps of PETSc's explicit integrators.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "udar/integrators/event_search.hpp"
#include "udar/integrators/integrator.hpp"
#include "udar/integrators/line_contact_record.hpp"
#include "udar/integrators/step_motion.hpp"
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
  static constexpr Features kCan{
      Feature::filtered,     Feature::line_contact, Feature::moving_supports, Feature::elastic_supports,
      Feature::elastic_line, Feature::many_points,  Feature::mass_damping,    Feature::stiffness_damping,
      Feature::friction,     Feature::strikers,     Feature::riders};

  /// Sets the right-hand side of `stepper`, whose solution vector is set: Ym, then Vm of the local nodes.
  /// @param own_absolute_tolerance of the step control, relative to the motion's scale, instead of the TS's
  LocatedSteps(TS stepper, const ImpactProblem& problem, bool own_absolute_tolerance);

  [[nodiscard]] Features can() const override { return kCan; }
  void start(const LineState& line) override;
  void take_over(const LineState& line) override;
  void begin_step() override;
  double end_step() override;
  void apply_events() override;
  void rub_pressed();
  void return_to_start() override;
  [[nodiscard]] double next_step() const override { return next_step_; }
  void masses(double time, std::span<double> position, std::span<double> velocity,
              std::span<std::uint8_t> resting) const override {
    motion_.masses(time, position, velocity, resting);
  }
  void line_integrals(std::span<const std::size_t> nodes, double until, std::span<double> integrals) const override {
    std::ranges::transform(nodes, integrals.begin(),
                           [&](std::size_t node) { return motion_.line_integral(node, until); });
  }
  void mass_integrals(double until, std::span<double> integrals) const override {
    for (std::size_t node = 0; node < integrals.size(); ++node) {
      integrals[node] = motion_.mass_integral(node, until);
    }
  }
  [[nodiscard]] EnergyFlow flow(double until) const override;
  [[nodiscard]] std::vector<double> amplitude_integrals(double until) const override {
    return motion_.amplitude_integrals(until);
  }
  [[nodiscard]] std::span<const double> start_of_step() const override { return {motion_.start().values, 2 * count_}; }
  [[nodiscard]] PetscInt repeated_steps() const override { return repeated_steps_; }
  [[nodiscard]] PetscInt evaluations() const override { return evaluations_; }
  void save(MotionState& state) const override;
  void restore(const MotionState& state) override;

 private:
  void set_absolute_tolerance();
  void right_hand_side(double time, Vec state, Vec rate);
  void load_end(double time);
  void find_rate(StepEnd& end);
  double locate(double event_time, double step_end);
  double repeat_step(double time);
  void track_contact();
  void follow_supports();
  void change_touches();
  static PetscErrorCode rhs_callback(TS stepper, PetscReal time, Vec state, Vec rate, void* context);

  TS stepper_;
  Equations* equations_;
  ContactState* contact_;
  std::size_t count_;
  MotionScale scale_;
  petsc::Vector absolute_;  // tolerance; null: -ts_atol
  bool first_stage_at_start_ = false;
  bool last_stage_at_end_ = false;
  Vec state_ = nullptr;
  petsc::Vector start_state_;
  StepMotion motion_;
  EventSearch search_;
  std::optional<LineContactRecord> line_contact_;
  LineState last_;                  // of the last right-hand side
  std::vector<double> stage_rate_;  // d(Vm) [m/s] at the stage at hand
  bool start_rate_valid_ = false;
  bool event_ = false;  // at the end of the step
  double next_step_ = 0.0;
  PetscInt repeated_steps_ = 0;
  PetscInt evaluations_ = 0;
};

/// @name PETSc's own types that it serves: explicit, with dense output or exact repetition of a step.
/// @{
inline constexpr IntegratorType kRungeKuttaType{.name = TSRK,
                                                .can = LocatedSteps::kCan,
                                                .knows = "it knows the filtered beam alone",
                                                .enroll = nullptr,
                                                .default_up_to = std::numeric_limits<std::int64_t>::max()};
inline constexpr IntegratorType kEulerType{
    .name = TSEULER, .can = LocatedSteps::kCan, .knows = "it knows the filtered beam alone", .enroll = nullptr};
inline constexpr IntegratorType kStabilityPreservingType{
    .name = TSSSP, .can = LocatedSteps::kCan, .knows = "it knows the filtered beam alone", .enroll = nullptr};
/// @}

}  // namespace udar
