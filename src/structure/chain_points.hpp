#pragma once
/// @file
/// The nodes of a beam as points.

#include <memory>

#include "udar/structure/beam_chain.hpp"
#include "udar/structure/mass_points.hpp"

namespace udar {

/// @brief Node i of the chain is point i; searches need no messages.
/// @param beam must outlive the result @note Collective.
[[nodiscard]] std::unique_ptr<const MassPoints> points_of(const BeamChain& beam);

}  // namespace udar
