#pragma once
/// @file
/// Beam, axis and loads as named values.

#include <span>

#include "udar/structure/base_motion.hpp"
#include "udar/structure/beam_chain.hpp"
#include "udar/structure/description.hpp"
#include "udar/structure/held_motion.hpp"
#include "udar/structure/initial_state.hpp"
#include "udar/structure/load.hpp"
#include "udar/structure/striker.hpp"

namespace udar {

/// @name What shapes the motion, of the structure
/// @{
void describe(Description& all, const BeamParameters& beam);
/// Of the start the axis alone: a motion under way knows nothing of how it began.
void describe(Description& all, const InitialState& initial);
void describe(Description& all, std::span<const NodalLoad> loads);
void describe(Description& all, std::span<const BaseMotion> base);
void describe(Description& all, std::span<const HeldMotion> held);
void describe(Description& all, std::span<const Striker> strikers);
void describe(Description& all, std::span<const NodePair> pairs);
void describe(Description& all, std::span<const TravellingLoad> loads);
/// @}

}  // namespace udar
