#include "udar/dynamics/located_steps.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <string_view>

#include "udar/petsc/array.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/session.hpp"

namespace udar {
namespace {

using petsc::ReadArray;
using petsc::WriteArray;

constexpr double kNever = std::numeric_limits<double>::infinity();

// The dense output places an instant within this share of the step; later corrections stay inside.
constexpr double kInstantWindow = 1e-2;
// Newton's method on the exact step converges quadratically; more corrections mean a grazing contact, met well enough.
constexpr int kMostCorrections = 12;

/// Integral over [0, theta] of the polynomial, times the step length; Gauss-Legendre, exact to degree 5.
double integral(const StepPolynomial& polynomial, double theta, double length) {
  const double offset = 0.5 * theta * std::sqrt(0.6);
  const double middle = 0.5 * theta;
  return length * theta / 18.0 *
         (5.0 * polynomial.position(middle - offset) + 8.0 * polynomial.position(middle) +
          5.0 * polynomial.position(middle + offset));
}

/// Value of a cubic in Bernstein form.
double bernstein_value(const std::array<double, 4>& c, double theta) {
  const double s = 1.0 - theta;
  return s * s * (s * c[0] + 3.0 * theta * c[1]) + theta * theta * (3.0 * s * c[2] + theta * c[3]);
}

}  // namespace

LocatedSteps::LocatedSteps(TS stepper, const ImpactProblem& problem)
    : stepper_{stepper},
      equations_{problem.equations},
      contact_{problem.contact},
      count_{static_cast<std::size_t>(equations_->beam().local_nodes())},
      wf2_{equations_->line().filter_frequency() * equations_->line().filter_frequency()} {
  TSType type = nullptr;
  UDAR_CALL(TSGetType(stepper_, &type));
  const std::string_view name{type};
  if (name != TSRK && name != TSEULER && name != TSSSP) {
    throw InputError{
        "option -ts_type: '" + std::string{name} +
        "' is not allowed, expected one of chebyshev, impact, rk, euler, ssp; the filtered motion is an explicit "
        "system Y' = f(t, Y) without Jacobian or splitting, which this integrator would need"};
  }
  first_stage_at_start_ = name == TSRK || name == TSEULER;
  if (name == TSRK) {
    PetscBool same_as_last = PETSC_FALSE;
    UDAR_CALL(TSRKGetTableau(stepper_, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, &same_as_last));
    last_stage_at_end_ = same_as_last == PETSC_TRUE;
  }
  UDAR_CALL(TSGetSolution(stepper_, &state_));
  UDAR_CALL(VecDuplicate(state_, start_state_.put()));
  UDAR_CALL(TSSetRHSFunction(stepper_, nullptr, rhs_callback, this));
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
    equations_->evaluate(time, {now.values(), count_}, last_);
    line = &last_;
  }
  const WriteArray change{rate};
  for (std::size_t i = 0; i < count_; ++i) {
    const bool moves = !contact_->resting(i);
    change.values()[i] = moves ? now.values()[count_ + i] : 0.0;
    change.values()[count_ + i] = moves ? wf2_ * line->stretch[i] : 0.0;
  }
}

Kinematics LocatedSteps::kinematics(std::size_t node, const double* state, const LineState& line) const {
  return {.position = state[node],
          .velocity = state[count_ + node],
          .acceleration = !contact_->resting(node) ? wf2_ * line.stretch[node] : 0.0};
}

StepPolynomial LocatedSteps::polynomial(std::size_t node) const {
  return {kinematics(node, start_values_, start_), kinematics(node, end_values_, end_), end_.time - start_.time};
}

void LocatedSteps::load_end(double time) {
  const ReadArray end{state_};
  if (last_stage_at_end_ && last_.time == time) {
    std::swap(end_, last_);
  } else {
    equations_->evaluate(time, {end.values(), count_}, end_);
  }
  if (contact_->counts().resting > 0) {
    if (!start_rate_valid_) {
      start_rate_.resize(count_);
      const ReadArray start{start_state_};
      equations_->evaluate_rate(start_.time, {start.values() + count_, count_}, start_rate_);
      start_rate_valid_ = true;
    }
    end_rate_.resize(count_);
    equations_->evaluate_rate(time, {end.values() + count_, count_}, end_rate_);
  }
}

/// Fills `candidates_` with every event on the dense output of the step and returns the earliest time on any rank.
double LocatedSteps::survey(double length) {
  candidates_.clear();
  for (const ContactRun& run : contact_->runs()) {
    for (std::size_t node = run.first; node < run.last; ++node) {
      survey(run, node, length);
    }
  }
  const auto first = std::ranges::min_element(candidates_, {}, &Candidate::time);
  return first != candidates_.end() ? first->time : kNever;
}

void LocatedSteps::survey(const ContactRun& run, std::size_t node, double length) {
  if (contact_->resting_on(node, run)) {
    const auto pressing = cubic_bernstein(-run.side * start_.stretch[node], -run.side * start_rate_[node],
                                          -run.side * end_.stretch[node], -run.side * end_rate_[node], length);
    if (const auto theta = first_closing(pressing, 0)) {
      const double s = 1.0 - *theta;
      const double slope = -3.0 / length *
                           (s * s * (pressing[1] - pressing[0]) + 2.0 * s * *theta * (pressing[2] - pressing[1]) +
                            *theta * *theta * (pressing[3] - pressing[2]));
      candidates_.push_back({.run = &run, .node = node, .time = start_.time + *theta * length, .slope = slope});
    }
    return;
  }
  if (contact_->resting(node)) {
    return;  // on another support
  }
  const auto seen = [&run, node](Kinematics motion) {
    return Kinematics{.position = run.side * (motion.position - run.height(node)),
                      .velocity = run.side * motion.velocity,
                      .acceleration = run.side * motion.acceleration};
  };
  Kinematics start = seen(kinematics(node, start_values_, start_));
  const Kinematics end = seen(kinematics(node, end_values_, end_));
  // Inside one step, which resolves the motion, a gap changes by less than twice the larger end speed times the step.
  const double reach = 2.0 * length * std::max(std::abs(start.velocity), std::abs(end.velocity));
  if (std::min(start.position, end.position) > reach && start.position > 0.0) {
    return;
  }
  int touching = 0;
  if (start.position <= 0.0 && start.velocity >= 0.0) {
    start.position = 0.0;
    touching = 1;
    if (start.velocity == 0.0) {
      start.acceleration = std::max(start.acceleration, 0.0);  // just released: zero but for round-off
      touching = 2;
    }
  }
  if (const auto theta = first_closing(StepPolynomial{start, end, length}.bernstein(), touching)) {
    candidates_.push_back({.run = &run, .node = node, .time = start_.time + *theta * length, .slope = 0.0});
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
  const double side = candidate.run->side;
  if (contact_->resting(node)) {
    return candidate.slope > 0.0 ? time - side * end_.stretch[node] / candidate.slope : candidate.time;
  }
  const ReadArray end{state_};
  const double gap = side * (end.values()[node] - candidate.run->height(node));
  const double speed = side * end.values()[count_ + node];
  return speed < 0.0 ? time - gap / speed : candidate.time;
}

/// Moves the end of the step to the first event; returns its time.
double LocatedSteps::hit(double event_time, double step_end) {
  const double window = kInstantWindow * (step_end - start_.time);
  double target = event_time;
  double reached = start_.time;
  for (int correction = 0; correction < kMostCorrections; ++correction) {
    if (target - start_.time <= time_resolution(start_.time)) {
      return_to_start();
      end_ = start_;
      if (contact_->counts().resting > 0) {
        end_rate_ = start_rate_;
      }
      return start_.time;
    }
    reached = repeat_step(target);
    double next = kNever;
    for (const Candidate& candidate : candidates_) {
      if (candidate.time <= event_time + window) {
        next = std::min(
            next, std::clamp(corrected_time(candidate, reached), candidate.time - window, candidate.time + window));
      }
    }
    MPI_Allreduce(MPI_IN_PLACE, &next, 1, MPI_DOUBLE, MPI_MIN, equations_->beam().comm());
    target = std::clamp(next, start_.time, step_end);
    if (std::abs(target - reached) <= time_resolution(reached)) {
      break;
    }
  }
  return reached;
}

double LocatedSteps::line_gap(const ContactRun& run, std::size_t node, double theta) const {
  double line = 0.0;
  if (contact_->resting(node)) {
    const double length = end_.time - start_.time;
    line = start_values_[node] + bernstein_value(cubic_bernstein(start_.stretch[node], start_rate_[node],
                                                                 end_.stretch[node], end_rate_[node], length),
                                                 theta);
  } else {
    const StepPolynomial motion = polynomial(node);
    line = motion.position(theta) + motion.acceleration(theta) / wf2_;
  }
  return run.side * (line - amplitude_offset(node, theta) - run.height(node));
}

/// Impulses of the forces that held the line in the step, by Simpson's rule: one more line solve.
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
  equations_->evaluate(start_.time + 0.5 * length, middle, halfway);
  for (const std::size_t i : contact.mine()) {
    const LinePoint& point = contact.points()[i];
    contact_->press(
        point.support,
        point.side * length / 6.0 * (start_.contact_force[i] + 4.0 * halfway.contact_force[i] + end_.contact_force[i]));
    const std::size_t node = contact.local(i);
    if (std::max({start_.contact_force[i], halfway.contact_force[i], end_.contact_force[i]}) > 0.0) {
      contact_->touch(node, start_.time, end_.time);
    }
    contact_->line_at(point.side * (end_values_[node] + end_.stretch[node] - point.height), node, end_.time);
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
  for (const ContactRun& run : contact_->runs()) {
    for (std::size_t node = run.first; node < run.last; ++node) {
      const double first =
          run.side * (start_values_[node] + start_.stretch[node] - amplitude_offset(node, 0.0) - run.height(node));
      const double last =
          run.side * (end_values_[node] + end_.stretch[node] - amplitude_offset(node, 1.0) - run.height(node));
      contact_->line_at(last, node, end_.time);
      // The minimum may lie inside the step: look there when the ends are close enough to the smallest gap so far.
      if (length > 0.0 && contact_->smallest(std::min(first, last) - std::abs(last - first))) {
        for (const double theta : {0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875}) {
          contact_->line_at(line_gap(run, node, theta), node, start_.time + theta * length);
        }
      }
      if (length > 0.0 && contact_->resting_on(node, run)) {
        const double stretch = 0.5 * length * (start_.stretch[node] + end_.stretch[node]) +
                               length * length / 12.0 * (start_rate_[node] - end_rate_[node]);
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
  for (std::size_t i = 0; i < count_; ++i) {
    zero += 0.0 * (end_values_[i] + end_values_[count_ + i] + end_.stretch[i]);
  }
  const bool finite = zero == 0.0;
  double event_time = finite ? survey(length) : kNever;
  std::array<double, 2> earliest{event_time, finite ? 1.0 : 0.0};
  MPI_Allreduce(MPI_IN_PLACE, earliest.data(), 2, MPI_DOUBLE, MPI_MIN, equations_->beam().comm());
  event_time = earliest[0];
  if (earliest[1] == 0.0) {
    throw SolveError{
        "the motion is no longer finite after t = " + std::to_string(start_.time) +
        " s; the time step is too long for -filter_frequency (see -ts_dt, -ts_adapt_type) or a load is not finite"};
  }
  event_ = event_time <= time;
  if (event_) {
    time = hit(event_time, time);
    next_step_ = length;  // what the error control had accepted before the event cut the step
  }
  track_contact();
  if (equations_->line_contact() != nullptr) {
    track_line_contact();
  }
  return time;
}

void LocatedSteps::apply_events() {
  if (!event_) {
    return;
  }
  const double time = end_.time;
  std::vector<std::int32_t> due(count_, 0);
  for (const Candidate& candidate : candidates_) {
    if (corrected_time(candidate, time) <= time + 2.0 * time_resolution(time)) {
      due[candidate.node] = candidate.run->support + 1;
    }
  }
  const WriteArray state{state_};
  contact_->resolve(time, due, wf2_, {state.values(), count_}, {state.values() + count_, count_}, end_.stretch);
}

void LocatedSteps::start(const LineState& line) {
  end_ = line;
  begin_step();
}

void LocatedSteps::begin_step() {
  start_ = end_;
  UDAR_CALL(TSGetTime(stepper_, &start_.time));
  start_rate_valid_ = false;
  UDAR_CALL(VecCopy(state_, start_state_));
  start_values_ = ReadArray{start_state_}.values();  // PETSc's own vectors stay where they are
  end_values_ = ReadArray{state_}.values();
  UDAR_CALL(TSRestartStep(stepper_));
}

void LocatedSteps::masses(double time, std::span<double> position, std::span<double> velocity,
                          std::span<std::uint8_t> resting) const {
  const double length = end_.time - start_.time;
  const double theta = length > 0.0 ? std::clamp((time - start_.time) / length, 0.0, 1.0) : 1.0;
  for (std::size_t i = 0; i < count_; ++i) {
    resting[i] = contact_->resting(i) ? 1 : 0;
    if (length > 0.0 && resting[i] == 0) {
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
  if (contact_->resting(node)) {
    const double end = (1.0 - theta) * start_.stretch[node] + theta * end_.stretch[node];
    return elapsed * (start_values_[node] + 0.5 * (start_.stretch[node] + end));
  }
  const StepPolynomial motion = polynomial(node);
  return integral(motion, theta, length) + (motion.velocity(theta) - motion.velocity(0.0)) / wf2_;
}

/// In a mode wf^2 times the amplitude is f - w^2 q: the integrals of the loads, linear in a step, and of the masses.
std::vector<double> LocatedSteps::amplitude_integrals(double until) const {
  const FilteredLine& line = equations_->line();
  std::vector<double> integrals(line.corrected_modes().size());
  if (integrals.empty() || !(until > start_.time)) {
    return integrals;
  }
  const double length = end_.time - start_.time;
  const double elapsed = std::min(until - start_.time, length);
  std::vector<double> work;
  std::vector<double> given(count_);  // integral of F
  for (const double end : {0.0, 1.0}) {
    const std::span<const double> force = equations_->loads().force(start_.time + end * elapsed, work);
    for (std::size_t i = 0; i < force.size(); ++i) {
      given[i] += 0.5 * elapsed * force[i];
    }
  }
  for (std::size_t i = 0; i < count_; ++i) {
    const double place =
        contact_->resting(i) ? start_values_[i] * elapsed : integral(polynomial(i), elapsed / length, length);
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
  if (equations_->line_contact() != nullptr) {
    save_forces(*equations_->line_contact(), state);
  }
  state.scalars["repeated_steps"] = static_cast<double>(repeated_steps_);
  state.scalars["rhs_evaluations"] = static_cast<double>(evaluations_);
}

void LocatedSteps::restore(const MotionState& state) {
  repeated_steps_ = static_cast<PetscInt>(state.scalar("repeated_steps"));
  evaluations_ = static_cast<PetscInt>(state.scalar("rhs_evaluations"));
  LineState line = saved_line(state, count_);
  if (equations_->line_contact() != nullptr) {
    restore_forces(*equations_->line_contact(), state, line);
  }
  start(line);
}

}  // namespace udar
