#include "udar/dynamics/impact_dynamics.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <sstream>
#include <string>
#include <string_view>

#include "udar/filter/bending_fields.hpp"
#include "udar/integrators/located_steps.hpp"
#include "udar/integrators/problem_integrator.hpp"
#include "udar/integrators/ts_chebyshev.hpp"
#include "udar/integrators/ts_impact.hpp"
#include "udar/integrators/ts_moreau.hpp"
#include "udar/petsc/array.hpp"
#include "udar/petsc/compat.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/session.hpp"

namespace udar {
namespace {

using petsc::ReadArray;
using petsc::WriteArray;

constexpr double kNever = std::numeric_limits<double>::infinity();

// An energy balance that is off by half of the largest energy seen belongs to an unstable integration.
constexpr double kUnstable = 0.5;
// Rounding, and what sweeps leave of an error: dampers that give more energy than this share of the largest are wrong.
constexpr double kDamperRounding = 1e-9;
// More events than this without progress in time would never end.
constexpr PetscInt kMostEventsAtOnce = 10000;
// Nor would a run in steps this short, in units of the shortest time in which masses move: the tightest tolerance that
// double precision allows takes steps of 1e-3. One or two beside an event or a kink are normal.
constexpr double kLeastStep = 1e-6;
constexpr PetscInt kMostShortSteps = 1000;
// A mass this deep in a rigid support, beside the motion's length, has fallen through it: integration that deserves the
// name is off by a thousandth at most.
constexpr double kFallenThrough = 0.1;

/// Ends a run between the rows of a step: the way out of PETSc's time loop.
struct StoppedBetweenRows : std::exception {};

/// count times interval; 3 times 0.1 is 0.3, not the product of the rounded 0.1.
double multiple(PetscInt count, double interval) {
  const double per_unit = std::round(1.0 / interval);
  const bool divides = per_unit > 0.0 && 1.0 / per_unit == interval;
  return divides ? static_cast<double>(count) / per_unit : static_cast<double>(count) * interval;
}

/// Nothing but the line touches where masses and line are one.
ContactParameters with_defaults(const Equations& equations, ContactParameters parameters, const MotionScale& scale) {
  if (equations.line().parameters().unfiltered) {
    parameters.surface = ContactSurface::line;
  }
  if (parameters.hop_tolerance == 0.0) {
    parameters.hop_tolerance = kHopShare * scale.length;
  }
  return parameters;
}

/// End of the run [s], which the TS is told later.
double end_of_run() {
  double end = 1.0;
  UDAR_CALL(PetscOptionsGetReal(nullptr, nullptr, "-ts_max_time", &end, nullptr));
  return end;
}

}  // namespace

ImpactDynamics::ImpactDynamics(Equations& equations, std::vector<Support> supports, const InitialState& initial,
                               ContactParameters parameters)
    : equations_{&equations},
      near_{find_contact_sets(equations.beam(), supports)},
      problem_{
          .equations = equations_,
          .contact = &contact_,
          .scale = motion_scale(equations, initial, near_, parameters.surface == ContactSurface::line, end_of_run())},
      contact_{equations.beam(), equations.line().mass(), std::move(supports),
               with_defaults(equations, parameters, problem_.scale)},
      count_{static_cast<std::size_t>(equations.beam().local_nodes())} {
  const BeamChain& beam = equations_->beam();
  const MassState masses = initial_masses(beam, initial);
  refuse_overlap(masses);
  contact_.measure(problem_.scale.length);
  kinks_ = equations_->loads().kinks();
  flows_ = equations_->damping().any();
  for (const Support& support : contact_.supports()) {
    if (support.motion) {
      kinks_.insert(kinks_.end(), support.motion->time().begin(), support.motion->time().end());
    }
    flows_ = flows_ || support.motion || support.elastic();
  }
  std::ranges::sort(kinks_);
  kinks_.erase(std::ranges::unique(kinks_).begin(), kinks_.end());
  if (parameters.surface == ContactSurface::line && !equations.line().parameters().unfiltered &&
      !contact_.supports().empty()) {
    line_contact_.emplace(equations_->line(), contact_.supports(),
                          static_cast<std::size_t>(contact_.parameters().line_dense_max));
    equations_->hold_line(&*line_contact_);
  }
  UDAR_CALL(VecCreateMPI(beam.comm(), static_cast<PetscInt>(2 * count_), PETSC_DETERMINE, state_.put()));
  {
    const WriteArray access{state_};
    std::ranges::copy(masses.position, access.values());
    std::ranges::copy(masses.velocity, access.values() + count_);
  }
  configure_stepper();
}

ImpactDynamics::~ImpactDynamics() {
  if (line_contact_) {
    equations_->hold_line(nullptr);
  }
}

void ImpactDynamics::refuse_overlap(const MassState& masses) const {
  const BeamChain& beam = equations_->beam();
  std::string overlap;
  for (const ContactSet& run : near_) {
    const double lift = run.lift(0.0).height;
    for (std::size_t node = run.first; node < run.last && overlap.empty(); ++node) {
      const double height = run.height(node) + lift;
      const double gap = run.side * (masses.position[node] - height);
      if (gap < -contact_.together(masses.position[node], height)) {
        const Support& support = contact_.supports()[static_cast<std::size_t>(run.support)];
        const bool floor = std::isinf(support.width);
        std::ostringstream message;
        message << (!support.profile.x.empty() ? "ground profile"
                    : floor                    ? "floor height"
                                               : "support height")
                << ": " << height << " is not allowed, "
                << (floor ? "the ground" : "support " + std::to_string(run.support))
                << " overlaps the beam at the start, by " << -gap
                << " m at x = " << beam.position(beam.begin() + static_cast<PetscInt>(node))
                << " m; expected a height on its own side of the beam (`initial height`) [m]";
        overlap = message.str();
      }
    }
  }
  throw_together<InputError>(beam.comm(), overlap);
}

/// By the cost in line solves per unit wf t (docs/theory.md, "Which integrator"): about 2.5 + 0.9 per contact node for
/// `chebyshev`, 12 for `impact` whatever touches.
TSType ImpactDynamics::default_type() const {
  constexpr PetscInt kFew = 10;
  if (equations_->line().parameters().unfiltered) {
    return kTsMoreau;
  }
  if (line_contact_ || flows_) {
    return kTsImpact;
  }
  PetscInt nodes = 0;
  for (const ContactSet& run : contact_.runs()) {
    nodes += static_cast<PetscInt>(run.last - run.first);
  }
  MPI_Allreduce(MPI_IN_PLACE, &nodes, 1, MPIU_INT, MPI_SUM, equations_->beam().comm());
  return nodes <= kFew ? kTsChebyshev : kTsImpact;
}

/// What supports can do to masses alone.
void ImpactDynamics::refuse_on_line(const Support& support) const {
  const std::string where{" `contact surface` line or `filter frequency` none"};
  if (support.yield_speed < kNever) {
    throw InputError{"support yield speed: masses meet supports that yield; not allowed with" + where};
  }
  if (support.elastic() && support.damping > 0.0) {
    throw InputError{
        "support damping: a damper that holds the massless line moves by a rate of its own, which "
        "no mass has; expected 0 with" +
        where + " [N s/m]"};
  }
  if (support.elastic() && equations_->line().parameters().unfiltered) {
    throw InputError{
        "support stiffness: springs act by the place of the beam, and `ts type` moreau holds it by Newton's law "
        "of velocities; not allowed with `filter frequency` none, expected inf [N/m]"};
  }
}

/// Moving and elastic supports need an integrator that knows them.
void ImpactDynamics::refuse_supports() const {
  TSType type = nullptr;
  UDAR_CALL(TSGetType(ts_, &type));
  const std::string_view name{type};
  const Damping& damping = equations_->damping();
  if (contact_.runs_on_line() && damping.stiffness > 0.0) {
    throw InputError{
        "damping stiffness: not allowed with `contact surface` line or `filter frequency` none, expected 0 [s]: "
        "the rate of the line, by which it pulls, jumps where the line is held"};
  }
  if (damping.any() && (name == kTsChebyshev || name == kTsMoreau)) {
    throw InputError{"ts type: " + std::string{name} +
                     " is not allowed with `damping mass` or `damping stiffness`, expected impact or rk: it "
                     "knows undamped motion alone"};
  }
  for (const Support& support : contact_.supports()) {
    if (support.motion) {
      support.motion->require_smooth(end_time_);
    }
    if (contact_.runs_on_line()) {
      refuse_on_line(support);
    }
    if (!support.motion && !support.elastic()) {
      continue;
    }
    const std::string option = support.motion ? "`support motion`" : "`support stiffness`";
    if (name == kTsChebyshev) {
      throw InputError{"ts type: chebyshev is not allowed with " + option +
                       ", expected impact or rk: its "
                       "series know one constant matrix and forces linear in time, while " +
                       (support.motion ? "resting masses would be driven by the cubic motion of their support"
                                       : "every mass in contact would change the matrix")};
    }
  }
}

void ImpactDynamics::configure_stepper() {
  UDAR_CALL(TSCreate(equations_->beam().comm(), ts_.put()));
  UDAR_CALL(TSSetProblemType(ts_, TS_NONLINEAR));
  UDAR_CALL(register_ts_chebyshev());
  UDAR_CALL(register_ts_impact());
  UDAR_CALL(register_ts_moreau());
  compose_problem(ts_, problem_);
  UDAR_CALL(TSSetType(ts_, default_type()));
  // -ts_rk_type alone asks for rk, and rk is 5dp here, not PETSc's 3bs.
  std::array<char, 32> asked{};
  PetscBool type_given = PETSC_FALSE;
  PetscBool tableau_given = PETSC_FALSE;
  UDAR_CALL(PetscOptionsGetString(nullptr, nullptr, "-ts_type", asked.data(), asked.size(), &type_given));
  UDAR_CALL(PetscOptionsHasName(nullptr, nullptr, "-ts_rk_type", &tableau_given));
  if (std::string_view{asked.data()} == TSRK || (type_given == PETSC_FALSE && tableau_given == PETSC_TRUE)) {
    UDAR_CALL(TSSetType(ts_, TSRK));
    UDAR_CALL(TSRKSetType(ts_, TSRK5DP));
  }
  UDAR_CALL(TSSetApplicationContext(ts_, this));
  UDAR_CALL(TSSetPostStep(ts_, post_step_callback));
  UDAR_CALL(TSSetMaxSteps(ts_, std::numeric_limits<PetscInt>::max()));
  UDAR_CALL(TSSetExactFinalTime(ts_, TS_EXACTFINALTIME_MATCHSTEP));
  UDAR_CALL(TSSetMaxTime(ts_, 1.0));
  UDAR_CALL(TSSetTimeStep(ts_, 0.1 / equations_->line().frequency_bound()));
  UDAR_CALL(TSSetTolerances(ts_, 1e-8, nullptr, 1e-8, nullptr));
  UDAR_CALL(TSSetErrorIfStepFails(ts_, PETSC_FALSE));
  // 5dp is stable on the imaginary axis up to wf h = 1. In free flight nothing tells the error control so, and longer
  // steps would blow up round-off to the tolerance: symmetry would be lost there.
  TSAdapt adapt = nullptr;
  UDAR_CALL(TSGetAdapt(ts_, &adapt));
  petsc::use_largest_error(adapt);
  UDAR_CALL(TSAdaptSetStepLimits(adapt, PETSC_DEFAULT, 1.0 / equations_->line().frequency_bound()));
  UDAR_CALL(TSSetFromOptions(ts_));

  UDAR_CALL(TSSetSolution(ts_, state_));
  UDAR_CALL(TSGetMaxTime(ts_, &end_time_));
  if (!(end_time_ > 0.0) || !std::isfinite(end_time_)) {
    throw InputError{"ts max time: " + std::to_string(end_time_) + " is not allowed, expected a number > 0 [s]"};
  }
  refuse_supports();
  stepper_ = integrator_inside(ts_);
  if (equations_->line().parameters().unfiltered && (stepper_ == nullptr || !stepper_->fixed_step())) {
    throw InputError{"ts type: the unfiltered beam (`filter frequency` none) is integrated by moreau alone"};
  }
  if (stepper_ != nullptr) {
    UDAR_CALL(TSSetUp(ts_));
  } else {
    located_ = std::make_unique<LocatedSteps>(ts_, problem_);
    stepper_ = located_.get();
  }
  refuse_hops_without_length();
}

/// A hop that is over within the last digits of the time cannot be followed.
void ImpactDynamics::refuse_hops_without_length() const {
  const double shortest = time_resolution(end_time_);
  const double pull = equations_->line().frequency_bound() * problem_.scale.velocity;
  const double least = 0.125 * pull * shortest * shortest;
  if (!(contact_.parameters().hop_tolerance >= least)) {
    std::ostringstream message;
    message << "contact tolerance: " << contact_.parameters().hop_tolerance
            << " is not allowed, expected a number >= " << least
            << " [m]: at the end of the run a lower hop is over within the last digits of the time";
    throw InputError{message.str()};
  }
}

void ImpactDynamics::add_observer(Observer& observer) {
  observers_.push_back(&observer);
  due_.push_back({.observer = &observer, .next = 0});
}

PetscErrorCode ImpactDynamics::post_step_callback(TS stepper) {
  PetscFunctionBeginUser;
  void* context = nullptr;
  PetscCall(TSGetApplicationContext(stepper, static_cast<void*>(&context)));
  auto* self = static_cast<ImpactDynamics*>(context);
  PetscCall(petsc::guarded([&] { self->after_step(); }));
  PetscFunctionReturn(0);
}

/// Minus the integral of dF/dt' Yc from the start of the step, this rank's share. But for steps of fixed length dF/dt
/// is constant within a step.
double ImpactDynamics::changing_load_work(double until) const {
  const std::vector<double> amplitudes = stepper_->amplitude_integrals(until);
  const auto corrected = equations_->line().corrected_modes();
  double work = 0.0;
  for (const Loads::LocalLoad& load : equations_->loads().local()) {
    const auto node = static_cast<std::size_t>(load.local_node);
    double moved = 0.0;
    Loads::each_piece(load.table, time_, until, [&](double begin, double end) {
      const auto [force, rate] = Loads::evaluate(load.table, {begin, begin});
      if (begin > time_) {
        const auto before = Loads::evaluate(load.table, {begin, piece_begin(begin)});
        moved += (force - before.force) * stepper_->line_place(node, begin);
      }
      moved += rate * (stepper_->line_integral(node, end) - stepper_->line_integral(node, begin));
    });
    for (std::size_t mode = 0; mode < corrected.size(); ++mode) {
      moved -= Loads::evaluate(load.table, time_).rate * amplitudes[mode] * corrected[mode].shape[node];
    }
    work -= load.share * moved;
  }
  return work;
}

/// Where in the step at hand the loads began to be as they are up to a time.
double ImpactDynamics::piece_begin(double time) const {
  const auto kink = std::ranges::lower_bound(kinks_, time - time_resolution(time));
  return kink == kinks_.begin() ? time_ : std::max(time_, *std::prev(kink));
}

/// Loads that jump at the end of a step: the line follows at once, and what that changes in its energy they have done.
void ImpactDynamics::jump_loads(double begin) {
  LineState line;
  double after = 0.0;
  const auto energy = [&](const Instant& at) {
    const ReadArray state{state_};
    equations_->evaluate(at, {state.values(), count_}, line, true);
    return equations_->energy(line, {state.values(), count_}, {state.values() + count_, count_}).total();
  };
  const double before = energy({time_, begin});
  after = energy(time_);
  load_work_ += on_first_rank() ? after - before : 0.0;
  const double wf = equations_->line().filter_frequency();
  contact_.release_pulled(time_, wf * wf, line.stretch);
  contact_.commit(time_, {});
  tell_events();
  contact_.begin_step();
  stepper_->start(line);
}

/// Rows of a long step may take minutes: every so many of them, by their size, all ranks ask together.
bool ImpactDynamics::stop_between_rows(PetscInt rows) const {
  constexpr PetscInt kMostRows = 64;
  constexpr PetscInt kMostNodes = 2000000;  // some tenths of a second for the rows of so many nodes together
  const PetscInt every = std::clamp(kMostNodes / equations_->beam().nodes(), PetscInt{1}, kMostRows);
  if (!stop_requested_ || rows == 0 || rows % every != 0) {
    return false;
  }
  int stop = stop_requested_() ? 1 : 0;
  MPI_Allreduce(MPI_IN_PLACE, &stop, 1, MPI_INT, MPI_MAX, equations_->beam().comm());
  return stop != 0;
}

std::vector<FieldInfo> ImpactDynamics::fields() {
  std::vector<FieldInfo> all{kMotionFields.begin(), kMotionFields.end()};
  all.insert(all.end(), kBendingFields.begin(), kBendingFields.end());
  all.push_back(kRestingField);
  return all;
}

std::vector<Field> ImpactDynamics::shown_fields() const {
  using Numbers = std::span<const double>;
  return {
      {kMotionFields[0], Numbers{shown_.position}},     {kMotionFields[1], Numbers{shown_.velocity}},
      {kMotionFields[2], Numbers{shown_line_.stretch}}, {kBendingFields[0], Numbers{shown_line_.moment}},
      {kBendingFields[1], Numbers{shown_shear_}},       {kRestingField, std::span<const std::uint8_t>{shown_resting_}}};
}

void ImpactDynamics::emit_snapshots(double until) {
  const auto due_time = [this](const Due& due) {
    const double interval = due.observer->interval();
    return interval > 0.0 && !due.ended ? std::min(multiple(due.next, interval), end_time_) : kNever;
  };
  for (PetscInt rows = 0; !due_.empty(); ++rows) {
    const double time = due_time(*std::ranges::min_element(due_, {}, due_time));
    if (!(time <= until + time_resolution(until))) {
      break;
    }
    if (stop_between_rows(rows)) {
      throw StoppedBetweenRows{};
    }
    const petsc::LogScope output{petsc::log_events().output};
    last_row_time_ = time;
    snapshot(std::min(time, until), until);
    const std::vector<Field> shown = shown_fields();
    Snapshot snapshot{.time = time, .fields = shown, .energy = ledger_, .support_impulse = shown_impulse_};
    double since = time;  // of the zone at hand; most listeners have the same interval, and none a row before the first
    for (Due& due : due_) {
      if (due_time(due) <= time + time_resolution(time)) {
        const double last = due.next > 0 ? multiple(due.next - 1, due.observer->interval()) : time;
        if (last != since) {
          snapshot.zone = contact_.zone(last, std::min(time, until), shown_resting_);
          since = last;
        }
        ++due.next;
        due.ended = time >= end_time_ - time_resolution(end_time_);
        due.observer->snapshot(snapshot);
      }
    }
  }
  // 41 bytes per node, seldom needed.
  shown_ = {};
  shown_line_ = {};
  shown_shear_ = {};
  shown_resting_ = {};
}

/// Energy of what the step control lets pass: errors of the velocities that add up over the steps. It is in the balance
/// squared and, with a velocity that is no larger, once; ten times it hides neither.
double ImpactDynamics::tolerated_energy() const {
  constexpr double kMargin = 10.0;
  if (stepper_->fixed_step()) {
    return 0.0;
  }
  const double error = static_cast<double>(steps_) * step_tolerance(ts_, problem_.scale) * problem_.scale.velocity;
  return kMargin * equations_->beam().total_mass() * error * error;
}

/// Fills what is shown at one time of the step that ends at `until`; the stretch becomes the position of the line.
void ImpactDynamics::snapshot(double time, double until) {
  shown_.position.resize(count_);
  shown_.velocity.resize(count_);
  shown_resting_.resize(count_);
  stepper_->masses(time, shown_.position, shown_.velocity, shown_resting_);
  const PetscInt solves = equations_->line().solves();
  equations_->evaluate({time, piece_begin(time)}, shown_.position, shown_line_, true);
  row_line_solves_ += equations_->line().solves() - solves;
  EnergyLedger now = equations_->energy(shown_line_, shown_.position, shown_.velocity);
  shown_shear_.resize(count_);
  equations_->line().shear(shown_line_.moment, shown_shear_);
  const std::vector<double>& given = contact_.support_impulses();
  constexpr std::size_t kEnergies = 5;
  std::vector<double> sums(kEnergies + given.size(), 0.0);  // within the step
  sums[0] = contact_.lost_before(time);
  contact_.add_impulses(time, until > time_ ? (time - time_) / (until - time_) : 0.0,
                        std::span{sums}.subspan(kEnergies));
  if (equations_->loads().time_dependent()) {
    sums[1] = load_work_ + changing_load_work(time);
  }
  if (flows_) {
    const EnergyFlow flow = stepper_->flow(time);
    sums[2] = flow.work;
    sums[3] = flow.damped;
    sums[4] = contact_.spring_energy(time, shown_.position);
  }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM,
                equations_->beam().comm());
  shown_impulse_.resize(given.size());
  std::ranges::transform(given, std::span{sums}.subspan(kEnergies), shown_impulse_.begin(), std::plus{});
  now.lost_in_impacts = contact_.counts().lost + sums[0];
  now.load_work = sums[1];
  now.support_work = contact_.counts().work + sums[2];
  now.lost_in_dampers = contact_.counts().damped + sums[3];
  now.support_springs += sums[4];
  now.initial = ledger_.initial;
  const double taken = now.lost_in_dampers - ledger_.lost_in_dampers;
  now.initial_potential = ledger_.initial_potential;
  now.scale = std::max({ledger_.scale, now.scale, now.turned_over(), tolerated_energy()});
  if (!std::isfinite(now.drift())) {
    throw SolveError{"the energy is no longer finite at t = " + std::to_string(time) +
                     " s: the motion has outgrown double precision; the integration is unstable (see -ts_dt, "
                     "-ts_adapt_type, -ts_rtol), or a load, a speed or a height is too large"};
  }
  ledger_ = now;
  if (!(std::abs(now.drift()) <= kUnstable)) {
    throw SolveError{"the integration is unstable: the energy balance is off by " + std::to_string(now.drift()) +
                     " of the energy at t = " + std::to_string(time) +
                     " s; steps must stay below about 1 / `filter frequency` (see -ts_dt, -ts_adapt_type, -ts_rtol)"};
  }
  if (!(taken >= -std::max(kDamperRounding, step_tolerance(ts_, problem_.scale)) * now.scale)) {
    throw SolveError{"dampers have given " + std::to_string(-taken) + " J before t = " + std::to_string(time) +
                     " s, where they can but take; shorten the steps (see -ts_dt, -ts_rtol)"};
  }
  shown_line_.stretch = equations_->line_stretch(shown_line_);
  for (std::size_t i = 0; i < count_; ++i) {
    shown_line_.stretch[i] += shown_.position[i];
  }
  if (line_contact_) {
    for (const std::size_t point : line_contact_->mine()) {
      if (shown_line_.contact_force[point] > 0.0) {
        shown_resting_[line_contact_->local(point)] = 1;
      }
    }
  }
}

void ImpactDynamics::tell_events() {
  if (contact_.any_events()) {
    const petsc::LogScope output{petsc::log_events().output};
    for (Observer* observer : observers_) {
      observer->events(contact_.impacts(), contact_.rests(), contact_.all_events());
    }
  }
}

void ImpactDynamics::start() {
  started_ = true;
  if (!restored_) {
    UDAR_CALL(TSGetTime(ts_, &time_));
    LineState line;
    {
      const ReadArray state{state_};
      equations_->evaluate(time_, {state.values(), count_}, line, true);
      ledger_ = equations_->energy(line, {state.values(), count_}, {state.values() + count_, count_});
      ledger_.initial = ledger_.total();
      ledger_.initial_potential = ledger_.load_potential;
      const std::vector<double> stretch = equations_->line_stretch(line);
      for (const ContactSet& run : near_) {
        for (std::size_t node = run.first; node < run.last; ++node) {
          const double height = run.height(node) + run.lift(time_).height;
          contact_.line_at(run.side * (state.values()[node] + stretch[node] - height), node, time_);
        }
      }
    }
    stepper_->start(line);
    emit_snapshots(time_);
    UDAR_CALL(TSGetTimeStep(ts_, &wanted_step_));
    const double wf = equations_->line().filter_frequency();
    {
      const WriteArray state{state_};
      contact_.resolve(time_, {}, wf * wf, {state.values(), count_}, {state.values() + count_, count_}, line.stretch);
    }
    contact_.commit(time_, {});
    tell_events();
    stepper_->start(line);
  } else {
    for (Due& due : due_) {
      const double interval = due.observer->interval();
      if (interval > 0.0) {  // snapshots up to there were taken by the run that wrote the restart file
        const double taken = std::max(time_, last_row_time_);
        due.next = static_cast<PetscInt>(std::floor((taken + time_resolution(taken)) / interval)) + 1;
      }
    }
  }
  contact_.begin_step();
  limit_step(wanted_step_);
}

/// The next step ends at the latest at a kink of a load table or at the end of the run.
void ImpactDynamics::limit_step(double next_step) {
  wanted_step_ = next_step;
  const auto kink = std::ranges::upper_bound(kinks_, time_ + time_resolution(time_));
  double step = std::min(next_step, end_time_ - time_);
  step_was_cut_ = false;
  if (!stepper_->fixed_step() && kink != kinks_.end() && time_ + step > *kink) {
    step = *kink - time_;
    step_was_cut_ = true;
  }
  if (step > 0.0) {
    UDAR_CALL(TSSetTimeStep(ts_, step));
  }
}

/// Where a mass, or the line that contact is on, is below a rigid support by more than what a step of the scheme may
/// leave it; empty: nowhere on this rank.
std::string ImpactDynamics::fallen_through(double time) const {
  const double deep = kFallenThrough * problem_.scale.length;
  const auto text = [&](double depth, double x) {
    std::ostringstream message;
    message << "the beam has fallen through a rigid support at t = " << time << " s, by " << depth << " m at x = " << x
            << " m: the steps are too long to see it come (see -ts_dt, -ts_rtol)";
    return message.str();
  };
  if (line_contact_) {
    const bool gives_way = std::ranges::any_of(contact_.supports(), &Support::elastic);
    const LineGap& gap = contact_.local_line_gap();
    return gap.gap < -deep && !gives_way ? text(-gap.gap, gap.x) : std::string{};
  }
  const std::span<const double> start = stepper_->start_of_step();
  const ReadArray state{state_};
  for (const ContactSet& run : near_) {
    const double lift = run.lift(time, time_).height;
    for (std::size_t node = run.first; node < run.last && !run.elastic(); ++node) {
      const double depth = -run.side * (state.values()[node] - run.height(node) - lift);
      // Moreau's law finds a support up to half a step late.
      if (!(depth <= deep) && !(depth <= (time - time_) * std::abs(start[count_ + node]))) {
        return text(depth, equations_->beam().position(equations_->beam().begin() + static_cast<PetscInt>(node)));
      }
    }
  }
  return {};
}

/// A run whose time no longer moves on ends.
void ImpactDynamics::refuse_standstill(double time) {
  const bool events = contact_.any_events();
  events_at_once_ = events && time - time_ <= time_resolution(time) ? events_at_once_ + 1 : 0;
  if (events_at_once_ > kMostEventsAtOnce) {
    throw SolveError{"contact does not settle at t = " + std::to_string(time) + " s after " +
                     std::to_string(kMostEventsAtOnce) +
                     " events at one instant; raise `contact tolerance` or lower -ts_rtol"};
  }
  const double least = kLeastStep / equations_->line().frequency_bound();
  if (time - time_ >= least) {
    short_steps_ = 0;
  } else if (!events && !step_was_cut_) {
    ++short_steps_;
  }
  if (short_steps_ > kMostShortSteps) {
    std::ostringstream message;
    message << "the time stands still at t = " << time << " s: " << kMostShortSteps << " steps are shorter than "
            << least
            << " s, a millionth of the fastest motion; raise -ts_rtol or -ts_dt, or look for a load or a support that "
               "jumps";
    throw SolveError{message.str()};
  }
}

void ImpactDynamics::after_step() {
  const petsc::LogScope contact{petsc::log_events().contact};
  const double time = stepper_->end_step();
  emit_snapshots(time);
  const double load_work = equations_->loads().time_dependent() ? changing_load_work(time) : 0.0;
  stepper_->apply_events();
  const std::string fallen = fallen_through(time);
  const bool stop_here = stop_requested_ && stop_requested_();
  std::array<double, 2> told{stop_here ? 1.0 : 0.0, fallen.empty() ? 0.0 : 1.0};
  contact_.commit(time, told);
  const double stop = told[0];
  if (told[1] != 0.0) {
    throw_together<SolveError>(equations_->beam().comm(), fallen);
  }
  refuse_standstill(time);
  load_work_ += load_work;
  steps_ += time > time_ ? 1 : 0;
  tell_events();
  contact_.begin_step();
  const double piece = piece_begin(time);
  time_ = time;
  stepper_->begin_step();
  if (equations_->loads().jumps_at(time)) {
    jump_loads(piece);
  }
  const double next_step = stepper_->next_step();
  limit_step(step_was_cut_ ? std::max(next_step, wanted_step_) : next_step);
  UDAR_CALL(TSGetStepRejections(ts_, &rejected_steps_));
  if (stop != 0.0) {
    UDAR_CALL(TSSetConvergedReason(ts_, TS_CONVERGED_USER));
  } else if (end_time_ - time <= time_resolution(end_time_)) {
    UDAR_CALL(TSSetConvergedReason(ts_, TS_CONVERGED_TIME));
  }
  const Progress progress{.time = time,
                          .end_time = end_time_,
                          .steps = steps_,
                          .impacts = contact_.counts().impacts,
                          .resting = contact_.counts().resting,
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
  completed_ = time_ >= end_time_;
  if (!completed_) {
    try {
      UDAR_CALL(TSSolve(ts_, nullptr));
      TSConvergedReason reason = TS_CONVERGED_ITERATING;
      UDAR_CALL(TSGetConvergedReason(ts_, &reason));
      if (reason < 0) {
        throw SolveError{std::string{"the time integration failed: "} + TSConvergedReasons[reason] +
                         " at t = " + std::to_string(time_) + " s (see -ts_monitor, -ts_adapt_monitor)"};
      }
      completed_ = reason == TS_CONVERGED_TIME;
    } catch (const StoppedBetweenRows&) {
      contact_.undo();
      stepper_->return_to_start();
    } catch (...) {
      contact_.undo();
      stepper_->return_to_start();
      throw;
    }
  }
  for (Observer* observer : observers_) {
    const petsc::LogScope output{petsc::log_events().output};
    observer->finish();
  }
}

RunCounts ImpactDynamics::counts() const {
  RunCounts counts{contact_.counts()};
  counts.steps = steps_;
  counts.repeated_steps = stepper_->repeated_steps();
  counts.rejected_steps = rejected_steps_;
  counts.rhs_evaluations = stepper_->evaluations();
  counts.row_line_solves = row_line_solves_;
  return counts;
}

double ImpactDynamics::streamed_bytes() const {
  const ChainSolver* chain = equations_->line().chain();
  const double own = stepper_->streamed_bytes();
  if (own == 0.0 || chain == nullptr) {
    return 0.0;
  }
  const double number = 0.0;
  constexpr double kCorrection = 48.0;  // a node and mode: a dot product with three arrays, an axpy
  const double correction = kCorrection * static_cast<double>(equations_->line().corrected_modes().size() * count_);
  return own + static_cast<double>(equations_->line().solves()) *
                   (chain->bytes_per_solve({.displacement = &number}) + correction);
}

MassState ImpactDynamics::masses() const {
  const ReadArray state{state_};
  return {.position = {state.values(), state.values() + count_},
          .velocity = {state.values() + count_, state.values() + 2 * count_}};
}

MotionState ImpactDynamics::save() const {
  MotionState saved;
  MassState now = masses();
  const auto& resting = contact_.resting_supports();
  saved.fields["mass_position"] = std::move(now.position);
  saved.fields["mass_velocity"] = std::move(now.velocity);
  saved.fields["resting_on"].assign(resting.begin(), resting.end());
  if (!contact_.supports().empty()) {
    auto& last = saved.fields["last_contact"];
    last = contact_.last_contact();
    last.resize(count_, -kNever);  // none on a rank that nothing can touch
  }
  const LineGap gap = smallest_line_gap();
  double work = load_work_;
  MPI_Allreduce(MPI_IN_PLACE, &work, 1, MPI_DOUBLE, MPI_SUM, equations_->beam().comm());
  const ContactCounts& counts = contact_.counts();
  saved.scalars = {{"time", time_},
                   {"last_row_time", last_row_time_},
                   {"wanted_step", wanted_step_},
                   {"steps", static_cast<double>(steps_)},
                   {"impacts", static_cast<double>(counts.impacts)},
                   {"rests", static_cast<double>(counts.rests)},
                   {"releases", static_cast<double>(counts.releases)},
                   {"resting", static_cast<double>(counts.resting)},
                   {"first_contact_time", counts.first_contact_time},
                   {"last_contact_time", counts.last_contact_time},
                   {"lost_in_impacts", counts.lost},
                   {"support_work", counts.work},
                   {"lost_in_dampers", counts.damped},
                   {"initial_energy", ledger_.initial},
                   {"initial_potential", ledger_.initial_potential},
                   {"energy_scale", ledger_.scale},
                   {"load_work", work},
                   {"line_gap", gap.gap},
                   {"line_gap_x", gap.x},
                   {"line_gap_time", gap.time}};
  saved.tables["support_impulse"] = support_impulses();
  stepper_->save(saved);
  for (const Observer* observer : observers_) {
    observer->save(saved);
  }
  return saved;
}

void ImpactDynamics::restore(const MotionState& state) {
  const auto count = [&](const char* name) { return static_cast<PetscInt>(state.scalar(name)); };
  {
    const WriteArray now{state_};
    std::ranges::copy(state.field("mass_position", count_), now.values());
    std::ranges::copy(state.field("mass_velocity", count_), now.values() + count_);
  }
  time_ = state.scalar("time");
  last_row_time_ = state.scalar("last_row_time");
  wanted_step_ = state.scalar("wanted_step");
  steps_ = count("steps");
  ledger_.lost_in_impacts = state.scalar("lost_in_impacts");
  ledger_.initial = state.scalar("initial_energy");
  ledger_.initial_potential = state.scalar("initial_potential");
  ledger_.scale = state.scalar("energy_scale");
  load_work_ = on_first_rank() ? state.scalar("load_work") : 0.0;
  const auto impulses = state.tables.find("support_impulse");
  if (impulses == state.tables.end() || impulses->second.size() != contact_.supports().size()) {
    throw InputError{"restart file: it was written with another number of supports"};
  }
  const std::vector<double>& resting = state.field("resting_on", count_);
  ContactCounts counts;
  counts.impacts = count("impacts");
  counts.rests = count("rests");
  counts.releases = count("releases");
  counts.resting = count("resting");
  counts.first_contact_time = state.scalar("first_contact_time");
  counts.last_contact_time = state.scalar("last_contact_time");
  counts.lost = state.scalar("lost_in_impacts");
  counts.work = state.scalar("support_work");
  counts.damped = state.scalar("lost_in_dampers");
  contact_.restore(
      std::vector<std::int32_t>(resting.begin(), resting.end()), counts,
      {.gap = state.scalar("line_gap"), .x = state.scalar("line_gap_x"), .time = state.scalar("line_gap_time")},
      impulses->second, contact_.supports().empty() ? std::span<const double>{} : state.field("last_contact", count_));
  UDAR_CALL(TSSetTime(ts_, time_));
  stepper_->restore(state);
  restored_ = true;
}

}  // namespace udar
