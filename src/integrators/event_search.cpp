#include "udar/integrators/event_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "udar/integrators/integrator.hpp"
#include "udar/numerics/bernstein.hpp"
#include "udar/numerics/roots.hpp"

namespace udar {

double EventSearch::survey() {
  events_.clear();
  for (const ContactSet& set : contact_->sets()) {
    for (std::size_t node = set.first; node < set.last; ++node) {
      survey(set, node);
    }
  }
  const auto first = std::ranges::min_element(events_, {}, &ContactEvent::time);
  return first != events_.end() ? first->time : std::numeric_limits<double>::infinity();
}

double EventSearch::correct(double latest, double window, double limit) {
  double next = std::numeric_limits<double>::infinity();
  for (ContactEvent& event : events_) {
    if (event.time <= latest) {
      event.met = std::clamp(corrected_time(event), event.time - window, event.time + window);
      event.met = std::clamp(event.met, motion_->begin(), limit);
      next = std::min(next, event.met);
    }
  }
  return next;
}

bool EventSearch::is_due(const ContactEvent& event) const {
  const double end = motion_->end().line.time;
  return event.met <= end + 2.0 * time_resolution(end);
}

void EventSearch::add(ContactEvent event) {
  event.met = event.time;
  events_.push_back(event);
}

void EventSearch::survey(const ContactSet& set, std::size_t node) {
  if (contact_->resting_on(node, set)) {
    survey_rest(set, node);
  } else if (contact_->resting(node)) {
    return;  // on another support
  } else if (motion_->touches().of(set, node).closed()) {
    survey_touch(set, node);
  } else {
    survey_gap(set, node);
  }
}

/// A mass at rest: when it no longer presses.
void EventSearch::survey_rest(const ContactSet& set, std::size_t node) {
  const StepMotion::Lift first = motion_->lift(set, node, motion_->start());
  const StepMotion::Lift last = motion_->lift(set, node, motion_->end());
  const double length = motion_->length();
  const auto pressing = cubic_bernstein(-set.side * first.value, -set.side * first.rate, -set.side * last.value,
                                        -set.side * last.rate, length);
  if (const auto theta = first_closing(pressing, 0)) {
    const double slope = -bernstein_slope(pressing, *theta, length);
    add({.set = &set, .node = node, .time = motion_->time(*theta), .slope = slope});
  }
}

/// An open gap: when it closes.
void EventSearch::survey_gap(const ContactSet& set, std::size_t node) {
  const double length = motion_->length();
  Kinematics start = motion_->gap(set, node, motion_->start());
  const Kinematics end = motion_->gap(set, node, motion_->end());
  // Inside one step, which resolves the motion, a gap changes by less than twice the larger end speed times the step.
  const double reach = 2.0 * length * std::max(std::abs(start.velocity), std::abs(end.velocity));
  if (std::min(start.position, end.position) > reach && start.position > 0.0) {
    return;
  }
  int touching = 0;
  if (start.position <= 0.0 && start.velocity >= 0.0) {
    start.position = 0.0;
    touching = start.velocity == 0.0 ? 2 : 1;
    if (touching == 2 && !set.elastic()) {
      start.acceleration = std::max(start.acceleration, 0.0);  // just released: zero but for round-off
    }
  }
  if (const auto theta = first_closing(StepPolynomial{start, end, length}.bernstein(), touching)) {
    add({.set = &set, .node = node, .time = motion_->time(*theta)});
  }
}

/// A closed gap: when its force falls to zero or, where it has none, comes back or the gap opens.
void EventSearch::survey_touch(const ContactSet& set, std::size_t node) {
  const ElasticTouch touch = motion_->touches().of(set, node);
  const double length = motion_->length();
  const StepPolynomial open{motion_->gap(set, node, motion_->start()), motion_->gap(set, node, motion_->end()), length};
  const auto& c = open.bernstein();
  constexpr double kDegree = 5.0;
  std::array<double, 6> force{};
  std::array<double, 6> depth{};
  for (std::size_t i = 0; i < c.size(); ++i) {
    // The rate, of degree four, raised to five.
    const double share = static_cast<double>(i) / kDegree;
    const double rate = (i > 0 ? share * (c[i] - c[i - 1]) : 0.0) + (i < 5 ? (1.0 - share) * (c[i + 1] - c[i]) : 0.0);
    force[i] = touch.sign() * (set.stiffness * c[i] + set.damping * kDegree / length * rate);
    depth[i] = -c[i];
  }
  const auto force_ends = first_closing(force, touch.starts_at_zero() ? 1 : 0);
  const auto gap_opens = touch.slack() ? first_closing(depth, 0) : std::nullopt;
  const bool opens_first = gap_opens && (!force_ends || *gap_opens < *force_ends);
  if (const auto& theta = opens_first ? gap_opens : force_ends) {
    add({.set = &set,
         .node = node,
         .time = motion_->time(*theta),
         .opens = opens_first || touch.opens_with_force(set.damping)});
  }
}

/// The instant of an event as the state at the end of the step corrects it.
double EventSearch::corrected_time(const ContactEvent& event) const {
  const std::size_t node = event.node;
  const ContactSet& set = *event.set;
  const StepEnd& end = motion_->end();
  const double time = end.line.time;
  if (contact_->resting(node)) {
    return event.slope > 0.0 ? time - set.side * motion_->lift(set, node, end).value / event.slope : event.time;
  }
  Kinematics open = motion_->gap(set, node, end);
  const ElasticTouch touch = motion_->touches().of(set, node);
  if (touch.closed() && !event.opens) {
    const double sign = touch.sign();
    open = {.position = sign * (set.stiffness * open.position + set.damping * open.velocity),
            .velocity = sign * (set.stiffness * open.velocity + set.damping * open.acceleration)};
  } else if (touch.closed()) {
    open = {.position = -open.position, .velocity = -open.velocity};
  }
  return open.velocity < 0.0 ? time - open.position / open.velocity : event.time;
}

}  // namespace udar
