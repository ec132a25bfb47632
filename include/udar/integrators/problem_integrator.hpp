#pragma once
/// @file
/// What the TS types registered here have in common: the problem composed with the TS, and the bounds of a step.

#include <petscts.h>

#include <cstddef>
#include <cstdint>
#include <span>

#include "udar/integrators/integrator.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/handle.hpp"
#include "udar/petsc/time_integrator.hpp"

namespace udar {

/// @brief Gives a `TS` of a type registered here what it integrates; its solution is Ym, then Vm of the local nodes.
/// @param problem must outlive the stepper's use; whoever runs the TS ends each step by `ContactState::commit` and
/// `begin_step`, as `ImpactDynamics` does
void compose_problem(TS stepper, const ImpactProblem& problem);

/// @brief The dense output of a `TS` whose type is registered here; null for any other.
[[nodiscard]] Integrator* integrator_inside(TS stepper);

/// @brief The inside of a TS type that meets impacts within its own steps.
class ProblemIntegrator : public petsc::TimeIntegrator, public Integrator {
 public:
  /// @throws InputError if no problem is composed with the TS
  void set_up(TS stepper) final;
  void step(TS stepper) final;
  void roll_back(TS stepper) final;
  void interpolate(TS stepper, double time, Vec solution) final;

  void begin_step() override;
  double end_step() final;
  void apply_events() final {}
  void return_to_start() final;
  void masses(double time, std::span<double> position, std::span<double> velocity,
              std::span<std::uint8_t> resting) const final;
  [[nodiscard]] std::span<const double> start_of_step() const final { return {start_, 2 * count_}; }

 protected:
  /// `-ts_rtol`, unless it is given.
  static void set_default_tolerance(TS stepper, double rtol);
  /// Called once, when all members below are known.
  virtual void prepare() = 0;
  /// Takes a step: from `enter_step` to `leave_step`. What it has put into the TS's solution is taken back if it throws
  /// or fails. @return whether it succeeded
  virtual bool advance() = 0;
  /// Forgets the step at hand; state and contact are already those of its start.
  virtual void take_back() = 0;
  /// `masses` at a time since the start of the step at hand.
  virtual void within(double elapsed, std::span<double> position, std::span<double> velocity,
                      std::span<std::uint8_t> resting) const = 0;

  /// Keeps the state to start from. @return the step length wished for, at most `longest` and to the end of the run [s]
  double enter_step(double longest);
  /// Ends the step, whose end is in the TS's solution. @param length, next of this step and of the next [s]
  void leave_step(double length, double next);
  [[nodiscard]] PetscInt steps() const;
  [[nodiscard]] SolveError not_finite() const;

  TS ts_ = nullptr;
  Equations* equations_ = nullptr;
  ContactState* contact_ = nullptr;
  const Contacts* contacts_ = nullptr;
  const Kinks* kinks_ = nullptr;
  MotionScale scale_;
  double wf_ = 0.0;
  double highest_ = 0.0;  // no frequency is higher [rad/s]: wf but for corrected modes
  double tolerance_ = 0.0;
  std::size_t count_ = 0;
  Vec state_ = nullptr;
  petsc::Vector start_state_;
  const double* start_ = nullptr;  // its values
  double begin_ = 0.0;             // of the step at hand [s]
  double length_ = 0.0;            // [s]
  bool stepped_ = false;           // between the end of a step and the beginning of the next
};

}  // namespace udar
