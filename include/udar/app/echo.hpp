#pragma once
/// @file
/// What a run is about to do, in a few lines, and what about it is hard to believe.

#include <optional>
#include <vector>

#include "udar/app/case.hpp"
#include "udar/filter/modes.hpp"

namespace udar::app {

/// @brief When a beam that nothing holds would first meet a support as a rigid body under gravity [s]; none if it never
/// does, or is held, or bent, or pushed by loads, so that nobody knows before.
/// @note Collective. Supports count where they are at the start.
[[nodiscard]] std::optional<double> expected_contact(const Case& input, const Structure& structure);

/// @brief Prints mass, length, frequencies and what the filter makes of the first, supports, expected first contact,
/// rows and bytes, one line each.
/// @param[in] modes the lowest ones @note Collective.
void print_echo(const Case& input, const FilteredStructure& line, const std::vector<Mode>& modes);

/// @brief Warns of what looks like a slip of sign or unit: gravity, fall, no support, a contact expected after the end.
/// @note Collective. Material and section are judged where they are read.
void warn_of_implausible(const Case& input, const Structure& structure);

/// @brief Warns that a run came to its end without any contact, unless that was foreseen and said before.
/// @note Collective.
void warn_of_no_contact(const Case& input, const Structure& structure);

}  // namespace udar::app
