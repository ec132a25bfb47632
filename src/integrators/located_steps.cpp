#include "udar/integrators/located_steps.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <string_view>

#include "udar/motion/finite.hpp"
#include "udar/petsc/array.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/session.hpp"

namespace udar {
namespace {

using petsc::ReadArray;
using petsc::WriteArray;

// Absolute tolerance of the step control, in units of rtol and the scale of the motion: keeps the energy of e = 1 runs
// to 10 rtol per 20 impacts (tests/verification).
constexpr double kAbsoluteShare = 0.05;
// The dense output places an instant within this share of the step; later corrections stay inside.
constexpr double kInstantWindow = 1e-2;
// Newton's method on the exact step converges quadratically; more corrections mean a grazing contact, met well enough.
constexpr int kMostCorrections = 12;

}  // namespace

LocatedSteps::LocatedSteps(TS stepper, const ImpactProblem& problem, bool own_absolute_tolerance)
    : stepper_{stepper},
      equations_{problem.equations},
      contact_{problem.contact},
      count_{equations_->points().points()},
      scale_{problem.scale},
      motion_{*problem.equations, *problem.contact},
      search_{motion_, *problem.contact} {
  TSType type = nullptr;
  UDAR_CALL(TSGetType(stepper_, &type));
  const std::string_view name{type};
  first_stage_at_start_ = name == TSRK || name == TSEULER;
  if (name == TSRK) {
    PetscBool same_as_last = PETSC_FALSE;
    UDAR_CALL(TSRKGetTableau(stepper_, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, &same_as_last));
    last_stage_at_end_ = same_as_last == PETSC_TRUE;
  }
  if (equations_->line_contact() != nullptr) {
    line_contact_.emplace(*equations_, *contact_);
  }
  UDAR_CALL(TSGetSolution(stepper_, &state_));
  UDAR_CALL(VecDuplicate(state_, start_state_.put()));
  UDAR_CALL(TSSetRHSFunction(stepper_, nullptr, rhs_callback, this));
  if (own_absolute_tolerance) {
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
  const double wf2 = motion_.wf2();
  const Damping& damping = equations_->damping();
  const LineState* line = &motion_.start().line;
  if (!first_stage_at_start_ || time != motion_.begin()) {
    equations_->evaluate({time, motion_.begin()}, {now.values(), count_}, last_);
    line = &last_;
  }
  if (damping.stiffness != 0.0) {
    stage_rate_.resize(count_);
    equations_->evaluate_rate({now.values() + count_, count_}, stage_rate_);
  }
  const WriteArray change{rate};
  for (std::size_t i = 0; i < count_; ++i) {
    const bool moves = !contact_->resting(i);
    change.values()[i] = moves ? now.values()[count_ + i] : 0.0;
    change.values()[count_ + i] = moves ? wf2 * line->stretch[i] : 0.0;
    if (damping.any() && moves) {
      const double turn = damping.stiffness != 0.0 ? stage_rate_[i] : 0.0;
      change.values()[count_ + i] += damping.stiffness * wf2 * turn - damping.mass * now.values()[count_ + i];
    }
  }
  for (const ContactSet& set : contact_->sets()) {
    const SupportMotion::State lift = set.lift(time, motion_.begin());
    for (std::size_t node = set.first; node < set.last && !set.plain(); ++node) {
      if (contact_->resting_on(node, set)) {
        change.values()[node] = lift.velocity;
        change.values()[count_ + node] = lift.acceleration;
      } else {
        change.values()[count_ + node] += motion_.contact_acceleration(
            set, node, {.position = now.values()[node], .velocity = now.values()[count_ + node]}, time);
      }
    }
  }
}

void LocatedSteps::load_end(double time) {
  StepEnd& start = motion_.start();
  StepEnd& end = motion_.end();
  if (last_stage_at_end_ && last_.time == time) {
    std::swap(end.line, last_);
  } else {
    equations_->evaluate({time, start.line.time}, {end.values, count_}, end.line);
  }
  if (contact_->counts().resting > 0 || equations_->damping().any()) {
    if (!start_rate_valid_) {
      find_rate(start);
      start_rate_valid_ = true;
    }
    find_rate(end);
    motion_.set_load_rate(equations_->load_rate(start.line.time).stretch);
  }
  if (!motion_.plain()) {
    motion_.find_accelerations(end);
  }
}

void LocatedSteps::find_rate(StepEnd& end) {
  end.rate.resize(count_);
  equations_->evaluate_rate({end.values + count_, count_}, end.rate);
  equations_->add_carried_rate({end.line.time, motion_.begin()}, {end.values, count_}, {end.values + count_, count_},
                               end.rate);
}

void LocatedSteps::return_to_start() {
  UDAR_CALL(VecCopy(start_state_, state_));
  UDAR_CALL(TSSetTime(stepper_, motion_.begin()));
  UDAR_CALL(TSSetConvergedReason(stepper_, TS_CONVERGED_ITERATING));
  UDAR_CALL(TSRestartStep(stepper_));
}

/// Takes the step again from its start, now ending at `time`; returns where it ended, `time` but for its last bit.
double LocatedSteps::repeat_step(double time) {
  return_to_start();
  TSAdapt adapt = nullptr;
  UDAR_CALL(TSGetAdapt(stepper_, &adapt));
  UDAR_CALL(TSAdaptSetAlwaysAccept(adapt, PETSC_TRUE));
  UDAR_CALL(TSSetTimeStep(stepper_, time - motion_.begin()));
  UDAR_CALL(TSStep(stepper_));
  UDAR_CALL(TSAdaptSetAlwaysAccept(adapt, PETSC_FALSE));
  UDAR_CALL(TSSetConvergedReason(stepper_, TS_CONVERGED_ITERATING));
  ++repeated_steps_;
  double reached = 0.0;
  UDAR_CALL(TSGetTime(stepper_, &reached));
  load_end(reached);
  return reached;
}

/// Moves the end of the step to the first event; returns its time. What is due there is what told this time: states of
/// repeated steps differ by rounding, and so would events corrected anew.
double LocatedSteps::locate(double event_time, double step_end) {
  const double begin = motion_.begin();
  const double window = kInstantWindow * (step_end - begin);
  double target = event_time;
  double reached = begin;
  for (int correction = 0; correction < kMostCorrections; ++correction) {
    if (target - begin <= time_resolution(begin)) {
      return_to_start();
      motion_.end_at_start(start_rate_valid_);
      return begin;
    }
    reached = repeat_step(target);
    target = search_.correct(event_time + window, window, step_end);
    MPI_Allreduce(MPI_IN_PLACE, &target, 1, MPI_DOUBLE, MPI_MIN, equations_->points().comm());
    if (std::abs(target - reached) <= time_resolution(reached)) {
      break;
    }
  }
  return reached;
}

/// Masses at rest on moving supports are where these are, whatever the integrator made of it.
void LocatedSteps::follow_supports() {
  const WriteArray state{state_};
  for (const ContactSet& set : contact_->sets()) {
    const SupportMotion::State lift = set.lift(motion_.end().line.time, motion_.begin());
    for (std::size_t node = set.first; node < set.last && set.motion; ++node) {
      if (contact_->resting_on(node, set)) {
        state.values()[node] = set.height(node) + lift.height;
        state.values()[count_ + node] = lift.velocity;
      }
    }
  }
}

/// Masses begin and end to press on supports that are not rigid.
void LocatedSteps::change_touches() {
  motion_.touches().pass();
  const WriteArray state{state_};
  for (const ContactEvent& event : search_.events()) {
    const ContactSet& set = *event.set;
    const std::size_t node = event.node;
    if (!event_ || !set.elastic() || !search_.is_due(event)) {
      continue;
    }
    ElasticTouch& touch = motion_.touches().at(set, node);
    const SupportMotion::State lift = set.lift(motion_.end().line.time, motion_.begin());
    if (touch.changes_on_face(event.opens)) {
      state.values()[node] = set.height(node) + lift.height;
    }
    touch.change(event.opens, set.damping, set.side * (state.values()[count_ + node] - lift.velocity));
  }
}

/// Smallest distance of the line, and what resting masses pressed.
void LocatedSteps::track_contact() {
  const StepEnd& start = motion_.start();
  const StepEnd& end = motion_.end();
  const double length = motion_.length();
  for (const ContactSet& set : contact_->sets()) {
    const double from = set.lift(start.line.time, start.line.time).height;
    const double to = set.lift(end.line.time, start.line.time).height;
    for (std::size_t node = set.first; node < set.last; ++node) {
      const double first = set.side * (start.values[node] + start.line.stretch[node] -
                                       motion_.amplitude_offset(node, 0.0) - set.height(node) - from);
      const double last = set.side * (end.values[node] + end.line.stretch[node] - motion_.amplitude_offset(node, 1.0) -
                                      set.height(node) - to);
      contact_->record_gap(last, node, end.line.time);
      // The minimum may lie inside the step: look there when the ends are close enough to the smallest gap so far.
      if (length > 0.0 && contact_->smallest(std::min(first, last) - std::abs(last - first))) {
        for (const double theta : {0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875}) {
          contact_->record_gap(motion_.line_gap(set, node, theta), node, motion_.time(theta));
        }
      }
      if (!set.plain()) {
        const SupportAction all = motion_.action(set, node, 1.0);
        const double mass = equations_->line().mass()[node];
        contact_->journal().record_force(set.support, mass * all.push);
        if (length > 0.0 && motion_.touches().of(set, node).closed()) {
          contact_->journal().record_contact_time(node, {start.line.time, end.line.time});
        }
      } else if (length > 0.0 && contact_->resting_on(node, set)) {
        contact_->journal().record_force(
            set.support, -motion_.wf2() * equations_->line().mass()[node] * motion_.pull_integral(node));
      }
    }
  }
}

double LocatedSteps::end_step() {
  double time = 0.0;
  UDAR_CALL(TSGetTime(stepper_, &time));
  UDAR_CALL(TSGetTimeStep(stepper_, &next_step_));
  const double begin = motion_.begin();
  const double length = time - begin;
  load_end(time);
  const StepEnd& end = motion_.end();
  double zero = 0.0;  // stays zero unless some value is not finite
  double speed = 0.0;
  for (std::size_t i = 0; i < count_; ++i) {
    zero += 0.0 * (end.values[i] + end.values[count_ + i] + end.line.stretch[i]);
    speed = std::max(speed, std::abs(end.values[count_ + i]));
  }
  const bool finite = zero == 0.0;
  double event_time = finite ? search_.survey() : std::numeric_limits<double>::infinity();
  std::array<double, 3> earliest{event_time, finite ? 1.0 : 0.0, -speed};
  MPI_Allreduce(MPI_IN_PLACE, earliest.data(), static_cast<int>(earliest.size()), MPI_DOUBLE, MPI_MIN,
                equations_->points().comm());
  event_time = earliest[0];
  if (earliest[1] == 0.0) {
    require_finite(*equations_, {end.values, count_}, {end.values + count_, count_}, begin);
    throw SolveError{
        "the motion is no longer finite after t = " + std::to_string(begin) +
        " s; the time step is too long for `filter frequency` (see -ts_dt, -ts_adapt_type) or a load is not finite"};
  }
  if (scale_.grow(-earliest[2], equations_->frequency_bound())) {
    set_absolute_tolerance();
  }
  event_ = event_time <= time;
  if (event_) {
    time = locate(event_time, time);
    next_step_ = length;  // what the error control had accepted before the event cut the step
  }
  if (!motion_.plain()) {
    follow_supports();
  }
  track_contact();
  if (line_contact_) {
    line_contact_->track(motion_);
  }
  contact_->journal().record_flow(flow(time));
  return time;
}

/// Friction of masses that were pressed on a support in the step, by the impulse of all of it.
void LocatedSteps::rub_pressed() {
  if (std::ranges::none_of(contact_->supports(), [](const Support& support) { return support.friction > 0.0; })) {
    return;
  }
  const WriteArray state{state_};
  for (const ContactSet& set : contact_->sets()) {
    for (std::size_t node = set.first; node < set.last && set.friction > 0.0 && motion_.length() > 0.0; ++node) {
      const double over_mass = !set.plain()                      ? motion_.action(set, node, 1.0).push
                               : contact_->resting_on(node, set) ? motion_.wf2() * motion_.pull_integral(node)
                                                                 : 0.0;
      const double impulse = over_mass * equations_->line().mass()[node];
      const double lost = contact_->rub(set, node, impulse, {state.values() + count_, count_});
      contact_->journal().record_loss(motion_.end().line.time, lost);
    }
  }
}

void LocatedSteps::apply_events() {
  rub_pressed();
  if (!motion_.plain()) {
    change_touches();
  }
  if (!event_) {
    return;
  }
  const StepEnd& end = motion_.end();
  const Damping& damping = equations_->damping();
  std::vector<std::int32_t> due(count_, 0);
  for (const ContactEvent& event : search_.events()) {
    if (!event.set->elastic() && search_.is_due(event)) {
      due[event.node] = event.set->support + 1;
    }
  }
  const WriteArray state{state_};
  std::vector<double> damped;  // as the stretch of a mass without speed pulls
  for (std::size_t i = 0; i < count_ && damping.any(); ++i) {
    damped.push_back(end.line.stretch[i] + damping.stiffness * (end.rate[i] + state.values()[count_ + i]));
  }
  contact_->resolve({.time = end.line.time,
                     .due = due,
                     .acceleration = motion_.wf2(),
                     .position = {state.values(), count_},
                     .velocity = {state.values() + count_, count_},
                     .stretch = damping.any() ? damped : motion_.end().line.stretch});
}

void LocatedSteps::start(const LineState& line) {
  motion_.end().line = line;
  begin_step();
}

void LocatedSteps::take_over(const LineState& line) {
  const ReadArray now{state_};
  for (const ContactSet& set : contact_->sets()) {
    const SupportMotion::State lift = set.lift(line.time);
    for (std::size_t node = set.first; node < set.last && set.elastic(); ++node) {
      const double gap = set.side * (now.values()[node] - set.height(node) - lift.height);
      const double rate = set.side * (now.values()[count_ + node] - lift.velocity);
      motion_.touches().at(set, node) = ElasticTouch::found(gap, set.stiffness * gap + set.damping * rate);
    }
  }
  start(line);
}

void LocatedSteps::begin_step() {
  StepEnd& start = motion_.start();
  start.line = motion_.end().line;
  UDAR_CALL(TSGetTime(stepper_, &start.line.time));
  start_rate_valid_ = false;
  if (line_contact_) {
    line_contact_->begin_step();
  }
  UDAR_CALL(VecCopy(state_, start_state_));
  start.values = ReadArray{start_state_}.values();  // PETSc's own vectors stay where they are
  motion_.end().values = ReadArray{state_}.values();
  if (!motion_.plain()) {
    if (equations_->damping().any()) {
      find_rate(start);
      start_rate_valid_ = true;
    }
    motion_.find_accelerations(start);
  }
  UDAR_CALL(TSRestartStep(stepper_));
}

EnergyFlow LocatedSteps::flow(double until) const {
  const double length = motion_.length();
  const double share = length > 0.0 ? std::clamp((until - motion_.begin()) / length, 0.0, 1.0) : 0.0;
  EnergyFlow sum = motion_.flow(share);
  sum.work += line_contact_ ? line_contact_->work(length, share) : 0.0;
  return sum;
}

void LocatedSteps::save(MotionState& state) const {
  save_line(motion_.start().line, state);
  if (!motion_.plain()) {
    motion_.touches().save(count_, state);
  }
  if (line_contact_) {
    line_contact_->save(motion_.start().line, count_, state);
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
  if (!motion_.plain()) {
    motion_.touches().restore(count_, state);
  }
  LineState line = saved_line(state, *equations_, count_);
  if (line_contact_) {
    line_contact_->restore(state, count_, line);
  }
  start(line);
}

}  // namespace udar
