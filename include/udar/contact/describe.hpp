#pragma once
/// @file
/// Supports as named values.

#include <span>

#include "udar/contact/support.hpp"
#include "udar/structure/description.hpp"

namespace udar {

/// @brief All of the supports that shapes the motion.
void describe(Description& all, std::span<const Support> supports);

}  // namespace udar
