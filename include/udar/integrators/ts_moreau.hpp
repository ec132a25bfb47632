#pragma once
/// @file
/// `-ts_type moreau`: the unfiltered beam, by time stepping of fixed length.

#include <petscts.h>

#include <cstdint>
#include <limits>

#include "udar/integrators/features.hpp"

namespace udar {

/// Name of the `TS` type.
inline constexpr const char* kTsMoreau = "moreau";

/// @brief Registers `-ts_type moreau`. May be called again. @note Not collective.
///
/// The Moreau-Jean scheme with theta = 1/2 on M y'' + C y = F: the impact law holds between the velocities at both ends
/// of a step, at all nodes that a support reaches in it together; a support that gives way pushes by the force of its
/// spring and damper in the middle of the step. Its matrix M + h^2/4 C is that of a line on filter
/// springs of 2/h: it needs a `FilteredStructure` made so (`FilterParameters::filtered`), and that is the step's
/// length; there is no error control. Needs a problem: `compose_problem`. Source: docs/theory.md, "The unfiltered
/// beam"; Jean, Comput. Methods Appl. Mech. Engrg 177 (1999) 235.
[[nodiscard]] PetscErrorCode register_ts_moreau();

/// The default for the unfiltered beam.
inline constexpr IntegratorType kMoreauType{
    .name = kTsMoreau,
    .can = {Feature::unfiltered, Feature::line_contact, Feature::moving_supports, Feature::elastic_line,
            Feature::many_points, Feature::yielding, Feature::many_hinges, Feature::yielding_held},
    .knows =
        "it holds the undamped, unfiltered beam (`filter frequency` none) off rigid supports, by Newton's law of "
        "velocities, and off springs with dampers, and yields at any number of hinges",
    .enroll = register_ts_moreau,
    .default_up_to = std::numeric_limits<std::int64_t>::max()};

}  // namespace udar
