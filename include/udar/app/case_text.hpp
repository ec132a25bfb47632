#pragma once
/// @file
/// A case as named parameters: what tells a restart that it goes on with the same one.

#include <string>
#include <string_view>

#include "udar/app/case.hpp"
#include "udar/structure/beam_chain.hpp"

namespace udar::app {

/// @brief Everything that shapes the motion, one line `name [unit]: value` each; a list too long to read is its number
/// of values and their 64-bit FNV-1a hash, the same on every machine.
[[nodiscard]] std::string case_text(const Case& input, const BeamChain& beam);

/// @brief The parameters that differ between two case texts, `name: value there, value here`, joined by "; ".
[[nodiscard]] std::string case_differences(std::string_view there, std::string_view here);

}  // namespace udar::app
