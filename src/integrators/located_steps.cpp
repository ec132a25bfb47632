#include "udar/integrators/located_steps.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include "udar/numerics/bernstein.hpp"
#include "udar/numerics/gauss.hpp"
#include "udar/numerics/roots.hpp"
#include "udar/petsc/array.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/session.hpp"

namespace udar {
namespace {

using petsc::ReadArray;
using petsc::WriteArray;

constexpr double kNever = std::numeric_limits<double>::infinity();

// Absolute tolerance of the step control, in units of rtol and the scale of the motion: keeps the energy of e = 1 runs
// to 10 rtol per 20 impacts (tests/verification).
constexpr double kAbsoluteShare = 0.05;
// The dense output places an instant within this share of the step; later corrections stay inside.
constexpr double kInstantWindow = 1e-2;
// Newton's method on the exact step converges quadratically; more corrections mean a grazing contact, met well enough.
constexpr int kMostCorrections = 12;
// How a restart file keeps what holds a mass: how, whether since now, and by which side.
constexpr int kFresh = 4;
constexpr int kAbove = 8;

}  // namespace

LocatedSteps::LocatedSteps(TS stepper, const ImpactProblem& problem)
    : stepper_{stepper},
      equations_{problem.equations},
      contact_{problem.contact},
      count_{static_cast<std::size_t>(equations_->beam().local_nodes())},
      wf2_{equations_->line().filter_frequency() * equations_->line().filter_frequency()},
      scale_{problem.scale} {
  TSType type = nullptr;
  UDAR_CALL(TSGetType(stepper_, &type));
  const std::string_view name{type};
  if (name != TSRK && name != TSEULER && name != TSSSP) {
    throw InputError{
        "ts type: '" + std::string{name} +
        "' is not allowed, expected one of chebyshev, impact, rk, euler, ssp; the filtered motion is an explicit "
        "system Y' = f(t, Y) without Jacobian or splitting, which this integrator would need"};
  }
  first_stage_at_start_ = name == TSRK || name == TSEULER;
  if (name == TSRK) {
    PetscBool same_as_last = PETSC_FALSE;
    UDAR_CALL(TSRKGetTableau(stepper_, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, &same_as_last));
    last_stage_at_end_ = same_as_last == PETSC_TRUE;
  }
  damping_ = equations_->damping();
  plain_ = !damping_.any();
  for (const Support& support : contact_->supports()) {  // the same on every rank
    plain_ = plain_ && (contact_->runs_on_line() || (!support.motion && !support.elastic()));
  }
  for (const ContactSet& run : contact_->runs()) {
    touches_.emplace_back(run.elastic() ? run.last - run.first : 0);
  }
  UDAR_CALL(TSGetSolution(stepper_, &state_));
  UDAR_CALL(VecDuplicate(state_, start_state_.put()));
  UDAR_CALL(TSSetRHSFunction(stepper_, nullptr, rhs_callback, this));
  PetscBool given = PETSC_FALSE;
  UDAR_CALL(PetscOptionsHasName(nullptr, nullptr, "-ts_atol", &given));
  if (given == PETSC_FALSE) {
    UDAR_CALL(VecDuplicate(state_, absolute_.put()));
    UDAR_CALL(TSSetTolerances(stepper_, PETSC_DEFAULT, absolute_, PETSC_DEFAULT, nullptr));
    set_absolute_tolerance();
  }
}

void LocatedSteps::set_absolute_tolerance() {
  if (absolute_ == nullptr) {
    return;
  }
  double rtol = 0.0;
  UDAR_CALL(TSGetTolerances(stepper_, nullptr, nullptr, &rtol, nullptr));
  const WriteArray tolerance{absolute_};
  std::fill_n(tolerance.values(), count_, kAbsoluteShare * rtol * scale_.length);
  std::fill_n(tolerance.values() + count_, count_, kAbsoluteShare * rtol * scale_.velocity);
}

PetscErrorCode LocatedSteps::rhs_callback(TS /*stepper*/, PetscReal time, Vec state, Vec rate, void* context) {
  PetscFunctionBeginUser;
  auto* self = static_cast<LocatedSteps*>(context);
  PetscCall(petsc::guarded([&] { self->right_hand_side(time, state, rate); }));
  PetscFunctionReturn(0);
}

void LocatedSteps::right_hand_side(double time, Vec state, Vec rate) {
  ++evaluations_;
  const ReadArray now{state};
  const LineState* line = &start_;
  if (!first_stage_at_start_ || time != start_.time) {
    equations_->evaluate({time, start_.time}, {now.values(), count_}, last_);
    line = &last_;
  }
  if (damping_.stiffness != 0.0) {
    stage_rate_.resize(count_);
    equations_->evaluate_rate({now.values() + count_, count_}, stage_rate_);
  }
  const WriteArray change{rate};
  for (std::size_t i = 0; i < count_; ++i) {
    const bool moves = !contact_->resting(i);
    change.values()[i] = moves ? now.values()[count_ + i] : 0.0;
    change.values()[count_ + i] = moves ? wf2_ * line->stretch[i] : 0.0;
    if (damping_.any() && moves) {
      const double turn = damping_.stiffness != 0.0 ? stage_rate_[i] : 0.0;
      change.values()[count_ + i] += damping_.stiffness * wf2_ * turn - damping_.mass * now.values()[count_ + i];
    }
  }
  for (const ContactSet& run : contact_->runs()) {
    const SupportMotion::State lift = run.lift(time, start_.time);
    for (std::size_t node = run.first; node < run.last && !run.plain(); ++node) {
      if (contact_->resting_on(node, run)) {
        change.values()[node] = lift.velocity;
        change.values()[count_ + node] = lift.acceleration;
      } else {
        change.values()[count_ + node] += contact_acceleration(
            run, node, {.position = now.values()[node], .velocity = now.values()[count_ + node]}, time);
      }
    }
  }
}

/// @param rate d(Vm), where the structure is damped
void LocatedSteps::find_accelerations(const double* state, const LineState& line, const std::vector<double>& rate,
                                      std::vector<double>& result, std::vector<double>& bend) {
  const double time = line.time;
  result.resize(count_);
  for (std::size_t i = 0; i < count_; ++i) {
    result[i] = contact_->resting(i) ? 0.0 : wf2_ * line.stretch[i];
    if (damping_.any() && !contact_->resting(i)) {
      result[i] += damping_.stiffness * wf2_ * rate[i] - damping_.mass * state[count_ + i];
    }
  }
  for (const ContactSet& run : contact_->runs()) {
    for (std::size_t node = run.first; node < run.last && !run.plain(); ++node) {
      if (contact_->resting_on(node, run)) {
        result[node] = run.lift(time, start_.time).acceleration;
      } else {
        result[node] +=
            contact_acceleration(run, node, {.position = state[node], .velocity = state[count_ + node]}, time);
      }
    }
  }
  if (damping_.any()) {
    bend.resize(count_);
    equations_->line().solve(result, {}, bend, {});
  }
}

double LocatedSteps::contact_acceleration(const ContactSet& run, std::size_t node, const Kinematics& mass,
                                          double time) const {
  if (!touch_of(run, node).pressing()) {
    return 0.0;
  }
  const Kinematics open = gap(run, mass, node, time);
  return -run.side * (run.stiffness * open.position + run.damping * open.velocity);
}

Kinematics LocatedSteps::gap(const ContactSet& run, const Kinematics& mass, std::size_t node, double time) const {
  const SupportMotion::State lift = run.lift(time, start_.time);
  return {.position = run.side * (mass.position - run.height(node) - lift.height),
          .velocity = run.side * (mass.velocity - lift.velocity),
          .acceleration = run.side * (mass.acceleration - lift.acceleration)};
}

Kinematics LocatedSteps::kinematics(std::size_t node, const double* state, const LineState& line) const {
  const double acceleration = plain_           ? (!contact_->resting(node) ? wf2_ * line.stretch[node] : 0.0)
                              : &line == &end_ ? end_acceleration_[node]
                                               : start_acceleration_[node];
  return {.position = state[node], .velocity = state[count_ + node], .acceleration = acceleration};
}

StepPolynomial LocatedSteps::polynomial(std::size_t node) const {
  return {kinematics(node, start_values_, start_), kinematics(node, end_values_, end_), end_.time - start_.time};
}

void LocatedSteps::load_end(double time) {
  const ReadArray end{state_};
  if (last_stage_at_end_ && last_.time == time) {
    std::swap(end_, last_);
  } else {
    equations_->evaluate({time, start_.time}, {end.values(), count_}, end_);
  }
  if (contact_->counts().resting > 0 || damping_.any()) {
    if (!start_rate_valid_) {
      start_rate_.resize(count_);
      const ReadArray start{start_state_};
      equations_->evaluate_rate({start.values() + count_, count_}, start_rate_);
      start_rate_valid_ = true;
    }
    end_rate_.resize(count_);
    equations_->evaluate_rate({end.values() + count_, count_}, end_rate_);
    load_rate_ = equations_->load_rate(start_.time).stretch;
  }
  if (!plain_) {
    find_accelerations(end.values(), end_, end_rate_, end_acceleration_, end_bend_);
  }
}

LocatedSteps::Pull LocatedSteps::pull(const ContactSet& run, std::size_t node, bool at_end) const {
  const double time = at_end ? end_.time : start_.time;
  const double length = end_.time - start_.time;
  const SupportMotion::State lift = run.lift(time, start_.time);
  const double before = run.lift(start_.time, start_.time).acceleration;
  const double jerk = length > 0.0 ? (run.lift(end_.time, start_.time).acceleration - before) / length : 0.0;
  const double rate = (at_end ? end_rate_ : start_rate_)[node];
  const double bend = damping_.any() ? (at_end ? end_bend_ : start_bend_)[node] : 0.0;
  return {
      .value = (at_end ? end_ : start_).stretch[node] + damping_.stiffness * rate -
               (lift.acceleration + damping_.mass * lift.velocity) / wf2_ -
               run.side * contact_->pull_resolution(run.height(node) + lift.height),
      .rate = rate + load_rate(node) + damping_.stiffness * bend - (jerk + damping_.mass * lift.acceleration) / wf2_};
}

/// Fills `candidates_` with every event on the dense output of the step and returns the earliest time on any rank.
double LocatedSteps::survey(double length) {
  candidates_.clear();
  for (const ContactSet& run : contact_->runs()) {
    for (std::size_t node = run.first; node < run.last; ++node) {
      survey(run, node, length);
    }
  }
  const auto first = std::ranges::min_element(candidates_, {}, &Candidate::time);
  return first != candidates_.end() ? first->time : kNever;
}

void LocatedSteps::add_candidate(Candidate candidate) {
  candidate.met = candidate.time;
  candidates_.push_back(candidate);
}

void LocatedSteps::survey(const ContactSet& run, std::size_t node, double length) {
  if (contact_->resting_on(node, run)) {
    const Pull first = pull(run, node, false);
    const Pull last = pull(run, node, true);
    const auto pressing = cubic_bernstein(-run.side * first.value, -run.side * first.rate, -run.side * last.value,
                                          -run.side * last.rate, length);
    if (const auto theta = first_closing(pressing, 0)) {
      const double slope = -bernstein_slope(pressing, *theta, length);
      add_candidate({.run = &run, .node = node, .time = start_.time + *theta * length, .slope = slope});
    }
    return;
  }
  if (contact_->resting(node)) {
    return;  // on another support
  }
  if (touch_of(run, node).closed()) {
    return survey_touch(run, node, length);
  }
  Kinematics start = gap(run, kinematics(node, start_values_, start_), node, start_.time);
  const Kinematics end = gap(run, kinematics(node, end_values_, end_), node, end_.time);
  // Inside one step, which resolves the motion, a gap changes by less than twice the larger end speed times the step.
  const double reach = 2.0 * length * std::max(std::abs(start.velocity), std::abs(end.velocity));
  if (std::min(start.position, end.position) > reach && start.position > 0.0) {
    return;
  }
  int touching = 0;
  if (start.position <= 0.0 && start.velocity >= 0.0) {
    start.position = 0.0;
    touching = 1;
    if (start.velocity == 0.0 && run.elastic()) {
      touching = 2;
    } else if (start.velocity == 0.0) {
      start.acceleration = std::max(start.acceleration, 0.0);  // just released: zero but for round-off
      touching = 2;
    }
  }
  if (const auto theta = first_closing(StepPolynomial{start, end, length}.bernstein(), touching)) {
    add_candidate({.run = &run, .node = node, .time = start_.time + *theta * length});
  }
}

/// A closed gap: when its force falls to zero or, where it has none, comes back or the gap opens.
void LocatedSteps::survey_touch(const ContactSet& run, std::size_t node, double length) {
  const ElasticTouch touch = touch_of(run, node);
  const StepPolynomial open{gap(run, kinematics(node, start_values_, start_), node, start_.time),
                            gap(run, kinematics(node, end_values_, end_), node, end_.time), length};
  const auto& c = open.bernstein();
  constexpr double kDegree = 5.0;
  std::array<double, 6> force{};
  std::array<double, 6> depth{};
  for (std::size_t i = 0; i < c.size(); ++i) {
    // The rate, of degree four, raised to five.
    const double share = static_cast<double>(i) / kDegree;
    const double rate = (i > 0 ? share * (c[i] - c[i - 1]) : 0.0) + (i < 5 ? (1.0 - share) * (c[i + 1] - c[i]) : 0.0);
    force[i] = touch.sign() * (run.stiffness * c[i] + run.damping * kDegree / length * rate);
    depth[i] = -c[i];
  }
  const auto add = [&](std::optional<double> theta, bool opens) {
    if (theta) {
      add_candidate({.run = &run, .node = node, .time = start_.time + *theta * length, .opens = opens});
    }
    return theta.has_value();
  };
  const auto back = first_closing(force, touch.starts_at_zero() ? 1 : 0);
  const auto out = touch.slack() ? first_closing(depth, 0) : std::nullopt;
  if (out && (!back || *out < *back)) {
    add(out, true);
  } else {
    add(back, touch.opens_with_force(run.damping));
  }
}

void LocatedSteps::return_to_start() {
  UDAR_CALL(VecCopy(start_state_, state_));
  UDAR_CALL(TSSetTime(stepper_, start_.time));
  UDAR_CALL(TSSetConvergedReason(stepper_, TS_CONVERGED_ITERATING));
  UDAR_CALL(TSRestartStep(stepper_));
}

/// Takes the step again from its start, now ending at `time`; returns where it ended, `time` but for its last bit.
double LocatedSteps::repeat_step(double time) {
  return_to_start();
  TSAdapt adapt = nullptr;
  UDAR_CALL(TSGetAdapt(stepper_, &adapt));
  UDAR_CALL(TSAdaptSetAlwaysAccept(adapt, PETSC_TRUE));
  UDAR_CALL(TSSetTimeStep(stepper_, time - start_.time));
  UDAR_CALL(TSStep(stepper_));
  UDAR_CALL(TSAdaptSetAlwaysAccept(adapt, PETSC_FALSE));
  UDAR_CALL(TSSetConvergedReason(stepper_, TS_CONVERGED_ITERATING));
  ++repeated_steps_;
  double reached = 0.0;
  UDAR_CALL(TSGetTime(stepper_, &reached));
  load_end(reached);
  return reached;
}

/// The instant of a candidate as the state at `time` corrects it.
double LocatedSteps::corrected_time(const Candidate& candidate, double time) const {
  const std::size_t node = candidate.node;
  const ContactSet& run = *candidate.run;
  if (contact_->resting(node)) {
    return candidate.slope > 0.0 ? time - run.side * pull(run, node, true).value / candidate.slope : candidate.time;
  }
  const ReadArray end{state_};
  Kinematics open = gap(run, kinematics(node, end.values(), end_), node, time);
  const ElasticTouch touch = touch_of(run, node);
  if (touch.closed() && !candidate.opens) {
    const double sign = touch.sign();
    open = {.position = sign * (run.stiffness * open.position + run.damping * open.velocity),
            .velocity = sign * (run.stiffness * open.velocity + run.damping * open.acceleration)};
  } else if (touch.closed()) {
    open = {.position = -open.position, .velocity = -open.velocity};
  }
  return open.velocity < 0.0 ? time - open.position / open.velocity : candidate.time;
}

/// Moves the end of the step to the first event; returns its time. What is due there is what told this time: states of
/// repeated steps differ by rounding, and so would candidates corrected anew.
double LocatedSteps::hit(double event_time, double step_end) {
  const double window = kInstantWindow * (step_end - start_.time);
  double target = event_time;
  double reached = start_.time;
  for (int correction = 0; correction < kMostCorrections; ++correction) {
    if (target - start_.time <= time_resolution(start_.time)) {
      return_to_start();
      end_ = start_;
      end_acceleration_ = start_acceleration_;
      if (start_rate_valid_) {
        end_rate_ = start_rate_;
      }
      end_bend_ = start_bend_;
      return start_.time;
    }
    reached = repeat_step(target);
    double next = kNever;
    for (Candidate& candidate : candidates_) {
      if (candidate.time <= event_time + window) {
        candidate.met =
            std::clamp(corrected_time(candidate, reached), candidate.time - window, candidate.time + window);
        candidate.met = std::clamp(candidate.met, start_.time, step_end);
        next = std::min(next, candidate.met);
      }
    }
    MPI_Allreduce(MPI_IN_PLACE, &next, 1, MPI_DOUBLE, MPI_MIN, equations_->beam().comm());
    target = next;
    if (std::abs(target - reached) <= time_resolution(reached)) {
      break;
    }
  }
  return reached;
}

double LocatedSteps::line_gap(const ContactSet& run, std::size_t node, double theta) const {
  const double place = contact_->resting(node) && plain_ ? start_values_[node] : polynomial(node).position(theta);
  const double lift = run.lift(start_.time + theta * (end_.time - start_.time), start_.time).height;
  const double line = place + stretch(run, node, theta) - amplitude_offset(node, theta);
  return run.side * (line - run.height(node) - lift);
}

StepPolynomial LocatedSteps::stretch_polynomial(std::size_t node) const {
  const double of_loads = load_rate(node);
  return {
      {.position = start_.stretch[node], .velocity = start_rate_[node] + of_loads, .acceleration = start_bend_[node]},
      {.position = end_.stretch[node], .velocity = end_rate_[node] + of_loads, .acceleration = end_bend_[node]},
      end_.time - start_.time};
}

/// What the dampers of the structure see: a linear image of the masses' own polynomials, so that at no instant these
/// gain energy by them.
double LocatedSteps::damper_rate(std::size_t node, double theta) const {
  return stretch_polynomial(node).velocity(theta) - load_rate(node);
}

/// Of the line from a mass at rest on a support at rest.
double LocatedSteps::resting_stretch(std::size_t node, double theta) const {
  const double of_loads = load_rate(node);
  return bernstein_value(cubic_bernstein(start_.stretch[node], start_rate_[node] + of_loads, end_.stretch[node],
                                         end_rate_[node] + of_loads, end_.time - start_.time),
                         theta);
}

/// Of the line from a mass that this support, if any, touches.
double LocatedSteps::stretch(const ContactSet& run, std::size_t node, double theta) const {
  const double length = end_.time - start_.time;
  if (damping_.any()) {
    return stretch_polynomial(node).position(theta);
  }
  if (contact_->resting(node)) {
    return resting_stretch(node, theta);
  }
  const StepPolynomial motion = polynomial(node);
  const Kinematics mass{.position = motion.position(theta), .velocity = motion.velocity(theta)};
  return (motion.acceleration(theta) - contact_acceleration(run, node, mass, start_.time + theta * length)) / wf2_;
}

LocatedSteps::Given LocatedSteps::given(const ContactSet& run, std::size_t node, double theta) const {
  Given sum;
  const double length = end_.time - start_.time;
  const bool rests = contact_->resting_on(node, run);
  const ElasticTouch touch = touch_of(run, node);
  if (length <= 0.0 || (!rests && !touch.closed())) {
    return sum;
  }
  const StepPolynomial motion = polynomial(node);
  const auto open = [&](double share) {
    return gap(run, {.position = motion.position(share), .velocity = motion.velocity(share)}, node,
               start_.time + share * length);
  };
  if (touch.slack()) {
    const double from = open(0.0).position;
    const double to = open(theta).position;
    sum.flow.damped = 0.5 * run.stiffness * (from * from - to * to);
    return sum;
  }
  for (const auto& [at, weight] : kGauss) {
    const double share = at * theta;
    const double time = start_.time + share * length;
    const SupportMotion::State lift = run.lift(time, start_.time);
    const double span = weight * theta * length;
    double push = 0.0;
    if (rests) {
      push = lift.acceleration + damping_.mass * lift.velocity - wf2_ * stretch(run, node, share);
      push -= damping_.any() ? damping_.stiffness * wf2_ * damper_rate(node, share) : 0.0;
    } else {
      const Kinematics now = open(share);
      push = -run.side * (run.stiffness * now.position + run.damping * now.velocity);
      sum.flow.damped += run.damping * now.velocity * now.velocity * span;
    }
    sum.push += push * span;
    sum.flow.work += push * lift.velocity * span;
  }
  return sum;
}

EnergyFlow LocatedSteps::flow(double until) const {
  EnergyFlow sum;
  const double length = end_.time - start_.time;
  const double share = length > 0.0 ? std::clamp((until - start_.time) / length, 0.0, 1.0) : 0.0;
  // Of the parabola through three instants: Simpson's rule at the end.
  const auto& [start, middle, end] = power_;
  sum.work +=
      length * share *
      (start + share * (0.5 * (4.0 * middle - 3.0 * start - end) + share * 2.0 / 3.0 * (start + end - 2.0 * middle)));
  for (std::size_t i = 0; i < count_ && damping_.any() && length > 0.0; ++i) {
    const StepPolynomial motion = polynomial(i);
    const StepPolynomial line = stretch_polynomial(i);
    for (const auto& [at, weight] : kGauss) {
      const double speed = motion.velocity(at * share);
      const double turn = line.velocity(at * share) - load_rate(i);
      const double taken = damping_.mass * speed - damping_.stiffness * wf2_ * turn;
      sum.damped += equations_->line().mass()[i] * weight * share * length * speed * taken;
    }
  }
  for (const ContactSet& run : contact_->runs()) {
    for (std::size_t node = run.first; node < run.last && !run.plain(); ++node) {
      const EnergyFlow one = given(run, node, share).flow;
      sum.work += equations_->line().mass()[node] * one.work;
      sum.damped += equations_->line().mass()[node] * one.damped;
    }
  }
  return sum;
}

/// Masses at rest on moving supports are where these are, whatever the integrator made of it.
void LocatedSteps::ride() {
  const WriteArray state{state_};
  for (const ContactSet& run : contact_->runs()) {
    const SupportMotion::State lift = run.lift(end_.time, start_.time);
    for (std::size_t node = run.first; node < run.last && run.motion; ++node) {
      if (contact_->resting_on(node, run)) {
        state.values()[node] = run.height(node) + lift.height;
        state.values()[count_ + node] = lift.velocity;
      }
    }
  }
}

/// Masses begin and end to press on supports that are not rigid.
void LocatedSteps::change_touches() {
  for (auto& of_run : touches_) {
    for (ElasticTouch& touch : of_run) {
      touch.pass();
    }
  }
  const WriteArray state{state_};
  for (const Candidate& candidate : candidates_) {
    const ContactSet& run = *candidate.run;
    const std::size_t node = candidate.node;
    if (!event_ || !run.elastic() || !is_due(candidate)) {
      continue;
    }
    ElasticTouch& touch = touches_[index_of(run)][node - run.first];
    const SupportMotion::State lift = run.lift(end_.time, start_.time);
    if (touch.changes_on_face(candidate.opens)) {
      state.values()[node] = run.height(node) + lift.height;
    }
    touch.change(candidate.opens, run.damping, run.side * (state.values()[count_ + node] - lift.velocity));
  }
}

/// Impulses and work of the forces that held the line in the step, by Simpson's rule: one more line solve.
void LocatedSteps::track_line_contact() {
  LineContact& contact = *equations_->line_contact();
  const double length = end_.time - start_.time;
  if (length <= 0.0) {
    return;
  }
  std::vector<double> middle(count_);
  for (std::size_t i = 0; i < count_; ++i) {
    middle[i] = polynomial(i).position(0.5);
  }
  LineState halfway;
  equations_->evaluate({start_.time + 0.5 * length, start_.time}, middle, halfway);
  power_ = {contact.power(start_.contact_force, start_.time), contact.power(halfway.contact_force, halfway.time),
            contact.power(end_.contact_force, end_.time)};
  for (const std::size_t i : contact.mine()) {
    const LinePoint& point = contact.points()[i];
    contact_->press(
        point.support,
        point.side * length / 6.0 * (start_.contact_force[i] + 4.0 * halfway.contact_force[i] + end_.contact_force[i]));
    const std::size_t node = contact.local(i);
    if (std::max({start_.contact_force[i], halfway.contact_force[i], end_.contact_force[i]}) > 0.0) {
      contact_->touch(node, start_.time, end_.time);
    }
    contact_->line_at(
        point.side * (end_values_[node] + end_.stretch[node] - point.height - point.lift(end_.time).height), node,
        end_.time);
  }
  const bool early = start_.held;
  const bool late = end_.held;
  if (early || late || halfway.held) {
    contact_->hold(early ? start_.time : halfway.time, late ? end_.time : halfway.time);
  }
}

/// Smallest distance of the line, and what resting masses pressed.
void LocatedSteps::track_contact() {
  const double length = end_.time - start_.time;
  for (const ContactSet& run : contact_->runs()) {
    const double from = run.lift(start_.time, start_.time).height;
    const double to = run.lift(end_.time, start_.time).height;
    for (std::size_t node = run.first; node < run.last; ++node) {
      const double first = run.side * (start_values_[node] + start_.stretch[node] - amplitude_offset(node, 0.0) -
                                       run.height(node) - from);
      const double last =
          run.side * (end_values_[node] + end_.stretch[node] - amplitude_offset(node, 1.0) - run.height(node) - to);
      contact_->line_at(last, node, end_.time);
      // The minimum may lie inside the step: look there when the ends are close enough to the smallest gap so far.
      if (length > 0.0 && contact_->smallest(std::min(first, last) - std::abs(last - first))) {
        for (const double theta : {0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875}) {
          contact_->line_at(line_gap(run, node, theta), node, start_.time + theta * length);
        }
      }
      if (!run.plain()) {
        const Given all = given(run, node, 1.0);
        const double mass = equations_->line().mass()[node];
        contact_->press(run.support, mass * all.push);
        if (length > 0.0 && touch_of(run, node).closed()) {
          contact_->touch(node, start_.time, end_.time);
        }
      } else if (length > 0.0 && contact_->resting_on(node, run)) {
        const double stretch =
            0.5 * length * (start_.stretch[node] + end_.stretch[node]) +
            length * length / 12.0 * (start_rate_[node] - end_rate_[node]) +
            damping_.stiffness * (end_.stretch[node] - start_.stretch[node] - length * load_rate(node));
        contact_->press(run.support, -wf2_ * equations_->line().mass()[node] * stretch);
      }
    }
  }
}

double LocatedSteps::end_step() {
  double time = 0.0;
  UDAR_CALL(TSGetTime(stepper_, &time));
  UDAR_CALL(TSGetTimeStep(stepper_, &next_step_));
  const double length = time - start_.time;
  load_end(time);
  double zero = 0.0;  // stays zero unless some value is not finite
  double speed = 0.0;
  for (std::size_t i = 0; i < count_; ++i) {
    zero += 0.0 * (end_values_[i] + end_values_[count_ + i] + end_.stretch[i]);
    speed = std::max(speed, std::abs(end_values_[count_ + i]));
  }
  const bool finite = zero == 0.0;
  double event_time = finite ? survey(length) : kNever;
  std::array<double, 3> earliest{event_time, finite ? 1.0 : 0.0, -speed};
  MPI_Allreduce(MPI_IN_PLACE, earliest.data(), static_cast<int>(earliest.size()), MPI_DOUBLE, MPI_MIN,
                equations_->beam().comm());
  event_time = earliest[0];
  if (earliest[1] == 0.0) {
    throw SolveError{
        "the motion is no longer finite after t = " + std::to_string(start_.time) +
        " s; the time step is too long for `filter frequency` (see -ts_dt, -ts_adapt_type) or a load is not finite"};
  }
  if (scale_.grow(-earliest[2], equations_->line().frequency_bound())) {
    set_absolute_tolerance();
  }
  event_ = event_time <= time;
  if (event_) {
    time = hit(event_time, time);
    next_step_ = length;  // what the error control had accepted before the event cut the step
  }
  if (!plain_) {
    ride();
  }
  track_contact();
  if (equations_->line_contact() != nullptr) {
    track_line_contact();
  }
  contact_->flow(flow(time));
  return time;
}

void LocatedSteps::apply_events() {
  if (!plain_) {
    change_touches();
  }
  if (!event_) {
    return;
  }
  const double time = end_.time;
  std::vector<std::int32_t> due(count_, 0);
  for (const Candidate& candidate : candidates_) {
    if (!candidate.run->elastic() && is_due(candidate)) {
      due[candidate.node] = candidate.run->support + 1;
    }
  }
  const WriteArray state{state_};
  std::vector<double> damped;  // as the stretch of a mass without speed pulls
  for (std::size_t i = 0; i < count_ && damping_.any(); ++i) {
    damped.push_back(end_.stretch[i] + damping_.stiffness * (end_rate_[i] + state.values()[count_ + i]));
  }
  contact_->resolve(time, due, wf2_, {state.values(), count_}, {state.values() + count_, count_},
                    damping_.any() ? damped : end_.stretch);
}

void LocatedSteps::start(const LineState& line) {
  end_ = line;
  begin_step();
}

void LocatedSteps::begin_step() {
  start_ = end_;
  UDAR_CALL(TSGetTime(stepper_, &start_.time));
  start_rate_valid_ = false;
  power_ = {};
  UDAR_CALL(VecCopy(state_, start_state_));
  start_values_ = ReadArray{start_state_}.values();  // PETSc's own vectors stay where they are
  end_values_ = ReadArray{state_}.values();
  if (!plain_) {
    if (damping_.any()) {
      start_rate_.resize(count_);
      equations_->evaluate_rate({start_values_ + count_, count_}, start_rate_);
      start_rate_valid_ = true;
    }
    find_accelerations(start_values_, start_, start_rate_, start_acceleration_, start_bend_);
  }
  UDAR_CALL(TSRestartStep(stepper_));
}

void LocatedSteps::masses(double time, std::span<double> position, std::span<double> velocity,
                          std::span<std::uint8_t> resting) const {
  const double length = end_.time - start_.time;
  const double theta = length > 0.0 ? std::clamp((time - start_.time) / length, 0.0, 1.0) : 1.0;
  for (std::size_t i = 0; i < count_; ++i) {
    resting[i] = contact_->resting(i) ? 1 : 0;
    // At the end the state itself: a step of some units in the last place has no slope.
    if (theta < 1.0 && (resting[i] == 0 || !plain_)) {
      const StepPolynomial motion = polynomial(i);
      position[i] = motion.position(theta);
      velocity[i] = motion.velocity(theta);
    } else {
      position[i] = end_values_[i];
      velocity[i] = end_values_[count_ + i];
    }
  }
}

double LocatedSteps::line_integral(std::size_t node, double until) const {
  const double length = end_.time - start_.time;
  const double elapsed = until - start_.time;
  if (elapsed <= 0.0) {
    return 0.0;
  }
  const double theta = std::min(elapsed / length, 1.0);
  if (contact_->resting(node) && plain_) {
    // Simpson's rule, exact for the cubic.
    return elapsed *
           (start_values_[node] +
            (start_.stretch[node] + 4.0 * resting_stretch(node, 0.5 * theta) + resting_stretch(node, theta)) / 6.0);
  }
  const StepPolynomial motion = polynomial(node);
  // By the line: what the mass gained, without what dampers took and supports gave.
  double pulled =
      motion.velocity(theta) - motion.velocity(0.0) + damping_.mass * (motion.position(theta) - motion.position(0.0));
  if (damping_.stiffness != 0.0) {
    const StepPolynomial line = stretch_polynomial(node);
    pulled -=
        damping_.stiffness * wf2_ * (line.position(theta) - line.position(0.0) - theta * length * load_rate(node));
  }
  for (const ContactSet& run : contact_->runs()) {
    pulled -= !plain_ && node >= run.first && node < run.last ? given(run, node, theta).push : 0.0;
  }
  return motion.integral(theta) + pulled / wf2_;
}

/// In a mode wf^2 times the amplitude is f - w^2 q: the integrals of the loads, linear in a step, and of the masses.
std::vector<double> LocatedSteps::amplitude_integrals(double until) const {
  const FilteredStructure& line = equations_->line();
  std::vector<double> integrals(line.corrected_modes().size());
  if (integrals.empty() || !(until > start_.time)) {
    return integrals;
  }
  const double length = end_.time - start_.time;
  const double elapsed = std::min(until - start_.time, length);
  std::vector<double> work;
  std::vector<double> given(count_);  // integral of F
  for (const double end : {0.0, 1.0}) {
    const std::span<const double> force = equations_->loads().force({start_.time + end * elapsed, start_.time}, work);
    for (std::size_t i = 0; i < force.size(); ++i) {
      given[i] += 0.5 * elapsed * force[i];
    }
  }
  for (std::size_t i = 0; i < count_; ++i) {
    const double place =
        contact_->resting(i) && plain_ ? start_values_[i] * elapsed : polynomial(i).integral(elapsed / length);
    const double moved = place - equations_->axis()[i] * elapsed;
    for (std::size_t mode = 0; mode < integrals.size(); ++mode) {
      const CorrectedMode& of = line.corrected_modes()[mode];
      integrals[mode] += of.shape[i] * (given[i] - of.frequency * of.frequency * line.mass()[i] * moved) / wf2_;
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, integrals.data(), static_cast<int>(integrals.size()), MPI_DOUBLE, MPI_SUM,
                equations_->beam().comm());
  return integrals;
}

/// How much nearer to its mass than the stretch says the line is, in corrected modes: between the ends of a step
/// linear, which is off by (w h)^2 / 8 of it.
double LocatedSteps::amplitude_offset(std::size_t node, double theta) const {
  double offset = 0.0;
  for (std::size_t mode = 0; mode < start_.amplitude.size(); ++mode) {
    offset += ((1.0 - theta) * start_.amplitude[mode] + theta * end_.amplitude[mode]) *
              equations_->line().corrected_modes()[mode].shape[node];
  }
  return offset;
}

/// Forces that all ranks know are saved as a table; others at nodes, in as many fields as supports share a node.
void LocatedSteps::save_forces(const LineContact& contact, MotionState& state) const {
  if (contact.dense()) {
    return;  // with the line
  }
  state.tables.erase("contact_force");
  state.scalars["contact_held"] = start_.held ? 1.0 : 0.0;
  const std::vector<int> layer = layers(contact);
  int count = layer.empty() ? 0 : std::ranges::max(layer) + 1;
  MPI_Allreduce(MPI_IN_PLACE, &count, 1, MPI_INT, MPI_MAX, equations_->beam().comm());
  for (int k = 0; k < count; ++k) {
    std::vector<double>& field = state.fields["contact_force_" + std::to_string(k)];
    field.assign(count_, 0.0);
    for (const std::size_t i : contact.mine()) {
      if (layer[i] == k) {
        field[contact.local(i)] = start_.contact_force[i];
      }
    }
  }
}

void LocatedSteps::restore_forces(const LineContact& contact, const MotionState& state, LineState& line) const {
  if (contact.dense()) {
    line.held = std::ranges::any_of(line.contact_force, [](double force) { return force > 0.0; });
    return;
  }
  line.held = state.scalar("contact_held") != 0.0;
  const std::vector<int> layer = layers(contact);
  line.contact_force.resize(layer.size());
  for (const std::size_t i : contact.mine()) {
    line.contact_force[i] = state.field("contact_force_" + std::to_string(layer[i]), count_)[contact.local(i)];
  }
}

/// How many points before this one have the same node.
std::vector<int> LocatedSteps::layers(const LineContact& contact) const {
  std::vector<int> seen(count_, 0);
  std::vector<int> layer(contact.points().size());
  for (const std::size_t i : contact.mine()) {
    layer[i] = seen[contact.local(i)]++;
  }
  return layer;
}

void LocatedSteps::save(MotionState& state) const {
  save_line(start_, state);
  if (!plain_) {
    std::vector<double>& touch = state.fields["touch"];
    touch.assign(count_, 0.0);
    for (const ContactSet& run : contact_->runs()) {
      for (std::size_t node = run.first; node < run.last && run.elastic(); ++node) {
        const ElasticTouch of = touch_of(run, node);
        const int code = static_cast<int>(of.state()) + (of.starts_at_zero() ? kFresh : 0);
        touch[node] += code * (run.side > 0.0 ? 1 : kAbove);  // one on each side at most
      }
    }
  }
  if (equations_->line_contact() != nullptr) {
    save_forces(*equations_->line_contact(), state);
  }
  state.scalars["repeated_steps"] = static_cast<double>(repeated_steps_);
  state.scalars["rhs_evaluations"] = static_cast<double>(evaluations_);
  state.scalars["scale_length"] = scale_.length;
  state.scalars["scale_velocity"] = scale_.velocity;
}

void LocatedSteps::restore(const MotionState& state) {
  repeated_steps_ = static_cast<PetscInt>(state.scalar("repeated_steps"));
  evaluations_ = static_cast<PetscInt>(state.scalar("rhs_evaluations"));
  scale_ = {.length = state.scalar("scale_length"), .velocity = state.scalar("scale_velocity")};
  set_absolute_tolerance();
  const std::vector<double> none;
  const std::vector<double>& touch = plain_ ? none : state.field("touch", count_);
  for (const ContactSet& run : contact_->runs()) {
    for (std::size_t node = run.first; node < run.last && run.elastic(); ++node) {
      const int code = static_cast<int>(touch[node]) / (run.side > 0.0 ? 1 : kAbove) % kAbove;
      touches_[index_of(run)][node - run.first] =
          ElasticTouch{static_cast<ElasticTouch::State>(code % kFresh), code >= kFresh};
    }
  }
  LineState line = saved_line(state, count_);
  if (equations_->line_contact() != nullptr) {
    restore_forces(*equations_->line_contact(), state, line);
  }
  start(line);
}

}  // namespace udar
