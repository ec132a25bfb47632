#include "udar/dynamics/run_checks.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "udar/motion/kinks.hpp"
#include "udar/petsc/error.hpp"

namespace udar {
namespace {

// More events than this without progress in time would never end.
constexpr PetscInt kMostEventsAtOnce = 10000;
// Nor would a run in steps this short, in units of the shortest time in which masses move: the tightest tolerance that
// double precision allows takes steps of 1e-3. One or two beside an event or a kink are normal.
constexpr double kLeastStep = 1e-6;
constexpr PetscInt kMostShortSteps = 1000;

}  // namespace

void refuse_overlap(const MassPoints& points, const ContactState& contact, std::span<const ContactSet> sets,
                    const MassState& masses) {
  std::string overlap;
  for (const ContactSet& set : sets) {
    const double lift = set.lift(0.0).height;
    const bool presses = set.elastic() && (contact.on_line() || set.contact_law);
    for (std::size_t node = set.first; node < set.last && overlap.empty() && !presses; ++node) {
      const double height = set.height(node) + lift;
      const double gap = set.side * (masses.position[node] - height);
      if (gap < -contact.touching_distance(masses.position[node], height)) {
        const Support& support = contact.supports()[static_cast<std::size_t>(set.support)];
        const bool floor = std::isinf(support.width) && !support.field && !support.boxed();
        std::ostringstream message;
        message << (!support.profile.x.empty() ? "ground profile"
                    : support.field            ? "support height field"
                    : support.boxed()          ? "support box"
                    : floor                    ? "floor height"
                                               : "support height")
                << ": " << height << " is not allowed, "
                << (floor ? "the ground" : "support " + std::to_string(set.support))
                << " overlaps the beam at the start, by " << -gap << " m at x = " << points.place(node).x
                << " m; expected a height on its own side of the beam (`initial height`) [m], or a spring that is "
                   "pressed from the start (`support stiffness` with `contact surface` line, or a `contact law`)";
        overlap = message.str();
      }
    }
  }
  throw_together<InputError>(points.comm(), overlap);
}

void refuse_hops_without_length(const ContactParameters& parameters, const MotionScale& scale, double fastest,
                                double end_time) {
  const double shortest = time_resolution(end_time);
  const double pull = fastest * scale.velocity;
  const double least = 0.125 * pull * shortest * shortest;
  if (!(parameters.hop_tolerance >= least)) {
    std::ostringstream message;
    message << "contact tolerance: " << parameters.hop_tolerance << " is not allowed, expected a number >= " << least
            << " [m]: at the end of the run a lower hop is over within the last digits of the time";
    throw InputError{message.str()};
  }
}

StandstillGuard::StandstillGuard(double fastest) : least_{kLeastStep / fastest} {}

void StandstillGuard::see(double begin, double time, bool events, bool cut) {
  events_at_once_ = events && time - begin <= time_resolution(time) ? events_at_once_ + 1 : 0;
  if (events_at_once_ > kMostEventsAtOnce) {
    throw SolveError{"contact does not settle at t = " + std::to_string(time) + " s after " +
                     std::to_string(kMostEventsAtOnce) +
                     " events at one instant; raise `contact tolerance` or lower -ts_rtol"};
  }
  if (time - begin >= least_) {
    short_steps_ = 0;
  } else if (!events && !cut) {
    ++short_steps_;
  }
  if (short_steps_ > kMostShortSteps) {
    std::ostringstream message;
    message << "the time stands still at t = " << time << " s: " << kMostShortSteps << " steps are shorter than "
            << least_
            << " s, a millionth of the fastest motion; raise -ts_rtol or -ts_dt, or look for a load or a support that "
               "jumps";
    throw SolveError{message.str()};
  }
}

}  // namespace udar
