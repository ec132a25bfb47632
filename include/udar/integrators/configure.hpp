#pragma once
/// @file
/// Which integrator runs a problem, and what its options are.

#include <petscts.h>

#include <memory>
#include <string>
#include <string_view>

#include "udar/integrators/integrator.hpp"
#include "udar/petsc/handle.hpp"

namespace udar {

/// @brief Makes udar's types of `TS` known to PETSc. May be called again. @note Not collective.
void register_integrators();

/// @brief What a problem needs that not every integrator knows.
[[nodiscard]] Features needed_features(const ImpactProblem& problem);

/// @brief A TS ready to run, and the integrator inside it, or around it.
struct Stepping {
  petsc::TimeStepper ts;
  std::unique_ptr<Integrator> around;  ///< of PETSc's own types; else null
  Integrator* integrator = nullptr;
  double end_time = 0.0;   ///< `-ts_max_time` [s]
  double tolerance = 0.0;  ///< `step_tolerance`

  [[nodiscard]] std::string name() const;  ///< `-ts_type`
  /// Whether it goes on from what another integrator has kept of its own; otherwise from masses and contact alone.
  /// @param writer its `-ts_type`; empty: not known
  [[nodiscard]] bool goes_on_from(std::string_view writer) const;
};

/// @brief Chooses the type of the TS by what the problem needs and the cost, lets options change it, and sets it up.
///
/// To add a type: a header with its `IntegratorType`, and one line in the list of types in configure.cpp.
/// @param problem must outlive the result @param state Ym, then Vm of the local nodes
/// @note Collective. Options: all of `-ts_*`; `-ts_rk_type` alone asks for `rk`, and `rk` is 5dp here.
/// @throws InputError if `-ts_type` is none that udar can run, or does not know what the problem needs, which the
/// message names
[[nodiscard]] Stepping configure_stepping(const ImpactProblem& problem, Vec state);

/// @brief `-ts_max_time` [s], before there is a TS to ask. @note Not collective.
[[nodiscard]] double asked_end_time();

/// @brief Error that a step of our own types may make, relative to the motion's scale: `-ts_rtol`, and `-ts_atol` over
/// the scale if it is given.
[[nodiscard]] double step_tolerance(TS stepper, const MotionScale& scale);

}  // namespace udar
