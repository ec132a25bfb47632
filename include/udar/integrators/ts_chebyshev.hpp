#pragma once
/// @file
/// `-ts_type chebyshev`: exact propagation from impact to impact.

#include <petscts.h>

#include "udar/integrators/features.hpp"

namespace udar {

/// Name of the `TS` type.
inline constexpr const char* kTsChebyshev = "chebyshev";

/// @brief Registers `-ts_type chebyshev`. May be called again. @note Not collective.
///
/// A step adds terms to the Chebyshev series of the free motion until the motion of the contact nodes, known from the
/// terms at any time, meets its first event, or until `-ts_chebyshev_terms_max` or the step length proposed to the TS
/// is reached; it ends exactly there, with the law applied to all masses that touch. Nothing is repeated. Where
/// supports hold the line at few points, the events are the zeros of their forces and gaps. A rigid motion is one step.
/// Options:
/// `-ts_chebyshev_terms_max`, `-ts_rtol` (bound of the truncation error of a step, relative to the norm of what the
/// step starts with; 1e-14 by default). Needs a problem: `compose_problem`. Source: docs/theory.md.
[[nodiscard]] PetscErrorCode register_ts_chebyshev();

/// Cheapest by its line solves, about 2.5 + 0.9 per contact node and unit wf t where `impact` takes 12.
inline constexpr IntegratorType kChebyshevType{
    .name = kTsChebyshev,
    .can = {Feature::filtered, Feature::line_contact, Feature::elastic_line, Feature::strikers, Feature::yielding},
    .knows =
        "its series know a matrix that is constant from event to event and forces linear in time: no support that "
        "moves "
        "by its cubics, no spring under a mass and no damper that changes the matrix, at most 8 points that hold the "
        "line, or 8 plastic hinges",
    .enroll = register_ts_chebyshev,
    .default_up_to = 10,
    .default_without = {Feature::line_contact}};

}  // namespace udar
