#include "udar/integrators/problem_integrator.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include "udar/integrators/configure.hpp"
#include "udar/petsc/array.hpp"
#include "udar/petsc/composed.hpp"
#include "udar/petsc/error.hpp"

namespace udar {
namespace {

constexpr const char* kComposed = "udar_problem";

}  // namespace

void compose_problem(TS stepper, const ImpactProblem& problem) {
  petsc::compose(reinterpret_cast<PetscObject>(stepper), kComposed, problem);
}

Integrator* integrator_inside(TS stepper) { return dynamic_cast<Integrator*>(petsc::attached(stepper)); }

void ProblemIntegrator::set_default_tolerance(TS stepper, double rtol) {
  PetscBool given = PETSC_FALSE;
  UDAR_CALL(PetscOptionsHasName(nullptr, nullptr, "-ts_rtol", &given));
  if (given == PETSC_FALSE) {
    UDAR_CALL(TSSetTolerances(stepper, PETSC_DEFAULT, nullptr, rtol, nullptr));
  }
}

void ProblemIntegrator::set_up(TS stepper) {
  if (ts_ != nullptr) {
    return;
  }
  const auto* problem = petsc::composed<ImpactProblem>(reinterpret_cast<PetscObject>(stepper), kComposed);
  if (problem == nullptr) {
    TSType type = nullptr;
    UDAR_CALL(TSGetType(stepper, &type));
    throw InputError{std::string{"ts type: '"} + type +
                     "' integrates the filtered motion of udar only, and no problem is composed with this TS; choose "
                     "another -ts_type"};
  }
  ts_ = stepper;
  equations_ = problem->equations;
  contact_ = problem->contact;
  contacts_ = problem->contacts;
  kinks_ = problem->kinks;
  scale_ = problem->scale;
  wf_ = equations_->line().filter_frequency();
  highest_ = equations_->frequency_bound();
  tolerance_ = step_tolerance(stepper, scale_);
  count_ = equations_->line().mass().size();
  UDAR_CALL(TSGetSolution(stepper, &state_));
  UDAR_CALL(VecDuplicate(state_, start_state_.put()));
  start_ = petsc::ReadArray{start_state_}.values();  // PETSc's own vectors stay where they are
  prepare();
}

double ProblemIntegrator::enter_step(double longest) {
  double wished = 0.0;
  double last = 0.0;
  UDAR_CALL(TSGetTime(ts_, &begin_));
  UDAR_CALL(TSGetTimeStep(ts_, &wished));
  UDAR_CALL(TSGetMaxTime(ts_, &last));
  UDAR_CALL(VecCopy(state_, start_state_));
  return std::min({wished, last - begin_, longest});
}

void ProblemIntegrator::leave_step(double length, double next) {
  const petsc::WriteArray written{state_};  // tells PETSc
  length_ = length;
  stepped_ = true;
  UDAR_CALL(TSSetTime(ts_, begin_ + length));
  UDAR_CALL(TSSetTimeStep(ts_, next));
}

void ProblemIntegrator::step(TS /*stepper*/) {
  bool done = false;
  try {
    done = advance();
  } catch (...) {
    UDAR_CALL(VecCopy(start_state_, state_));
    throw;
  }
  if (!done) {
    UDAR_CALL(VecCopy(start_state_, state_));
    UDAR_CALL(TSSetConvergedReason(ts_, TS_DIVERGED_STEP_REJECTED));
  }
}

void ProblemIntegrator::begin_step() {
  UDAR_CALL(TSGetTime(ts_, &begin_));
  length_ = 0.0;
  stepped_ = false;
}

double ProblemIntegrator::end_step() {
  double time = 0.0;
  UDAR_CALL(TSGetTime(ts_, &time));
  return time;
}

void ProblemIntegrator::roll_back(TS /*stepper*/) {
  UDAR_CALL(VecCopy(start_state_, state_));
  contact_->undo();
  take_back();
  length_ = 0.0;
  stepped_ = false;
}

void ProblemIntegrator::return_to_start() {
  if (stepped_) {
    roll_back(ts_);
    UDAR_CALL(TSSetTime(ts_, begin_));
  }
}

void ProblemIntegrator::interpolate(TS /*stepper*/, double time, Vec solution) {
  const petsc::WriteArray values{solution};
  std::vector<std::uint8_t> resting(count_);
  masses(time, {values.values(), count_}, {values.values() + count_, count_}, resting);
}

void ProblemIntegrator::masses(double time, std::span<double> position, std::span<double> velocity,
                               std::span<std::uint8_t> resting) const {
  if (stepped_) {
    return within(std::clamp(time - begin_, 0.0, length_), position, velocity, resting);
  }
  const petsc::ReadArray state{state_};
  std::copy_n(state.values(), count_, position.begin());
  std::copy_n(state.values() + count_, count_, velocity.begin());
  for (std::size_t i = 0; i < count_; ++i) {
    resting[i] = contact_->resting(i) ? 1 : 0;
  }
}

PetscInt ProblemIntegrator::steps() const {
  PetscInt steps = 0;
  if (ts_ != nullptr) {
    UDAR_CALL(TSGetStepNumber(ts_, &steps));
  }
  return steps;
}

SolveError ProblemIntegrator::not_finite() const {
  return SolveError{"the motion is no longer finite after t = " + std::to_string(begin_) +
                    " s; a load or the line solve is not finite"};
}

}  // namespace udar
