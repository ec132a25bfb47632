#include "udar/local/arcs.hpp"

#include <algorithm>
#include <cmath>

#include "local/arc_parts.hpp"
#include "local/law_arcs.hpp"
#include "udar/contact/impact_law.hpp"
#include "udar/numerics/gauss.hpp"
#include "udar/numerics/roots.hpp"

namespace udar::local {
namespace {

using power_series::slope;
using power_series::value;

constexpr int kMostStalls = 8;

/// What drags take of a motion over an arc.
double dragged(const Problem& problem, const double* motion, std::size_t count, double start, double length) {
  double sum = 0.0;
  for (const auto& [at, weight] : kGauss) {
    const double speed = slope(motion, count, at * length);
    const double turn = value(problem.turn.data(), problem.terms, start + at * length);
    sum += weight * length * speed * (problem.drag * speed - turn);
  }
  return sum;
}

/// A closed gap: when its force falls to zero or, where it has none, comes back or the gap opens.
StopEvent end_of_touch(const Problem& problem, const Mass& mass, std::size_t stop, FreeArc& arc, double end) {
  const Stop& support = problem.stops[stop];
  const ElasticTouch& touch = mass.touch[stop];
  auto& gap = arc.gap;
  StopEvent first;
  if (touch.slack()) {
    for (std::size_t k = 0; k < arc.powers; ++k) {
      gap[k] = -gap[k];
    }
    first.at = first_zero(gap.data(), arc.powers, end);
    first.opens = first.at >= 0.0;
    fill_gap(problem, mass, stop, arc);
  }
  const std::size_t count = arc.powers - (support.damping > 0.0 ? 1 : 0);
  for (std::size_t k = 0; k < count; ++k) {
    const double rate = k + 1 < arc.powers ? static_cast<double>(k + 1) * gap[k + 1] : 0.0;
    gap[k] = touch.sign() * (support.stiffness * gap[k] + support.damping * rate);
  }
  std::size_t skip = touch.starts_at_zero() ? 1 : 0;
  while (skip > 0 && skip < 3 && gap[skip] == 0.0) {
    ++skip;
  }
  const double* from = gap.data() + skip;
  const double until = first.at >= 0.0 ? first.at : end;
  const double other = *from < 0.0 ? 0.0 : first_zero(from, count - skip, until);
  if (other >= 0.0 && other <= until) {
    first = {.at = other, .opens = touch.opens_with_force(support.damping)};
  }
  return first;
}

/// The mass is on the stop: the zero at the start, double where it starts without speed, is divided out.
double next_closing(const Problem& problem, const Mass& mass, std::size_t stop, FreeArc& arc, double end) {
  auto& gap = arc.gap;
  const bool standing = mass.standing == static_cast<int>(stop);
  gap[1] = stands(problem, gap[1]) ? 0.0 : gap[1];
  if (gap[1] < 0.0) {
    return 0.0;
  }
  std::size_t skip = 1;
  if (gap[1] == 0.0) {
    skip = gap[2] == 0.0 || (standing && gap[2] < 0.0 && gap[3] > 0.0) ? 3 : 2;
  }
  const double* from = gap.data() + skip;
  return *from < 0.0 ? 0.0 : first_zero(from, arc.powers - skip, end);
}

StopEvent meet(const Problem& problem, const Mass& mass, std::size_t stop, FreeArc& arc, double end) {
  fill_gap(problem, mass, stop, arc);
  if (mass.law[stop].closed()) {
    return arc.stalled ? StopEvent{} : end_of_law(problem, mass, stop, arc, end);
  }
  if (problem.stops[stop].contact_law != nullptr) {
    arc.gap[0] += face_of_law(problem.stops[stop], mass.law[stop]);
  }
  if (mass.touch[stop].closed()) {
    const StopEvent met = end_of_touch(problem, mass, stop, arc, end);
    return arc.stalled ? StopEvent{} : met;
  }
  if (mass.standing == static_cast<int>(stop) || arc.gap[0] <= problem.together) {
    const double at = next_closing(problem, mass, stop, arc, end);
    return {.at = arc.stalled && problem.stops[stop].elastic() ? -1.0 : at};
  }
  return {.at = first_zero(arc.gap.data(), arc.powers, end)};
}

/// What a stop whose gap is closed did on an arc.
StopReport report_touch(const Problem& problem, const FreeArc& arc, const Mass& mass, std::size_t stop) {
  const Stop& support = problem.stops[stop];
  const double side = side_of(stop);
  const double end = arc.length;
  const auto gap_at = [&](double s) {
    return side * (value(arc.series.data(), arc.powers, s) - support.place(mass.tau + s));
  };
  const auto rate_at = [&](double s) {
    return side * (slope(arc.series.data(), arc.powers, s) - support.speed(mass.tau + s));
  };
  StopReport report{.touched = true};
  if (mass.touch[stop].slack()) {
    report.damped = 0.5 * support.stiffness * (gap_at(0.0) * gap_at(0.0) - gap_at(end) * gap_at(end));
    return report;
  }
  report.pressed = true;
  for (const auto& [at, weight] : kGauss) {
    const double rate = rate_at(at * end);
    const double force = -side * (support.stiffness * gap_at(at * end) + support.damping * rate) * weight * end;
    report.push += force;
    report.work += force * support.speed(mass.tau + at * end);
    report.damped += support.damping * rate * rate * weight * end;
  }
  return report;
}

/// A stop that presses on the mass moves the line as an impact does, but for the time that it takes.
void count_press(const Problem& problem, const FreeArc& arc, const Mass& mass, std::size_t stop, Outcome& outcome) {
  constexpr double kHard = 10.0;  // a stop that gives way within the step makes no kink
  const Stop& support = problem.stops[stop];
  const double side = side_of(stop);
  const double end = arc.length;
  const double middle = 0.5 * end;
  const double gap = side * (value(arc.series.data(), arc.powers, middle) - support.place(mass.tau + middle));
  const double rate = side * (slope(arc.series.data(), arc.powers, middle) - support.speed(mass.tau + middle));
  outcome.kick +=
      std::min(1.0, support.stiffness / kHard) * end * std::abs(support.stiffness * gap + support.damping * rate);
  outcome.first_impact = std::min(outcome.first_impact, mass.tau);
  ++outcome.impacts;
}

void change_touch(const Problem& problem, const FreeArc& arc, Mass& mass) {
  const auto stop = static_cast<std::size_t>(arc.met);
  const Stop& support = problem.stops[stop];
  if (support.contact_law != nullptr) {
    return change_law(problem, arc, mass);
  }
  ElasticTouch& touch = mass.touch[stop];
  if (touch.changes_on_face(arc.opens)) {
    mass.place = support.place(mass.tau);
  }
  mass.standing = arc.opens ? arc.met : -1;
  touch.change(arc.opens, support.damping, side_of(stop) * (mass.velocity - support.speed(mass.tau)));
}

}  // namespace

Mass mass_at_start(const Problem& problem) {
  Mass mass{.velocity = problem.velocity, .resting = problem.resting};
  for (std::size_t index = 0; index < 2; ++index) {
    const Stop& stop = problem.stops[index];
    const double side = side_of(index);
    const double gap = -side * stop.at;
    if (stop.present && stop.contact_law != nullptr) {
      mass.law[index] = stop.contact_law->found(law_motion(problem, mass, index), stop.largest);
    } else if (stop.present && stop.elastic() && gap < 0.0) {
      const double force = stop.stiffness * gap + stop.damping * side * (problem.velocity - stop.speed(0.0));
      mass.touch[index] = ElasticTouch::found(gap, force);
    }
  }
  if (mass.resting >= 0) {
    const Stop& stop = problem.stops[static_cast<std::size_t>(mass.resting)];
    mass.place = stop.at;
    mass.velocity = stop.speed(0.0);
  }
  return mass;
}

/// It presses with -side (P - z - ...) >= 0 until that turns negative.
RestArc rest_arc(const Problem& problem, const Mass& mass) {
  const auto index = static_cast<std::size_t>(mass.resting);
  const Stop& stop = problem.stops[index];
  const double side = side_of(index);
  const double left = problem.until - mass.tau;
  const auto line = line_from(problem, mass.tau);
  RestArc arc{.path = path_from(stop, mass.tau), .terms = problem.terms};
  const auto& path = arc.path;
  auto& pressing = arc.pressing;
  for (std::size_t k = 0; k < problem.terms; ++k) {
    pressing[k] = -side * line[k];
  }
  pressing[0] += side * path[0];
  if (stop.moves) {
    arc.terms = std::max<std::size_t>(arc.terms, 4);
    for (std::size_t k = 1; k < 4; ++k) {
      pressing[k] += side * path[k];
    }
    for (std::size_t k = 0; k + 1 < kMostTerms; ++k) {
      const auto next = static_cast<double>(k + 1);
      const double bend = k < 2 ? next * static_cast<double>(k + 2) * path[k + 2] : 0.0;
      pressing[k] += side / (problem.angle * problem.angle) * (bend + next * problem.drag * path[k + 1]);
    }
  }
  std::array<double, kMostTerms> surely_pressing = pressing;
  surely_pressing[0] += problem.pull_resolution;
  const double end = surely_pressing[0] < 0.0 ? 0.0 : first_zero(surely_pressing.data(), arc.terms, left);
  arc.released = end >= 0.0 && end < left;
  arc.length = arc.released ? end : left;
  // Round-off lifts what it has just put back: it stays for the time in which the pull is but round-off.
  arc.kept = arc.released && mass.returned && mass.tau + arc.length == mass.tau && left > kMoment;
  if (arc.kept) {
    arc.released = false;
    arc.length = kMoment;
  }
  return arc;
}

void pass(const Problem& problem, const RestArc& arc, Mass& mass, Outcome& outcome, ArcReport* report) {
  const auto index = static_cast<std::size_t>(mass.resting);
  const Stop& stop = problem.stops[index];
  const double end = arc.length;
  if (problem.moments) {
    add_legendre(arc.path.data(), stop.moves ? 4 : 1, mass.tau, end, problem.terms, outcome.moments);
  }
  if (report != nullptr) {
    const double z2 = problem.angle * problem.angle;
    const double side = side_of(index);
    StopReport& pressed = report->stops[index];
    pressed.pressed = true;
    for (std::size_t k = arc.terms; k-- > 0;) {
      pressed.push = pressed.push * end + side * z2 * arc.pressing[k] / static_cast<double>(k + 1);
    }
    pressed.push *= end;
    for (std::size_t i = 0; i < kGauss.size() && stop.moves; ++i) {
      const auto& [at, weight] = kGauss[i];
      pressed.work += side * z2 * value(arc.pressing.data(), arc.terms, at * end) * weight * end *
                      slope(arc.path.data(), 4, at * end);
    }
    report->dragged = problem.drag != 0.0 ? dragged(problem, arc.path.data(), 4, mass.tau, end) : 0.0;
    report->released = arc.released;
    report->stop = mass.resting;
  }
  mass.returned = false;
  mass.tau += end;
  mass.place = stop.moves ? value(arc.path.data(), 4, end) : stop.at;
  mass.velocity = stop.moves ? slope(arc.path.data(), 4, end) : 0.0;
  if (arc.released) {
    mass.standing = mass.resting;
    mass.resting = -1;
  }
}

void start_free_arc(const Problem& problem, const Mass& mass, FreeArc& arc) {
  if (in_a_law(mass)) {
    return start_law_arc(problem, mass, arc);
  }
  const double z2 = problem.angle * problem.angle;
  const auto line = line_from(problem, mass.tau);
  arc.left = problem.until - mass.tau;
  arc.longest = arc.left;
  arc.powers = problem.powers;
  bool presses = false;
  double stiffness = 0.0;
  double damping = 0.0;
  std::array<double, kMostTerms> target{};  // k q + c q' of the stops it presses
  for (std::size_t index = 0; index < 2; ++index) {
    if (mass.touch[index].pressing()) {
      const Stop& stop = problem.stops[index];
      const auto path = path_from(stop, mass.tau);
      presses = true;
      stiffness += stop.stiffness;
      damping += stop.damping;
      for (std::size_t k = 0; k < 4; ++k) {
        target[k] += stop.stiffness * path[k] + stop.damping * static_cast<double>(k + 1) * path[k + 1];
      }
    }
  }
  if (presses) {
    // Arcs in which the series decays as for an angle of one: its powers are bounded by those of 1.62^k / k!.
    constexpr double kGrowth = 1.62;
    arc.powers = std::max(arc.powers, powers_for(kGrowth));
    arc.longest = std::min(arc.left, 1.0 / std::max(std::sqrt(z2 + stiffness), damping + problem.drag));
  }
  auto& series = arc.series;
  series[0] = mass.place;
  series[1] = mass.velocity;
  if (!presses && problem.drag == 0.0) {
    for (std::size_t k = 0; k + 2 < arc.powers; ++k) {
      series[k + 2] = z2 * ((k < problem.terms ? line[k] : 0.0) - series[k]) / static_cast<double>((k + 1) * (k + 2));
    }
    return;
  }
  for (std::size_t k = 0; k + 2 < arc.powers; ++k) {
    double pull = z2 * ((k < problem.terms ? line[k] : 0.0) - series[k]);
    pull -= static_cast<double>(k + 1) * problem.drag * series[k + 1];
    if (presses) {
      pull += (k < kMostTerms ? target[k] : 0.0) - stiffness * series[k] -
              damping * static_cast<double>(k + 1) * series[k + 1];
    }
    series[k + 2] = pull / static_cast<double>((k + 1) * (k + 2));
  }
}

void find_event(const Problem& problem, const Mass& mass, FreeArc& arc) {
  arc.length = arc.longest;
  arc.met = -1;
  arc.opens = false;
  arc.end = LawEnd::none;
  arc.stalled = mass.stalls > kMostStalls;
  for (std::size_t stop = 0; stop < 2; ++stop) {
    if (!problem.stops[stop].present) {
      continue;
    }
    const StopEvent first = meet(problem, mass, stop, arc, arc.length);
    if (first.at >= 0.0 && first.at <= arc.length) {
      arc.length = first.at;
      arc.met = static_cast<int>(stop);
      arc.opens = first.opens;
      arc.end = first.end;
    }
  }
  if (arc.stalled && arc.met < 0) {
    arc.length = std::min({arc.length, arc.left, kMoment});
  }
}

void pass(const Problem& problem, const FreeArc& arc, Mass& mass, Outcome& outcome, ArcReport* report) {
  const double end = arc.length;
  mass.stalls = end == 0.0 ? mass.stalls + 1 : 0;
  if (problem.moments) {
    add_legendre(arc.series.data(), arc.powers, mass.tau, end, problem.terms, outcome.moments);
  }
  for (std::size_t stop = 0; stop < 2; ++stop) {
    if (mass.touch[stop].pressing()) {
      count_press(problem, arc, mass, stop, outcome);
    }
    if (report != nullptr && mass.touch[stop].closed()) {
      report->stops[stop] = report_touch(problem, arc, mass, stop);
    }
    if (mass.law[stop].closed()) {
      count_law(problem, arc, mass, stop, outcome);
    }
    if (report != nullptr && mass.law[stop].closed()) {
      report->stops[stop] = report_law(problem, arc, mass, stop);
    }
  }
  if (report != nullptr && problem.drag != 0.0) {
    report->dragged = dragged(problem, arc.series.data(), arc.powers, mass.tau, end);
  }
  mass.velocity = slope(arc.series.data(), arc.powers, end);
  mass.place = value(arc.series.data(), arc.powers, end);
  mass.tau += end;
  for (ElasticTouch& touch : mass.touch) {
    touch.pass();
  }
  if (in_a_law(mass)) {
    pass_law(problem, end, mass);
  }
  if (arc.met >= 0) {
    return;
  }
  mass.standing = -1;
  for (std::size_t stop = 0; stop < 2; ++stop) {  // round-off may leave it below by its last bits
    const Stop& support = problem.stops[stop];
    if (support.present && !support.elastic() && side_of(stop) * (mass.place - support.place(mass.tau)) < 0.0) {
      mass.place = support.place(mass.tau);
    }
  }
}

void apply_event(const Problem& problem, const FreeArc& arc, Mass& mass, Outcome& outcome, ArcReport* report) {
  const auto index = static_cast<std::size_t>(arc.met);
  const Stop& support = problem.stops[index];
  if (support.elastic()) {
    return change_touch(problem, arc, mass);
  }
  const double z2 = problem.angle * problem.angle;
  const double side = side_of(index);
  const double tau = mass.tau;
  const int stood = mass.standing;
  mass.standing = -1;
  mass.place = support.place(tau);
  const double ground = support.speed(tau);
  const double arrives = side * (mass.velocity - ground);
  const double before = stands(problem, arrives) ? 0.0 : arrives;
  const double after = before < 0.0 ? support.law().after(before) : before;
  double pull = side * z2 * (value(problem.line.data(), problem.terms, tau) - mass.place);
  if (support.moves) {
    pull -= side * (problem.drag * ground + 2.0 * support.path[1] + 6.0 * tau * support.path[2]);
  }
  if (report != nullptr) {
    report->stop = arc.met;
    report->impact = before < 0.0;
    report->before = mass.velocity;
    report->after = ground + side * after;
  }
  if (before < 0.0) {
    outcome.first_impact = std::min(outcome.first_impact, tau);
    outcome.kick += after - before;
    ++outcome.impacts;
  }
  // Where it hits too often, or does not get off, the arc of rest tells whether the line lifts it at once.
  const bool tired = outcome.impacts >= kMostImpacts || mass.arcs >= kMostArcs || (before == 0.0 && arc.length == 0.0);
  if (tired ||
      (pull <= z2 * problem.pull_resolution && after * after <= std::max(0.0, -2.0 * pull * problem.hop_tolerance))) {
    if (report != nullptr) {
      report->rests = true;
      report->speed = after;
    }
    mass.returned = stood == arc.met && before == 0.0 && arc.length == 0.0;
    mass.resting = arc.met;
    mass.velocity = ground;
  } else {
    mass.velocity = ground + side * after;
    mass.standing = arc.met;
  }
}

}  // namespace udar::local
