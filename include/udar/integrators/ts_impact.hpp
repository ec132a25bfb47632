#pragma once
/// @file
/// `-ts_type impact`: steps whose cost does not depend on the number of impacts in them.

#include <petscts.h>

#include <cstdint>
#include <limits>

#include "udar/integrators/features.hpp"

namespace udar {

/// Name of the `TS` type.
inline constexpr const char* kTsImpact = "impact";

/// @brief Registers `-ts_type impact`. May be called again. @note Not collective.
///
/// The masses see the line's motion over a step as a polynomial in time: its projection on the first Legendre
/// polynomials. For that every mass is advanced exactly, through all of its impacts, rests and releases; the moments of
/// the masses' motion give the line's by one batch of line solves; this sweep is repeated until it settles. `TSAdapt`
/// chooses the step; a step that fails at an impact of weight is cut there.
/// Options: `-ts_impact_moments` (2 to 5, default 4), `-ts_rtol` (error of a step relative to the motion's scale; 1e-7
/// by default), `-ts_adapt_*`. Needs a problem: `compose_problem`. Source: docs/theory.md, "The impact integrator".
[[nodiscard]] PetscErrorCode register_ts_impact();

/// Its cost does not depend on what touches.
inline constexpr IntegratorType kImpactType{
    .name = kTsImpact,
    .can = {Feature::filtered, Feature::line_contact, Feature::moving_supports, Feature::elastic_supports,
            Feature::elastic_line, Feature::many_points, Feature::mass_damping, Feature::stiffness_damping,
            Feature::contact_laws, Feature::strikers, Feature::laws_of_strikers},
    .knows = "it knows the filtered beam alone",
    .enroll = register_ts_impact,
    .default_up_to = std::numeric_limits<std::int64_t>::max()};

}  // namespace udar
