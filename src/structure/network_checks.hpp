#pragma once
/// @file
/// Whether a network can be built, and what looks like a mistake in it.

#include <string>
#include <vector>

#include "udar/structure/network.hpp"

namespace udar {

/// "junction 'foot'", or "junction 3 (counted from 0)" of one without name.
[[nodiscard]] std::string name_of(const NetworkParameters& network, const Junction& junction);
[[nodiscard]] std::string name_of(const NetworkParameters& network, const Member& member);

/// @throws InputError naming junction, member or section, the value and its unit
void check_network(const NetworkParameters& network);

/// @brief Members that lie on each other, in sentences for the user; the network has been checked.
[[nodiscard]] std::vector<std::string> overlaps_of(const NetworkParameters& network, const std::vector<Axes>& axes);

}  // namespace udar
