#pragma once
/// @file
/// Damping and contact as named values.

#include "udar/motion/contact_state.hpp"
#include "udar/motion/equations.hpp"
#include "udar/structure/description.hpp"

namespace udar {

/// @name What shapes the motion, of damping and contact
/// @{
void describe(Description& all, const Damping& damping);
void describe(Description& all, const ContactParameters& contact);
/// @}

}  // namespace udar
