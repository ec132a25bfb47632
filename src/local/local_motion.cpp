#include "udar/local/local_motion.hpp"

#include <algorithm>

#include "udar/local/arcs.hpp"

namespace udar::local {
namespace {

void tell(const ArcReport& report, Journal& journal) {
  for (int stop = 0; stop < 2; ++stop) {
    const StopReport& of = report.stops[static_cast<std::size_t>(stop)];
    if (of.touched) {
      journal.touched(report.from, report.until);
    }
    if (of.pressed) {
      journal.pressed(stop, of.push, of.work);
    }
    if (of.damped != 0.0) {
      journal.damped(of.damped);
    }
  }
  if (report.dragged != 0.0) {
    journal.damped(report.dragged);
  }
  if (report.impact) {
    journal.impact(report.stop, report.until, report.before, report.after);
  }
  if (report.rests) {
    journal.rest(report.stop, report.until, report.speed);
  }
  if (report.released) {
    journal.release(report.stop, report.until);
  }
}

/// @return whether the step goes on
bool pass_rest(const Problem& problem, Mass& mass, Outcome& outcome, ArcReport* report) {
  const RestArc arc = rest_arc(problem, mass);
  pass(problem, arc, mass, outcome, report);
  return arc.kept || (arc.released && !(arc.length == 0.0 && mass.tau >= problem.until));
}

/// @return whether the step goes on
bool pass_free(const Problem& problem, FreeArc& arc, Mass& mass, Outcome& outcome, ArcReport* report) {
  start_free_arc(problem, mass, arc);
  find_event(problem, mass, arc);
  pass(problem, arc, mass, outcome, report);
  if (arc.met < 0) {
    return arc.longest < arc.left || (arc.stalled && arc.length < arc.left);
  }
  const bool elastic = problem.stops[static_cast<std::size_t>(arc.met)].elastic();
  apply_event(problem, arc, mass, outcome, report);
  return !elastic || mass.arcs < kMostArcs;
}

}  // namespace

std::size_t powers_for(double angle) {
  constexpr double kRoundOff = 1e-18;
  double term = 1.0;
  std::size_t count = 4;
  for (std::size_t k = 1; k < kMostPowers; ++k) {
    term *= angle / static_cast<double>(k);
    if (term < kRoundOff && k >= count) {
      break;
    }
    count = std::max(count, k + 1);
  }
  return count;
}

Outcome advance(const Problem& problem, Journal* journal) {
  Outcome outcome;
  Mass mass = mass_at_start(problem);
  FreeArc arc;
  ArcReport report;
  ArcReport* const wanted = journal != nullptr ? &report : nullptr;
  for (bool goes_on = true; goes_on; ++mass.arcs) {
    if (journal != nullptr) {
      report = {.from = mass.tau};
    }
    goes_on =
        mass.resting >= 0 ? pass_rest(problem, mass, outcome, wanted) : pass_free(problem, arc, mass, outcome, wanted);
    if (journal != nullptr) {
      report.until = mass.tau;
      tell(report, *journal);
    }
  }
  outcome.displacement = mass.place;
  outcome.velocity = mass.velocity;
  outcome.resting = mass.resting;
  outcome.largest = {mass.law[0].largest, mass.law[1].largest};
  return outcome;
}

}  // namespace udar::local
