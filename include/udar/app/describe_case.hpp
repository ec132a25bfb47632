#pragma once
/// @file
/// A case as named parameters: what tells a restart that it goes on with the same one.

#include "udar/app/case.hpp"
#include "udar/structure/description.hpp"

namespace udar::app {

/// @brief Everything of a case that shapes the motion.
[[nodiscard]] Description describe(const Case& input);

}  // namespace udar::app
