#pragma once
/// @file
/// Arcs of a mass in a law of contact.

#include <algorithm>
#include <cstddef>

#include "local/arc_parts.hpp"
#include "udar/local/arcs.hpp"

namespace udar::local {

[[nodiscard]] inline bool in_a_law(const Mass& mass) { return std::ranges::any_of(mass.law, &LawState::closed); }

/// @brief The mass as the law of a stop sees it.
[[nodiscard]] LawMotion law_motion(const Problem& problem, const Mass& mass, std::size_t stop);
/// @brief Where the stop's face is for a mass that is off it, behind the place of the stop [m].
[[nodiscard]] double face_of_law(const Stop& stop, const LawState& state);

/// @brief `start_free_arc` of a mass in a law.
void start_law_arc(const Problem& problem, const Mass& mass, FreeArc& arc);
/// @brief The first end of the piece at hand. @param arc its gap is filled
[[nodiscard]] StopEvent end_of_law(const Problem& problem, const Mass& mass, std::size_t stop, FreeArc& arc,
                                   double end);
/// @brief What the law did on an arc.
[[nodiscard]] StopReport report_law(const Problem& problem, const FreeArc& arc, const Mass& mass, std::size_t stop);
/// @brief The law's share in the kink of the line.
void count_law(const Problem& problem, const FreeArc& arc, const Mass& mass, std::size_t stop, Outcome& outcome);
/// @brief An arc of some length has passed. @param mass at its end
void pass_law(const Problem& problem, double length, Mass& mass);
/// @brief What follows where a piece has ended, or the mass has met the face.
void change_law(const Problem& problem, const FreeArc& arc, Mass& mass);

}  // namespace udar::local
