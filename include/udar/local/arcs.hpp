#pragma once
/// @file
/// The arcs of a mass's motion over a step, and the events between them.

#include <array>
#include <cstddef>

#include "udar/contact/contact_law.hpp"
#include "udar/contact/elastic_touch.hpp"
#include "udar/local/local_motion.hpp"
#include "udar/numerics/legendre.hpp"
#include "udar/numerics/power_series.hpp"

namespace udar::local {

/// Where a mass has passed so many arcs in one step, it rests on whatever it meets.
inline constexpr int kMostArcs = 4 * kMostImpacts;

/// @brief The mass between two arcs.
struct Mass {
  double tau = 0.0;
  double place = 0.0;                   ///< [m]
  double velocity = 0.0;                ///< [m per step]
  int resting = -1;                     ///< on this stop
  int standing = -1;                    ///< it moves, and is on this stop exactly
  std::array<ElasticTouch, 2> touch{};  ///< of stops with spring and damper
  std::array<LawState, 2> law{};        ///< of stops with a law
  bool returned = false;                ///< it rests again where it was just released
  int arcs = 0;                         ///< so far
  int stalls = 0;                       ///< arcs without length, one after the other
};

[[nodiscard]] Mass mass_at_start(const Problem& problem);

/// @brief The mass at rest on a stop, until the line lifts it or the step ends.
struct RestArc {
  double length = 0.0;
  bool released = false;                      ///< the line lifts it at the end
  bool kept = false;                          ///< round-off would lift it at once: it stays for a moment
  std::array<double, kMostTerms> path{};      ///< of the stop, in powers of the time since the start of the arc [m]
  std::array<double, kMostTerms> pressing{};  ///< how far the line presses it down, the same [m]
  std::size_t terms = 0;                      ///< of `pressing`
};

[[nodiscard]] RestArc rest_arc(const Problem& problem, const Mass& mass);

/// @brief The mass on its spring, and on the stops that are not rigid and press on it, up to the first event.
struct FreeArc {
  double left = 0.0;                         ///< of the step
  double longest = 0.0;                      ///< as far as the series reaches
  double length = 0.0;                       ///< to the event, else `longest`
  std::size_t powers = 0;                    ///< of the series
  std::array<double, kMostPowers> series{};  ///< z in powers of the time since the start of the arc [m]
  std::array<double, kMostPowers> gap{};     ///< work: of a stop
  int met = -1;                              ///< the stop of the event; -1: none
  bool opens = false;                        ///< the event is the end of a closed gap
  LawEnd end = LawEnd::none;                 ///< or of a piece of a law
  bool stalled = false;                      ///< many arcs had no length: this one has
};

/// @brief The series of the next arc, and how far it reaches. @param[out] arc all but the event
void start_free_arc(const Problem& problem, const Mass& mass, FreeArc& arc);
/// @brief The first event on it: a gap that closes, or a closed one whose force or depth ends.
void find_event(const Problem& problem, const Mass& mass, FreeArc& arc);

/// @brief What a stop did on an arc without an impact. @see Journal
struct StopReport {
  bool touched = false;  ///< it is not rigid, and its gap was closed
  bool pressed = false;
  double push = 0.0;
  double work = 0.0;
  double damped = 0.0;
};
/// @brief What happened on an arc and at its end, for the journal.
struct ArcReport {
  double from = 0.0;
  double until = 0.0;
  std::array<StopReport, 2> stops{};
  double dragged = 0.0;
  int stop = -1;  ///< of the events at the end
  bool impact = false;
  double before = 0.0;  ///< velocities of the impact
  double after = 0.0;
  bool rests = false;
  double speed = 0.0;  ///< that the rest takes
  bool released = false;
};

/// @brief Enters an arc into the outcome and moves the mass to its end. @param report null: nobody wants it
void pass(const Problem& problem, const RestArc& arc, Mass& mass, Outcome& outcome, ArcReport* report);
void pass(const Problem& problem, const FreeArc& arc, Mass& mass, Outcome& outcome, ArcReport* report);

/// @brief What the stop met at the end of the arc makes of the mass that is there.
void apply_event(const Problem& problem, const FreeArc& arc, Mass& mass, Outcome& outcome, ArcReport* report);

}  // namespace udar::local
