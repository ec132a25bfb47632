#pragma once
/// @file
/// `-ts_type modal`: the lowest modes and a static rest, held off supports in closed form.

#include <petscts.h>

#include "udar/integrators/features.hpp"

namespace udar {

/// Name of the `TS` type.
inline constexpr const char* kTsModal = "modal";

/// @brief Registers `-ts_type modal`. May be called again. @note Not collective.
///
/// The k lowest modes of the unfiltered beam or network move exactly, all others follow at rest; supports hold the
/// line. With few contact points and no losses the motion is known in closed form from one change of contact to the
/// next: a step is such a phase, whatever its length. Else contact forces are linear within steps that keep the energy,
/// `-ts_rtol`. No step costs a line solve. Needs a `FilteredStructure` without filter (`FilterParameters::filtered`),
/// whose frequency is not used, and a problem: `compose_problem`. Options: `-modal_modes`, `-modal_retardation`.
/// Source: docs/theory.md, "The modal integrator"; MacNeal, Computers & Structures 1 (1971) 581; Rubin, AIAA J. 13
/// (1975) 995.
[[nodiscard]] PetscErrorCode register_ts_modal();

/// Never a default.
inline constexpr IntegratorType kModalType{
    .name = kTsModal,
    .can = {Feature::unfiltered, Feature::line_contact, Feature::many_points, Feature::moving_supports,
            Feature::elastic_line, Feature::modal_damping},
    .knows =
        "it moves the lowest modes of the unfiltered beam or network and holds its line off supports, rigid or on "
        "springs and dampers, without a law of impact",
    .enroll = register_ts_modal};

}  // namespace udar
