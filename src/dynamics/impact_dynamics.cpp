#include "udar/dynamics/impact_dynamics.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <sstream>
#include <string_view>

#include "udar/contact/impact_law.hpp"
#include "udar/petsc/compat.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/session.hpp"

namespace udar {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

// An instant is met when the next correction moves it by less than this many units in the last place.
constexpr double kInstantUnits = 4.0;
// The dense output places an instant within this share of the step; later corrections stay inside.
constexpr double kInstantWindow = 1e-2;
// Newton's method on the exact step converges quadratically; more corrections mean a grazing contact, met well enough.
constexpr int kMostCorrections = 12;
// Absolute tolerance of the step control, in units of rtol and the scale of the motion: keeps the energy of e = 1 runs
// to 10 rtol per 20 impacts (tests/verification).
constexpr double kAbsoluteShare = 0.05;
// Masses within this share of the hop tolerance touch together.
constexpr double kTogether = 1e-2;
// An energy balance that is off by half of the largest energy seen belongs to an unstable integration.
constexpr double kUnstable = 0.5;
// More events than this without progress in time would never end.
constexpr PetscInt kMostEventsAtOnce = 10000;

/// How far two times may differ and still be the same instant [s].
double time_resolution(double time) { return kInstantUnits * kEpsilon * std::abs(time); }

/// Integral over [0, theta] of the polynomial, times the step length; Gauss-Legendre, exact to degree 5.
double integral(const StepPolynomial& polynomial, double theta, double length) {
  const double offset = 0.5 * theta * std::sqrt(0.6);
  const double middle = 0.5 * theta;
  return length * theta / 18.0 *
         (5.0 * polynomial.position(middle - offset) + 8.0 * polynomial.position(middle) +
          5.0 * polynomial.position(middle + offset));
}

/// count times interval; 3 times 0.1 is 0.3, not the product of the rounded 0.1.
double multiple(PetscInt count, double interval) {
  const double per_unit = std::round(1.0 / interval);
  const bool divides = per_unit > 0.0 && 1.0 / per_unit == interval;
  return divides ? static_cast<double>(count) / per_unit : static_cast<double>(count) * interval;
}

/// Value of a cubic in Bernstein form.
double bernstein_value(const std::array<double, 4>& c, double theta) {
  const double s = 1.0 - theta;
  return s * s * (s * c[0] + 3.0 * theta * c[1]) + theta * theta * (3.0 * s * c[2] + theta * c[3]);
}

/// Local values of a Vec for reading.
class ReadAccess {
 public:
  explicit ReadAccess(Vec vector) : vector_{vector} { UDAR_CALL(VecGetArrayRead(vector_, &values_)); }
  ReadAccess(const ReadAccess&) = delete;
  ReadAccess& operator=(const ReadAccess&) = delete;
  ~ReadAccess() { VecRestoreArrayRead(vector_, &values_); }
  [[nodiscard]] const double* values() const noexcept { return values_; }

 private:
  Vec vector_;
  const double* values_ = nullptr;
};

/// Local values of a Vec for writing.
class WriteAccess {
 public:
  explicit WriteAccess(Vec vector) : vector_{vector} { UDAR_CALL(VecGetArray(vector_, &values_)); }
  WriteAccess(const WriteAccess&) = delete;
  WriteAccess& operator=(const WriteAccess&) = delete;
  ~WriteAccess() { VecRestoreArray(vector_, &values_); }
  [[nodiscard]] double* values() const noexcept { return values_; }

 private:
  Vec vector_;
  double* values_ = nullptr;
};

}  // namespace

ImpactDynamics::ImpactDynamics(Equations& equations, std::vector<Support> supports, const InitialState& initial,
                               ContactParameters parameters)
    : equations_{&equations},
      supports_{std::move(supports)},
      parameters_{parameters},
      points_{contact_points(equations.beam(), supports_)},
      count_{static_cast<std::size_t>(equations.beam().local_nodes())},
      wf2_{equations.line().filter_frequency() * equations.line().filter_frequency()} {
  const BeamChain& beam = equations_->beam();
  resting_.assign(count_, 0);
  impulse_.assign(supports_.size(), 0.0);
  line_gap_.gap = kNever;

  const MassState masses = initial_masses(beam, initial);
  std::string overlap;
  for (const ContactPoint& point : points_) {
    const auto node = static_cast<std::size_t>(point.local_node);
    const double gap = point.side * (masses.position[node] - point.height);
    if (gap < -kTogether * parameters_.hop_tolerance && overlap.empty()) {
      const bool floor = std::isinf(supports_[static_cast<std::size_t>(point.support)].width);
      std::ostringstream message;
      message << "option " << (floor ? "-floor_height" : "-support_height") << ": " << point.height
              << " is not allowed, " << (floor ? "the floor" : "support " + std::to_string(point.support))
              << " overlaps the beam at the start, by " << -gap
              << " m at x = " << beam.position(beam.begin() + point.local_node)
              << " m; expected a height on its own side of the beam (-initial_height) [m]";
      overlap = message.str();
    }
  }
  throw_together<InputError>(beam.comm(), overlap);

  const auto size = static_cast<PetscInt>(2 * count_);
  UDAR_CALL(VecCreateMPI(beam.comm(), size, PETSC_DETERMINE, state_.put()));
  UDAR_CALL(VecDuplicate(state_, start_state_.put()));
  const WriteAccess access{state_};
  std::ranges::copy(masses.position, access.values());
  std::ranges::copy(masses.velocity, access.values() + count_);
  configure_stepper();

  // Absolute tolerances follow from the motion's own scale, so that a zero crossing costs no steps.
  PetscBool atol_given = PETSC_FALSE;
  UDAR_CALL(PetscOptionsHasName(nullptr, nullptr, "-ts_atol", &atol_given));
  if (atol_given == PETSC_FALSE) {
    std::array<double, 3> largest{};  // velocity, offset from the axis, distance to a support
    for (std::size_t i = 0; i < count_; ++i) {
      const double x = beam.position(beam.begin() + static_cast<PetscInt>(i));
      largest[0] = std::max(largest[0], std::abs(masses.velocity[i]));
      largest[1] = std::max(largest[1], std::abs(masses.position[i] - initial.axis(x, beam.length())));
    }
    for (const ContactPoint& point : points_) {
      largest[2] =
          std::max(largest[2], std::abs(masses.position[static_cast<std::size_t>(point.local_node)] - point.height));
    }
    MPI_Allreduce(MPI_IN_PLACE, largest.data(), static_cast<int>(largest.size()), MPI_DOUBLE, MPI_MAX, beam.comm());
    const double wf = equations_->line().filter_frequency();
    const double fall = std::sqrt(2.0 * std::abs(equations_->loads().gravity()) * largest[2]);
    const double sag = std::abs(equations_->loads().gravity()) / wf2_;
    double velocity = std::max({largest[0], fall, wf * largest[1], wf * sag});
    velocity = velocity > 0.0 ? velocity : 1.0;
    const double length = std::max({largest[1], largest[2], velocity / wf});
    double rtol = 0.0;
    UDAR_CALL(TSGetTolerances(stepper_, nullptr, nullptr, &rtol, nullptr));
    petsc::Vector atol;
    UDAR_CALL(VecDuplicate(state_, atol.put()));
    {
      const WriteAccess tolerance{atol};
      std::fill_n(tolerance.values(), count_, kAbsoluteShare * rtol * length);
      std::fill_n(tolerance.values() + count_, count_, kAbsoluteShare * rtol * velocity);
    }
    UDAR_CALL(TSSetTolerances(stepper_, PETSC_DEFAULT, atol, PETSC_DEFAULT, nullptr));
  }
}

void ImpactDynamics::configure_stepper() {
  UDAR_CALL(TSCreate(equations_->beam().comm(), stepper_.put()));
  UDAR_CALL(TSSetProblemType(stepper_, TS_NONLINEAR));
  UDAR_CALL(TSSetType(stepper_, TSRK));
  UDAR_CALL(TSRKSetType(stepper_, TSRK5DP));
  UDAR_CALL(TSSetApplicationContext(stepper_, this));
  UDAR_CALL(TSSetRHSFunction(stepper_, nullptr, rhs_callback, this));
  UDAR_CALL(TSSetPostStep(stepper_, post_step_callback));
  UDAR_CALL(TSSetMaxSteps(stepper_, std::numeric_limits<PetscInt>::max()));
  UDAR_CALL(TSSetExactFinalTime(stepper_, TS_EXACTFINALTIME_MATCHSTEP));
  UDAR_CALL(TSSetMaxTime(stepper_, 1.0));
  UDAR_CALL(TSSetTimeStep(stepper_, 0.1 / equations_->line().filter_frequency()));
  UDAR_CALL(TSSetTolerances(stepper_, 1e-8, nullptr, 1e-8, nullptr));
  UDAR_CALL(TSSetErrorIfStepFails(stepper_, PETSC_FALSE));
  // 5dp is stable on the imaginary axis up to wf h = 1. In free flight nothing tells the error control so, and longer
  // steps would blow up round-off to the tolerance: symmetry would be lost there.
  TSAdapt adapt = nullptr;
  UDAR_CALL(TSGetAdapt(stepper_, &adapt));
  petsc::use_largest_error(adapt);
  UDAR_CALL(TSAdaptSetStepLimits(adapt, PETSC_DEFAULT, 1.0 / equations_->line().filter_frequency()));
  UDAR_CALL(TSSetFromOptions(stepper_));

  TSType type = nullptr;
  UDAR_CALL(TSGetType(stepper_, &type));
  const std::string_view name{type};
  if (name != TSRK && name != TSEULER && name != TSSSP) {
    throw InputError{
        "option -ts_type: '" + std::string{name} +
        "' is not allowed, expected one of rk, euler, ssp; the filtered motion is an explicit system Y' = f(t, Y) "
        "without Jacobian or splitting, which this integrator would need"};
  }
  first_stage_at_start_ = name == TSRK || name == TSEULER;
  if (name == TSRK) {
    PetscBool same_as_last = PETSC_FALSE;
    UDAR_CALL(TSRKGetTableau(stepper_, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, &same_as_last));
    last_stage_at_end_ = same_as_last == PETSC_TRUE;
  }
  UDAR_CALL(TSSetSolution(stepper_, state_));
  UDAR_CALL(TSGetMaxTime(stepper_, &end_time_));
  if (!(end_time_ > 0.0) || !std::isfinite(end_time_)) {
    throw InputError{"option -ts_max_time: " + std::to_string(end_time_) +
                     " is not allowed, expected a number > 0 [s]"};
  }
}

void ImpactDynamics::add_observer(Observer& observer) {
  observers_.push_back(&observer);
  due_.push_back({.observer = &observer, .next = 0});
}

PetscErrorCode ImpactDynamics::rhs_callback(TS /*stepper*/, PetscReal time, Vec state, Vec rate, void* context) {
  PetscFunctionBeginUser;
  auto* self = static_cast<ImpactDynamics*>(context);
  PetscCall(petsc::guarded([&] { self->right_hand_side(time, state, rate); }));
  PetscFunctionReturn(0);
}

PetscErrorCode ImpactDynamics::post_step_callback(TS stepper) {
  PetscFunctionBeginUser;
  void* context = nullptr;
  PetscCall(TSGetApplicationContext(stepper, static_cast<void*>(&context)));
  auto* self = static_cast<ImpactDynamics*>(context);
  PetscCall(petsc::guarded([&] { self->after_step(); }));
  PetscFunctionReturn(0);
}

void ImpactDynamics::right_hand_side(double time, Vec state, Vec rate) {
  ++counts_.rhs_evaluations;
  const ReadAccess now{state};
  const LineState* line = &start_;
  if (!first_stage_at_start_ || time != start_.time) {
    equations_->evaluate(time, {now.values(), count_}, last_);
    line = &last_;
  }
  const WriteAccess change{rate};
  for (std::size_t i = 0; i < count_; ++i) {
    const bool moves = resting_[i] == 0;
    change.values()[i] = moves ? now.values()[count_ + i] : 0.0;
    change.values()[count_ + i] = moves ? wf2_ * line->stretch[i] : 0.0;
  }
}

Kinematics ImpactDynamics::kinematics(std::size_t node, const double* state, const LineState& line) const {
  return {.position = state[node],
          .velocity = state[count_ + node],
          .acceleration = resting_[node] == 0 ? wf2_ * line.stretch[node] : 0.0};
}

StepPolynomial ImpactDynamics::polynomial(std::size_t node) const {
  return {kinematics(node, start_values_, start_), kinematics(node, end_values_, end_), end_.time - start_.time};
}

void ImpactDynamics::load_end(double time) {
  const ReadAccess end{state_};
  if (last_stage_at_end_ && last_.time == time) {
    std::swap(end_, last_);
  } else {
    equations_->evaluate(time, {end.values(), count_}, end_);
  }
  if (counts_.resting > 0) {
    if (!start_rate_valid_) {
      start_rate_.resize(count_);
      const ReadAccess start{start_state_};
      equations_->evaluate_rate(start_.time, {start.values() + count_, count_}, start_rate_);
      start_rate_valid_ = true;
    }
    end_rate_.resize(count_);
    equations_->evaluate_rate(time, {end.values() + count_, count_}, end_rate_);
  }
}

/// Fills `candidates_` with every event on the dense output of the step and returns the earliest time on any rank.
double ImpactDynamics::survey(double length) {
  candidates_.clear();
  for (std::size_t index = 0; index < points_.size(); ++index) {
    const ContactPoint& point = points_[index];
    const auto node = static_cast<std::size_t>(point.local_node);
    if (point.resting) {
      const auto pressing = cubic_bernstein(-point.side * start_.stretch[node], -point.side * start_rate_[node],
                                            -point.side * end_.stretch[node], -point.side * end_rate_[node], length);
      if (const auto theta = first_closing(pressing, 0)) {
        const double s = 1.0 - *theta;
        const double slope = -3.0 / length *
                             (s * s * (pressing[1] - pressing[0]) + 2.0 * s * *theta * (pressing[2] - pressing[1]) +
                              *theta * *theta * (pressing[3] - pressing[2]));
        candidates_.push_back({.point = index, .time = start_.time + *theta * length, .slope = slope});
      }
      continue;
    }
    if (resting_[node] != 0) {
      continue;  // at rest on another support
    }
    const auto seen = [&point](Kinematics motion) {
      return Kinematics{.position = point.side * (motion.position - point.height),
                        .velocity = point.side * motion.velocity,
                        .acceleration = point.side * motion.acceleration};
    };
    Kinematics start = seen(kinematics(node, start_values_, start_));
    const Kinematics end = seen(kinematics(node, end_values_, end_));
    // Inside one step, which resolves the motion, a gap changes by less than twice the larger end speed times the step.
    const double reach = 2.0 * length * std::max(std::abs(start.velocity), std::abs(end.velocity));
    if (std::min(start.position, end.position) > reach && start.position > 0.0) {
      continue;
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
      candidates_.push_back({.point = index, .time = start_.time + *theta * length, .slope = 0.0});
    }
  }
  const auto first = std::ranges::min_element(candidates_, {}, &Candidate::time);
  return first != candidates_.end() ? first->time : kNever;
}

void ImpactDynamics::return_to_start() {
  UDAR_CALL(VecCopy(start_state_, state_));
  UDAR_CALL(TSSetTime(stepper_, start_.time));
  UDAR_CALL(TSSetConvergedReason(stepper_, TS_CONVERGED_ITERATING));
  UDAR_CALL(TSRestartStep(stepper_));
}

/// Takes the step again from its start, now ending at `time`; returns where it ended, `time` but for its last bit.
double ImpactDynamics::repeat_step(double time) {
  return_to_start();
  TSAdapt adapt = nullptr;
  UDAR_CALL(TSGetAdapt(stepper_, &adapt));
  UDAR_CALL(TSAdaptSetAlwaysAccept(adapt, PETSC_TRUE));
  UDAR_CALL(TSSetTimeStep(stepper_, time - start_.time));
  UDAR_CALL(TSStep(stepper_));
  UDAR_CALL(TSAdaptSetAlwaysAccept(adapt, PETSC_FALSE));
  UDAR_CALL(TSSetConvergedReason(stepper_, TS_CONVERGED_ITERATING));
  ++counts_.repeated_steps;
  double reached = 0.0;
  UDAR_CALL(TSGetTime(stepper_, &reached));
  load_end(reached);
  return reached;
}

/// The instant of a candidate as the state at `time` corrects it.
double ImpactDynamics::corrected_time(const Candidate& candidate, double time) const {
  const ContactPoint& point = points_[candidate.point];
  const auto node = static_cast<std::size_t>(point.local_node);
  if (point.resting) {
    return candidate.slope > 0.0 ? time - point.side * end_.stretch[node] / candidate.slope : candidate.time;
  }
  const ReadAccess end{state_};
  const double gap = point.side * (end.values()[node] - point.height);
  const double speed = point.side * end.values()[count_ + node];
  return speed < 0.0 ? time - gap / speed : candidate.time;
}

/// Moves the end of the step to the first event; returns its time.
double ImpactDynamics::hit(double event_time, double step_end) {
  const double window = kInstantWindow * (step_end - start_.time);
  double target = event_time;
  double reached = start_.time;
  for (int correction = 0; correction < kMostCorrections; ++correction) {
    if (target - start_.time <= time_resolution(start_.time)) {
      return_to_start();
      end_ = start_;
      if (counts_.resting > 0) {
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

/// Applies the contact law to every mass that is on its support at `time`, and releases those that lift.
void ImpactDynamics::resolve(double time, double resolution) {
  const BeamChain& beam = equations_->beam();
  impacts_.clear();
  rests_.clear();
  std::vector<std::uint8_t> due(points_.size(), 0);
  for (const Candidate& candidate : candidates_) {
    due[candidate.point] = corrected_time(candidate, time) <= time + resolution ? 1 : 0;
  }
  double lost = 0.0;
  {
    const WriteAccess state{state_};
    for (std::size_t index = 0; index < points_.size(); ++index) {
      ContactPoint& point = points_[index];
      const auto node = static_cast<std::size_t>(point.local_node);
      const PetscInt global = beam.begin() + point.local_node;
      double& position = state.values()[node];
      double& velocity = state.values()[count_ + node];
      const auto rest_record = [&](bool release) {
        return RestRecord{
            .time = time, .node = global, .x = beam.position(global), .support = point.support, .release = release};
      };
      if (point.resting) {
        if (due[index] != 0) {
          point.resting = false;
          resting_[node] = 0;
          end_.stretch[node] = 0.0;
          rests_.push_back(rest_record(true));
        }
        continue;
      }
      const double gap = point.side * (position - point.height);
      const double together = std::max(kTogether * parameters_.hop_tolerance,
                                       8.0 * kEpsilon * std::max(std::abs(position), std::abs(point.height)));
      if (resting_[node] != 0 || (gap > together && due[index] == 0)) {
        continue;
      }
      const TouchingMass mass{.velocity = point.side * velocity,
                              .acceleration = point.side * wf2_ * end_.stretch[node],
                              .mass = equations_->line().mass()[node]};
      const ContactOutcome outcome = resolve_contact(mass, point.restitution, parameters_.hop_tolerance);
      if (!outcome.impact && !outcome.rests) {
        continue;
      }
      if (outcome.impact) {
        const double after = point.side * outcome.velocity;
        const double impulse = mass.mass * (after - velocity);
        impacts_.push_back({.time = time,
                            .node = global,
                            .x = beam.position(global),
                            .support = point.support,
                            .velocity_before = velocity,
                            .velocity_after = after,
                            .impulse = impulse,
                            .energy_loss = outcome.energy_loss});
        impulse_[static_cast<std::size_t>(point.support)] += impulse;
      }
      lost += outcome.energy_loss;
      position = point.height;
      velocity = point.side * outcome.velocity;
      if (outcome.rests) {
        point.resting = true;
        resting_[node] = 1;
        rests_.push_back(rest_record(false));
      }
    }
  }

  const auto releases = std::ranges::count_if(rests_, &RestRecord::release);
  std::array<double, 4> sums{static_cast<double>(impacts_.size()),
                             static_cast<double>(rests_.size()) - static_cast<double>(releases),
                             static_cast<double>(releases), lost};
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM, beam.comm());
  counts_.impacts += static_cast<PetscInt>(sums[0]);
  counts_.rests += static_cast<PetscInt>(sums[1]);
  counts_.releases += static_cast<PetscInt>(sums[2]);
  counts_.resting += static_cast<PetscInt>(sums[1] - sums[2]);
  ledger_.lost_in_impacts += sums[3];
  if (sums[0] + sums[1] > 0.0 && counts_.first_contact_time < 0.0) {
    counts_.first_contact_time = time;
  }
  if (sums[0] + sums[1] + sums[2] > 0.0) {
    counts_.last_contact_time = time;
    for (Observer* observer : observers_) {
      const petsc::LogScope output{petsc::log_events().output};
      observer->events(impacts_, rests_);
    }
  }
}

double ImpactDynamics::line_gap(const ContactPoint& point, double theta) const {
  const auto node = static_cast<std::size_t>(point.local_node);
  double line = 0.0;
  if (resting_[node] != 0) {
    const double length = end_.time - start_.time;
    line = start_values_[node] + bernstein_value(cubic_bernstein(start_.stretch[node], start_rate_[node],
                                                                 end_.stretch[node], end_rate_[node], length),
                                                 theta);
  } else {
    const StepPolynomial motion = polynomial(node);
    line = motion.position(theta) + motion.acceleration(theta) / wf2_;
  }
  return point.side * (line - point.height);
}

void ImpactDynamics::track_line_gap(double until) {
  const double length = until - start_.time;
  const auto record = [&](const ContactPoint& point, double gap, double time) {
    if (gap < line_gap_.gap) {
      line_gap_ = {
          .gap = gap, .x = equations_->beam().position(equations_->beam().begin() + point.local_node), .time = time};
    }
  };
  for (const ContactPoint& point : points_) {
    const auto node = static_cast<std::size_t>(point.local_node);
    const double first = point.side * (start_values_[node] + start_.stretch[node] - point.height);
    const double last = point.side * (end_values_[node] + end_.stretch[node] - point.height);
    record(point, first, start_.time);
    record(point, last, until);
    // The minimum may lie inside the step: look there when the ends are close enough to the smallest gap so far.
    if (length > 0.0 && std::min(first, last) - std::abs(last - first) < line_gap_.gap) {
      for (const double theta : {0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875}) {
        record(point, line_gap(point, theta), start_.time + theta * length);
      }
    }
  }
}

void ImpactDynamics::track_resting_impulse(double until) {
  const double length = until - start_.time;
  if (counts_.resting == 0 || length <= 0.0) {
    return;
  }
  counts_.last_contact_time = until;
  for (const ContactPoint& point : points_) {
    if (point.resting) {
      const auto node = static_cast<std::size_t>(point.local_node);
      const double stretch = 0.5 * length * (start_.stretch[node] + end_.stretch[node]) +
                             length * length / 12.0 * (start_rate_[node] - end_rate_[node]);
      impulse_[static_cast<std::size_t>(point.support)] -= wf2_ * equations_->line().mass()[node] * stretch;
    }
  }
}

/// Minus the integral of dF/dt' Yc from the start of the step, this rank's share; dF/dt is constant within a step.
double ImpactDynamics::changing_load_work(double until) const {
  const double length = end_.time - start_.time;
  const double elapsed = until - start_.time;
  double work = 0.0;
  if (elapsed <= 0.0) {
    return work;
  }
  const double theta = std::min(elapsed / length, 1.0);
  for (const Loads::LocalLoad& load : equations_->loads().local()) {
    const auto node = static_cast<std::size_t>(load.local_node);
    const double rate = Loads::evaluate(load.table, start_.time).rate;
    double line = 0.0;  // integral of Yc
    if (resting_[node] != 0) {
      const double end = (1.0 - theta) * start_.stretch[node] + theta * end_.stretch[node];
      line = elapsed * (start_values_[node] + 0.5 * (start_.stretch[node] + end));
    } else {
      const StepPolynomial motion = polynomial(node);
      line = integral(motion, theta, length) + (motion.velocity(theta) - motion.velocity(0.0)) / wf2_;
    }
    work -= rate * line;
  }
  return work;
}

void ImpactDynamics::emit_snapshots(double until) {
  const MPI_Comm comm = equations_->beam().comm();
  const auto due_time = [](const Due& due) {
    const double interval = due.observer->interval();
    return interval > 0.0 ? multiple(due.next, interval) : kNever;
  };
  const double length = end_.time - start_.time;
  while (!due_.empty()) {
    const double time = due_time(*std::ranges::min_element(due_, {}, due_time));
    if (!(time <= until + time_resolution(until)) || time > end_time_ + time_resolution(end_time_)) {
      break;
    }
    const petsc::LogScope output{petsc::log_events().output};
    const double theta = length > 0.0 ? std::clamp((time - start_.time) / length, 0.0, 1.0) : 1.0;
    MassState masses;
    masses.position.resize(count_);
    masses.velocity.resize(count_);
    for (std::size_t i = 0; i < count_; ++i) {
      if (length > 0.0 && resting_[i] == 0) {
        const StepPolynomial motion = polynomial(i);
        masses.position[i] = motion.position(theta);
        masses.velocity[i] = motion.velocity(theta);
      } else {
        masses.position[i] = end_values_[i];
        masses.velocity[i] = end_values_[count_ + i];
      }
    }
    equations_->evaluate(time, masses.position, scratch_, true);
    EnergyLedger now = equations_->energy(scratch_, masses.position, masses.velocity);
    now.lost_in_impacts = ledger_.lost_in_impacts;
    if (equations_->loads().time_dependent()) {
      now.load_work = load_work_ + changing_load_work(time);
      MPI_Allreduce(MPI_IN_PLACE, &now.load_work, 1, MPI_DOUBLE, MPI_SUM, comm);
    }
    largest_kinetic_ = std::max(largest_kinetic_, now.kinetic);
    now.initial = ledger_.initial;
    now.scale = std::max(std::abs(now.initial), largest_kinetic_);
    ledger_ = now;
    if (std::abs(now.drift()) > kUnstable) {
      throw SolveError{"the integration is unstable: the energy balance is off by " + std::to_string(now.drift()) +
                       " of the energy at t = " + std::to_string(time) +
                       " s; steps must stay below about 1 / -filter_frequency (see -ts_dt, -ts_adapt_type, -ts_rtol)"};
    }

    std::vector<double> line(count_);
    for (std::size_t i = 0; i < count_; ++i) {
      line[i] = masses.position[i] + scratch_.stretch[i];
    }
    const Snapshot snapshot{.time = time,
                            .mass_position = masses.position,
                            .mass_velocity = masses.velocity,
                            .line_position = line,
                            .moment = scratch_.moment,
                            .resting = resting_,
                            .energy = ledger_};
    for (Due& due : due_) {
      if (due_time(due) <= time + time_resolution(time)) {
        ++due.next;
        due.observer->snapshot(snapshot);
      }
    }
  }
}

void ImpactDynamics::start() {
  started_ = true;
  if (!restored_) {
    start_.time = 0.0;
    UDAR_CALL(TSGetTime(stepper_, &start_.time));
    end_.time = start_.time;
    const ReadAccess state{state_};
    equations_->evaluate(start_.time, {state.values(), count_}, end_, true);
    EnergyLedger first = equations_->energy(end_, {state.values(), count_}, {state.values() + count_, count_});
    ledger_ = first;
    ledger_.initial = first.total();
    start_ = end_;
    start_values_ = state.values();
    end_values_ = state.values();
    emit_snapshots(start_.time);
    track_line_gap(start_.time);
    UDAR_CALL(TSGetTimeStep(stepper_, &wanted_step_));
    resolve(start_.time, 0.0);
  } else {
    for (Due& due : due_) {
      const double interval = due.observer->interval();
      if (interval > 0.0) {  // snapshots up to the restart time were taken by the run that wrote it
        due.next = static_cast<PetscInt>(std::floor((start_.time + time_resolution(start_.time)) / interval)) + 1;
      }
    }
  }
  finish_step(start_.time, wanted_step_);
}

void ImpactDynamics::finish_step(double time, double next_step) {
  wanted_step_ = next_step;
  const auto& kinks = equations_->loads().kinks();
  const auto kink = std::ranges::upper_bound(kinks, time + time_resolution(time));
  double step = std::min(next_step, end_time_ - time);
  step_was_cut_ = false;
  if (kink != kinks.end() && time + step > *kink) {
    step = *kink - time;
    step_was_cut_ = true;
  }
  if (step > 0.0) {
    UDAR_CALL(TSSetTimeStep(stepper_, step));
  }
  start_ = end_;
  start_.time = time;
  start_rate_valid_ = false;
  UDAR_CALL(VecCopy(state_, start_state_));
  UDAR_CALL(TSRestartStep(stepper_));
}

void ImpactDynamics::after_step() {
  const petsc::LogScope contact{petsc::log_events().contact};
  const MPI_Comm comm = equations_->beam().comm();
  double time = 0.0;
  double next_step = 0.0;
  UDAR_CALL(TSGetTime(stepper_, &time));
  UDAR_CALL(TSGetTimeStep(stepper_, &next_step));
  const double length = time - start_.time;
  load_end(time);

  double event_time = kNever;
  bool finite = true;
  {
    const ReadAccess start{start_state_};
    const ReadAccess end{state_};
    start_values_ = start.values();
    end_values_ = end.values();
    double zero = 0.0;  // stays zero unless some value is not finite
    for (std::size_t i = 0; i < count_; ++i) {
      zero += 0.0 * (end_values_[i] + end_values_[count_ + i] + end_.stretch[i]);
    }
    finite = zero == 0.0;
    event_time = finite ? survey(length) : kNever;
  }
  std::array<double, 3> earliest{event_time, finite ? 1.0 : 0.0, stop_requested_ && stop_requested_() ? 0.0 : 1.0};
  MPI_Allreduce(MPI_IN_PLACE, earliest.data(), static_cast<int>(earliest.size()), MPI_DOUBLE, MPI_MIN, comm);
  event_time = earliest[0];
  if (earliest[1] == 0.0) {
    return_to_start();
    throw SolveError{
        "the motion is no longer finite after t = " + std::to_string(start_.time) +
        " s; the time step is too long for -filter_frequency (see -ts_dt, -ts_adapt_type) or a load is not finite"};
  }

  const bool event = event_time <= time;
  if (event) {
    time = hit(event_time, time);
    next_step = length;  // what the error control had accepted before the event cut the step
  }
  if (step_was_cut_) {
    next_step = std::max(next_step, wanted_step_);
  }
  {
    const ReadAccess start{start_state_};
    const ReadAccess end{state_};
    start_values_ = start.values();
    end_values_ = end.values();
    emit_snapshots(time);
    track_line_gap(time);
    track_resting_impulse(time);
    if (equations_->loads().time_dependent()) {
      load_work_ += changing_load_work(time);
    }
  }
  counts_.steps += time > start_.time ? 1 : 0;
  if (event) {
    events_at_once_ = time - start_.time <= time_resolution(time) ? events_at_once_ + 1 : 0;
    if (events_at_once_ > kMostEventsAtOnce) {
      throw SolveError{"contact does not settle at t = " + std::to_string(time) + " s after " +
                       std::to_string(kMostEventsAtOnce) +
                       " events at one instant; raise -contact_tolerance or lower -ts_rtol"};
    }
    resolve(time, 2.0 * time_resolution(time));
  }
  UDAR_CALL(TSGetStepRejections(stepper_, &counts_.rejected_steps));
  finish_step(time, next_step);
  if (earliest[2] == 0.0) {
    UDAR_CALL(TSSetConvergedReason(stepper_, TS_CONVERGED_USER));
  } else if (end_time_ - time <= time_resolution(end_time_)) {
    UDAR_CALL(TSSetConvergedReason(stepper_, TS_CONVERGED_TIME));
  }
  const Progress progress{.time = time,
                          .end_time = end_time_,
                          .steps = counts_.steps,
                          .impacts = counts_.impacts,
                          .resting = counts_.resting,
                          .energy_drift = ledger_.drift()};
  for (Observer* observer : observers_) {
    const petsc::LogScope output{petsc::log_events().output};
    observer->step(progress);
  }
}

void ImpactDynamics::solve() {
  if (!started_) {
    start();
  }
  completed_ = start_.time >= end_time_;
  if (!completed_) {
    UDAR_CALL(TSSolve(stepper_, nullptr));
    TSConvergedReason reason = TS_CONVERGED_ITERATING;
    UDAR_CALL(TSGetConvergedReason(stepper_, &reason));
    if (reason < 0) {
      throw SolveError{std::string{"the time integration failed: "} + TSConvergedReasons[reason] +
                       " at t = " + std::to_string(start_.time) + " s (see -ts_monitor, -ts_adapt_monitor)"};
    }
    completed_ = reason == TS_CONVERGED_TIME;
  }
  for (Observer* observer : observers_) {
    const petsc::LogScope output{petsc::log_events().output};
    observer->finish();
  }
}

MassState ImpactDynamics::masses() const {
  const ReadAccess state{start_state_};
  return {.position = {state.values(), state.values() + count_},
          .velocity = {state.values() + count_, state.values() + 2 * count_}};
}

std::vector<double> ImpactDynamics::support_impulses() const {
  std::vector<double> sums = impulse_;
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM,
                equations_->beam().comm());
  return sums;
}

LineGap ImpactDynamics::smallest_line_gap() const {
  const MPI_Comm comm = equations_->beam().comm();
  struct {
    double gap;
    int rank;
  } smallest{.gap = line_gap_.gap, .rank = 0};
  MPI_Comm_rank(comm, &smallest.rank);
  MPI_Allreduce(MPI_IN_PLACE, &smallest, 1, MPI_DOUBLE_INT, MPI_MINLOC, comm);
  std::array<double, 3> place{line_gap_.gap, line_gap_.x, line_gap_.time};
  MPI_Bcast(place.data(), static_cast<int>(place.size()), MPI_DOUBLE, smallest.rank, comm);
  return {.gap = place[0], .x = place[1], .time = place[2]};
}

MotionState ImpactDynamics::save() const {
  MotionState saved;
  const MassState now = masses();
  saved.fields = {{"mass_position", now.position}, {"mass_velocity", now.velocity}, {"stretch", start_.stretch}};
  std::vector<double>& resting_on = saved.fields["resting_on"];  // support index + 1; 0: moving
  resting_on.assign(count_, 0.0);
  for (const ContactPoint& point : points_) {
    if (point.resting) {
      resting_on[static_cast<std::size_t>(point.local_node)] = static_cast<double>(point.support + 1);
    }
  }
  const LineGap gap = smallest_line_gap();
  double work = load_work_;
  MPI_Allreduce(MPI_IN_PLACE, &work, 1, MPI_DOUBLE, MPI_SUM, equations_->beam().comm());
  saved.scalars = {{"time", start_.time},
                   {"wanted_step", wanted_step_},
                   {"steps", static_cast<double>(counts_.steps)},
                   {"repeated_steps", static_cast<double>(counts_.repeated_steps)},
                   {"rhs_evaluations", static_cast<double>(counts_.rhs_evaluations)},
                   {"impacts", static_cast<double>(counts_.impacts)},
                   {"rests", static_cast<double>(counts_.rests)},
                   {"releases", static_cast<double>(counts_.releases)},
                   {"resting", static_cast<double>(counts_.resting)},
                   {"first_contact_time", counts_.first_contact_time},
                   {"last_contact_time", counts_.last_contact_time},
                   {"lost_in_impacts", ledger_.lost_in_impacts},
                   {"initial_energy", ledger_.initial},
                   {"largest_kinetic", largest_kinetic_},
                   {"load_work", work},
                   {"line_gap", gap.gap},
                   {"line_gap_x", gap.x},
                   {"line_gap_time", gap.time}};
  saved.tables["support_impulse"] = support_impulses();
  return saved;
}

void ImpactDynamics::restore(const MotionState& state) {
  const auto field = [&](const char* name) -> const std::vector<double>& {
    const auto found = state.fields.find(name);
    if (found == state.fields.end() || found->second.size() != count_) {
      throw InputError{std::string{"option -restart_file: the field '"} + name + "' is missing or has another size"};
    }
    return found->second;
  };
  const auto scalar = [&](const char* name) {
    const auto found = state.scalars.find(name);
    if (found == state.scalars.end()) {
      throw InputError{std::string{"option -restart_file: the value '"} + name + "' is missing"};
    }
    return found->second;
  };
  const auto count = [&](const char* name) { return static_cast<PetscInt>(scalar(name)); };
  {
    const WriteAccess now{state_};
    std::ranges::copy(field("mass_position"), now.values());
    std::ranges::copy(field("mass_velocity"), now.values() + count_);
  }
  const double time = scalar("time");
  end_ = {.time = time, .stretch = field("stretch"), .moment = {}};
  start_ = end_;
  wanted_step_ = scalar("wanted_step");
  const std::vector<double>& resting_on = field("resting_on");
  for (ContactPoint& point : points_) {
    const auto node = static_cast<std::size_t>(point.local_node);
    point.resting = resting_on[node] == static_cast<double>(point.support + 1);
    resting_[node] = resting_on[node] != 0.0 ? 1 : 0;
  }
  counts_ = {.steps = count("steps"),
             .repeated_steps = count("repeated_steps"),
             .rejected_steps = 0,
             .rhs_evaluations = count("rhs_evaluations"),
             .impacts = count("impacts"),
             .rests = count("rests"),
             .releases = count("releases"),
             .resting = count("resting"),
             .first_contact_time = scalar("first_contact_time"),
             .last_contact_time = scalar("last_contact_time")};
  ledger_.lost_in_impacts = scalar("lost_in_impacts");
  ledger_.initial = scalar("initial_energy");
  largest_kinetic_ = scalar("largest_kinetic");
  int rank = 0;
  MPI_Comm_rank(equations_->beam().comm(), &rank);
  load_work_ = rank == 0 ? scalar("load_work") : 0.0;
  line_gap_ = {.gap = scalar("line_gap"), .x = scalar("line_gap_x"), .time = scalar("line_gap_time")};
  const auto impulses = state.tables.find("support_impulse");
  if (impulses == state.tables.end() || impulses->second.size() != supports_.size()) {
    throw InputError{"option -restart_file: it was written with another number of supports"};
  }
  impulse_.assign(supports_.size(), 0.0);
  if (rank == 0) {
    impulse_ = impulses->second;
  }
  UDAR_CALL(TSSetTime(stepper_, time));
  restored_ = true;
}

}  // namespace udar
