#include "udar/integrators/step_motion.hpp"

#include <algorithm>

#include "udar/numerics/bernstein.hpp"
#include "udar/numerics/gauss.hpp"

namespace udar {

StepMotion::StepMotion(Equations& equations, const ContactState& contact)
    : equations_{&equations},
      contact_{&contact},
      count_{equations.points().points()},
      wf2_{equations.line().filter_frequency() * equations.line().filter_frequency()},
      damping_{equations.damping()},
      plain_{!damping_.any()},
      touches_{contact} {
  for (const Support& support : contact.supports()) {  // the same on every rank
    plain_ = plain_ && (contact.on_line() || (!support.motion && !support.elastic()));
  }
}

void StepMotion::find_accelerations(StepEnd& end) {
  const double* const state = end.values;
  end.acceleration.resize(count_);
  for (std::size_t i = 0; i < count_; ++i) {
    end.acceleration[i] = contact_->resting(i) ? 0.0 : wf2_ * end.line.stretch[i];
    if (damping_.any() && !contact_->resting(i)) {
      end.acceleration[i] += damping_.stiffness * wf2_ * end.rate[i] - damping_.mass * state[count_ + i];
    }
  }
  for (const ContactSet& set : contact_->sets()) {
    for (std::size_t node = set.first; node < set.last && !set.plain(); ++node) {
      if (contact_->resting_on(node, set)) {
        end.acceleration[node] = set.lift(end.line.time, begin()).acceleration;
      } else {
        end.acceleration[node] +=
            contact_acceleration(set, node, {.position = state[node], .velocity = state[count_ + node]}, end.line.time);
      }
    }
  }
  if (damping_.any()) {
    end.bend.resize(count_);
    equations_->line().solve(end.acceleration, {}, end.bend, {});
  }
}

void StepMotion::end_at_start(bool with_rate) {
  end_.line = start_.line;
  end_.acceleration = start_.acceleration;
  if (with_rate) {
    end_.rate = start_.rate;
  }
  end_.bend = start_.bend;
}

Kinematics StepMotion::gap(const ContactSet& set, const Kinematics& mass, std::size_t node, double time) const {
  const SupportMotion::State lift = set.lift(time, begin());
  return {.position = set.side * (mass.position - set.height(node) - lift.height),
          .velocity = set.side * (mass.velocity - lift.velocity),
          .acceleration = set.side * (mass.acceleration - lift.acceleration)};
}

Kinematics StepMotion::kinematics(std::size_t node, const StepEnd& end) const {
  const double acceleration =
      plain_ ? (!contact_->resting(node) ? wf2_ * end.line.stretch[node] : 0.0) : end.acceleration[node];
  return {.position = end.values[node], .velocity = end.values[count_ + node], .acceleration = acceleration};
}

StepPolynomial StepMotion::polynomial(std::size_t node) const {
  return {kinematics(node, start_), kinematics(node, end_), length()};
}

StepPolynomial StepMotion::stretch_polynomial(std::size_t node) const {
  const double of_loads = load_rate(node);
  return {
      {.position = start_.line.stretch[node],
       .velocity = start_.rate[node] + of_loads,
       .acceleration = start_.bend[node]},
      {.position = end_.line.stretch[node], .velocity = end_.rate[node] + of_loads, .acceleration = end_.bend[node]},
      length()};
}

/// What the dampers of the structure see: a linear image of the masses' own polynomials, so that at no instant these
/// gain energy by them.
double StepMotion::damper_rate(std::size_t node, double theta) const {
  return stretch_polynomial(node).velocity(theta) - load_rate(node);
}

/// Of the line from a mass at rest on a support at rest.
double StepMotion::resting_stretch(std::size_t node, double theta) const {
  const double of_loads = load_rate(node);
  return bernstein_value(cubic_bernstein(start_.line.stretch[node], start_.rate[node] + of_loads,
                                         end_.line.stretch[node], end_.rate[node] + of_loads, length()),
                         theta);
}

/// Of the line from a mass that this support, if any, touches.
double StepMotion::stretch(const ContactSet& set, std::size_t node, double theta) const {
  if (damping_.any()) {
    return stretch_polynomial(node).position(theta);
  }
  if (contact_->resting(node)) {
    return resting_stretch(node, theta);
  }
  const StepPolynomial motion = polynomial(node);
  const Kinematics mass{.position = motion.position(theta), .velocity = motion.velocity(theta)};
  return (motion.acceleration(theta) - contact_acceleration(set, node, mass, time(theta))) / wf2_;
}

/// How much nearer to its mass than the stretch says the line is, in corrected modes: between the ends of a step
/// linear, which is off by (w h)^2 / 8 of it.
double StepMotion::amplitude_offset(std::size_t node, double theta) const {
  double offset = 0.0;
  for (std::size_t mode = 0; mode < start_.line.amplitude.size(); ++mode) {
    offset += ((1.0 - theta) * start_.line.amplitude[mode] + theta * end_.line.amplitude[mode]) *
              equations_->line().corrected_modes()[mode].shape[node];
  }
  return offset;
}

double StepMotion::line_gap(const ContactSet& set, std::size_t node, double theta) const {
  const double place = contact_->resting(node) && plain_ ? start_.values[node] : polynomial(node).position(theta);
  const double lift = set.lift(time(theta), begin()).height;
  const double line = place + stretch(set, node, theta) - amplitude_offset(node, theta);
  return set.side * (line - set.height(node) - lift);
}

double StepMotion::contact_acceleration(const ContactSet& set, std::size_t node, const Kinematics& mass,
                                        double time) const {
  if (!touches_.of(set, node).pressing()) {
    return 0.0;
  }
  const Kinematics open = gap(set, mass, node, time);
  return -set.side * (set.stiffness * open.position + set.damping * open.velocity);
}

StepMotion::Lift StepMotion::lift(const ContactSet& set, std::size_t node, const StepEnd& end) const {
  const SupportMotion::State support = set.lift(end.line.time, begin());
  const double before = set.lift(begin(), begin()).acceleration;
  const double jerk = length() > 0.0 ? (set.lift(end_.line.time, begin()).acceleration - before) / length() : 0.0;
  const double bend = damping_.any() ? end.bend[node] : 0.0;
  return {.value = end.line.stretch[node] + damping_.stiffness * end.rate[node] -
                   (support.acceleration + damping_.mass * support.velocity) / wf2_ -
                   set.side * contact_->pull_resolution(set.height(node) + support.height),
          .rate = end.rate[node] + load_rate(node) + damping_.stiffness * bend -
                  (jerk + damping_.mass * support.acceleration) / wf2_};
}

double StepMotion::pull_integral(std::size_t node) const {
  const double length = this->length();
  return 0.5 * length * (start_.line.stretch[node] + end_.line.stretch[node]) +
         length * length / 12.0 * (start_.rate[node] - end_.rate[node]) +
         damping_.stiffness * (end_.line.stretch[node] - start_.line.stretch[node] - length * load_rate(node));
}

SupportAction StepMotion::action(const ContactSet& set, std::size_t node, double theta) const {
  SupportAction sum;
  const double length = this->length();
  const bool rests = contact_->resting_on(node, set);
  const ElasticTouch touch = touches_.of(set, node);
  if (length <= 0.0 || (!rests && !touch.closed())) {
    return sum;
  }
  const StepPolynomial motion = polynomial(node);
  const auto open = [&](double share) {
    return gap(set, {.position = motion.position(share), .velocity = motion.velocity(share)}, node,
               begin() + share * length);
  };
  if (touch.slack()) {
    const double from = open(0.0).position;
    const double to = open(theta).position;
    sum.flow.damped = 0.5 * set.stiffness * (from * from - to * to);
    return sum;
  }
  for (const auto& [at, weight] : kGauss) {
    const double share = at * theta;
    const double time = begin() + share * length;
    const SupportMotion::State lift = set.lift(time, begin());
    const double span = weight * theta * length;
    double push = 0.0;
    if (rests) {
      push = lift.acceleration + damping_.mass * lift.velocity - wf2_ * stretch(set, node, share);
      push -= damping_.any() ? damping_.stiffness * wf2_ * damper_rate(node, share) : 0.0;
    } else {
      const Kinematics now = open(share);
      push = -set.side * (set.stiffness * now.position + set.damping * now.velocity);
      sum.flow.damped += set.damping * now.velocity * now.velocity * span;
    }
    sum.push += push * span;
    sum.flow.work += push * lift.velocity * span;
  }
  return sum;
}

EnergyFlow StepMotion::flow(double theta) const {
  EnergyFlow sum;
  const double length = this->length();
  for (std::size_t i = 0; i < count_ && damping_.any() && length > 0.0; ++i) {
    const StepPolynomial motion = polynomial(i);
    const StepPolynomial line = stretch_polynomial(i);
    for (const auto& [at, weight] : kGauss) {
      const double speed = motion.velocity(at * theta);
      const double turn = line.velocity(at * theta) - load_rate(i);
      const double taken = damping_.mass * speed - damping_.stiffness * wf2_ * turn;
      sum.damped += equations_->line().mass()[i] * weight * theta * length * speed * taken;
    }
  }
  for (const ContactSet& set : contact_->sets()) {
    for (std::size_t node = set.first; node < set.last && !set.plain(); ++node) {
      const EnergyFlow one = action(set, node, theta).flow;
      sum.work += equations_->line().mass()[node] * one.work;
      sum.damped += equations_->line().mass()[node] * one.damped;
    }
  }
  return sum;
}

void StepMotion::masses(double time, std::span<double> position, std::span<double> velocity,
                        std::span<std::uint8_t> resting) const {
  const double length = this->length();
  const double theta = length > 0.0 ? std::clamp((time - begin()) / length, 0.0, 1.0) : 1.0;
  for (std::size_t i = 0; i < count_; ++i) {
    resting[i] = contact_->resting(i) ? 1 : 0;
    // At the end the state itself: a step of some units in the last place has no slope.
    if (theta < 1.0 && (resting[i] == 0 || !plain_)) {
      const StepPolynomial motion = polynomial(i);
      position[i] = motion.position(theta);
      velocity[i] = motion.velocity(theta);
    } else {
      position[i] = end_.values[i];
      velocity[i] = end_.values[count_ + i];
    }
  }
}

/// What a mass gained, and what dampers of the masses took [m/s].
double StepMotion::pull_of_line(const StepPolynomial& motion, double theta) const {
  return motion.velocity(theta) - motion.velocity(0.0) +
         damping_.mass * (motion.position(theta) - motion.position(0.0));
}

double StepMotion::line_integral(std::size_t node, double until) const {
  const double length = this->length();
  const double elapsed = until - begin();
  if (elapsed <= 0.0) {
    return 0.0;
  }
  const double theta = std::min(elapsed / length, 1.0);
  if (contact_->resting(node) && plain_) {
    // Simpson's rule, exact for the cubic.
    return elapsed * (start_.values[node] + (start_.line.stretch[node] + 4.0 * resting_stretch(node, 0.5 * theta) +
                                             resting_stretch(node, theta)) /
                                                6.0);
  }
  const StepPolynomial motion = polynomial(node);
  // By the line: what the mass gained, without what dampers took and supports gave.
  double pulled = pull_of_line(motion, theta);
  if (damping_.stiffness != 0.0) {
    const StepPolynomial line = stretch_polynomial(node);
    pulled -=
        damping_.stiffness * wf2_ * (line.position(theta) - line.position(0.0) - theta * length * load_rate(node));
  }
  for (const ContactSet& set : contact_->sets()) {
    pulled -= !plain_ && node >= set.first && node < set.last ? action(set, node, theta).push : 0.0;
  }
  return motion.integral(theta) + pulled / wf2_;
}

double StepMotion::mass_integral(std::size_t node, double until) const {
  const double elapsed = until - begin();
  if (elapsed <= 0.0) {
    return 0.0;
  }
  return contact_->resting(node) && plain_ ? start_.values[node] * elapsed
                                           : polynomial(node).integral(std::min(elapsed / length(), 1.0));
}

/// In a mode wf^2 times the amplitude is f - w^2 q: the integrals of the loads, linear in a step, and of the masses.
/// What holds the line is no load, but then the line alone pulls the masses.
std::vector<double> StepMotion::amplitude_integrals(double until) const {
  const FilteredStructure& line = equations_->line();
  std::vector<double> integrals(line.corrected_modes().size());
  if (integrals.empty() || !(until > begin())) {
    return integrals;
  }
  const double length = this->length();
  const double elapsed = std::min(until - begin(), length);
  if (contact_->on_line()) {
    for (std::size_t i = 0; i < count_; ++i) {
      const double pulled = pull_of_line(polynomial(i), elapsed / length) / wf2_;
      for (std::size_t mode = 0; mode < integrals.size(); ++mode) {
        integrals[mode] += line.mass()[i] * line.corrected_modes()[mode].shape[i] * pulled;
      }
    }
    MPI_Allreduce(MPI_IN_PLACE, integrals.data(), static_cast<int>(integrals.size()), MPI_DOUBLE, MPI_SUM,
                  equations_->points().comm());
    return integrals;
  }
  std::vector<double> work;
  std::vector<double> given(count_);  // integral of F
  for (const double end : {0.0, 1.0}) {
    const std::span<const double> force = equations_->loads().force({begin() + end * elapsed, begin()}, work);
    for (std::size_t i = 0; i < force.size(); ++i) {
      given[i] += 0.5 * elapsed * force[i];
    }
  }
  for (std::size_t i = 0; i < count_; ++i) {
    const double place =
        contact_->resting(i) && plain_ ? start_.values[i] * elapsed : polynomial(i).integral(elapsed / length);
    const double moved = place - equations_->axis()[i] * elapsed;
    for (std::size_t mode = 0; mode < integrals.size(); ++mode) {
      const CorrectedMode& of = line.corrected_modes()[mode];
      integrals[mode] += of.shape[i] * (given[i] - of.frequency * of.frequency * line.mass()[i] * moved) / wf2_;
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, integrals.data(), static_cast<int>(integrals.size()), MPI_DOUBLE, MPI_SUM,
                equations_->points().comm());
  return integrals;
}

}  // namespace udar
