#pragma once
/// @file
/// Time integrators of our own as PETSc types.

#include <petscts.h>

#include <memory>
#include <string>

#include "udar/petsc/log.hpp"

namespace udar::petsc {

/// @brief What a registered `TS` type does. Members may throw; PETSc sees error codes.
class TimeIntegrator {
 public:
  TimeIntegrator() = default;
  TimeIntegrator(const TimeIntegrator&) = delete;
  TimeIntegrator& operator=(const TimeIntegrator&) = delete;
  virtual ~TimeIntegrator() = default;

  /// @brief Reads options, in PETSc's way: listed by -help.
  /// @param PetscOptionsObject under the name that PETSc's macros need
  virtual void set_from_options(TS stepper, PetscOptionItems* PetscOptionsObject) = 0;
  /// Before the first step.
  virtual void set_up(TS stepper) = 0;
  /// Advances solution vector, time and proposed step length. On failure the TS must be as before the call.
  virtual void step(TS stepper) = 0;
  /// Puts the solution vector back to the start of the last step.
  virtual void roll_back(TS stepper) = 0;
  /// The solution at a time within the last step.
  virtual void interpolate(TS stepper, double time, Vec solution) = 0;
  /// Error estimate over tolerance of the step at hand for `TSAdapt`; negative: none.
  struct Error {
    double norm;
    int order;
  };
  [[nodiscard]] virtual Error error() const { return {.norm = -1.0, .order = 0}; }
  /// @param viewer ASCII
  virtual void view(TS stepper, PetscViewer viewer) const = 0;
};

/// @brief Makes `implementation` the inside of a `TS`; for `TSRegister`'s creation function.
[[nodiscard]] PetscErrorCode attach(TS stepper, std::unique_ptr<TimeIntegrator> implementation);

/// @brief The inside of a `TS` made by `attach`; null for any other.
[[nodiscard]] TimeIntegrator* attached(TS stepper);

/// @brief Lets `TSAdapt` judge a step: whether it is accepted, and the length to go on or try again with [s].
struct Judgement {
  bool accepted;
  double next_step;
};
[[nodiscard]] Judgement judge_step(TS stepper, double length);
/// Counts a step that was taken back, for `TSGetStepRejections`.
void count_rejection(TS stepper);

/// @brief Registers `Type` under a name for `-ts_type`. May be called again. @note Not collective.
template <class Type>
[[nodiscard]] PetscErrorCode register_integrator(const char* name) {
  PetscFunctionBeginUser;
  PetscCall(register_log_events());
  PetscCall(TSRegister(name, [](TS stepper) { return attach(stepper, std::make_unique<Type>()); }));
  PetscFunctionReturn(0);
}

}  // namespace udar::petsc
