#pragma once
/// @file
/// `-ts_type chebyshev`: exact propagation from impact to impact.

#include <petscts.h>

#include "udar/dynamics/stepper.hpp"

namespace udar {

/// Name of the `TS` type.
inline constexpr const char* kTsChebyshev = "chebyshev";

/// @brief Registers `-ts_type chebyshev`. May be called again. @note Not collective.
///
/// A step adds terms to the Chebyshev series of the free motion until the motion of the contact nodes, known from the
/// terms at any time, meets its first event, or until `-ts_chebyshev_terms_max` or the step length proposed to the TS
/// is reached; it ends exactly there, with the law applied to all masses that touch. Nothing is repeated. Options:
/// `-ts_chebyshev_terms_max`, `-ts_rtol` (bound of the truncation error of a step, relative to the norm of what the
/// step starts with; 1e-14 by default). Needs a problem: `compose_problem`. Source: docs/theory.md.
[[nodiscard]] PetscErrorCode register_ts_chebyshev();

/// @brief Gives a `TS` of a type registered here what it integrates; its solution is Ym, then Vm of the local nodes.
/// @param problem must outlive the stepper's use; whoever runs the TS ends each step by `ContactState::commit` and
/// `begin_step`, as `ImpactDynamics` does
void compose_problem(TS stepper, const ImpactProblem& problem);
/// @brief What `compose_problem` gave. @throws InputError if there is nothing
[[nodiscard]] const ImpactProblem& composed_problem(TS stepper);

/// @brief The dense output of a `TS` whose type is registered here; null for any other.
[[nodiscard]] Stepper* stepper_inside(TS stepper);

}  // namespace udar
