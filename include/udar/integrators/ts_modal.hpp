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
/// The k lowest modes of the unfiltered beam move exactly, all others follow at rest; supports hold the line. From one
/// change of contact to the next the motion is known in closed form: a step is such a phase, whatever its length, and
/// costs no line solve. Needs a `FilteredStructure` without filter (`FilterParameters::filtered`), whose frequency is
/// not used, and a problem: `compose_problem`.
/// Options: `-modal_modes`. Source: docs/theory.md, "The modal integrator"; MacNeal, Computers & Structures 1 (1971)
/// 581; Rubin, AIAA J. 13 (1975) 995.
[[nodiscard]] PetscErrorCode register_ts_modal();

/// Never a default.
inline constexpr IntegratorType kModalType{
    .name = kTsModal,
    .can = {Feature::unfiltered, Feature::line_contact, Feature::elastic_line},
    .knows =
        "it holds the undamped, unfiltered beam off at most 8 points of supports that stand still, rigid or on "
        "springs, without losses",
    .enroll = register_ts_modal};

}  // namespace udar
