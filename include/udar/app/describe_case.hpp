#pragma once
/// @file
/// A case as named parameters: what tells a restart that it goes on with the same one.

#include "udar/app/case.hpp"
#include "udar/structure/description.hpp"
#include "udar/structure/structure.hpp"

namespace udar::app {

/// @brief Everything of a case that shapes the motion.
[[nodiscard]] Description describe(const Case& input, const Structure& structure);

}  // namespace udar::app
