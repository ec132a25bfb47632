#include "udar/dynamics/impact_dynamics.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <functional>
#include <string>
#include <utility>

#include "udar/motion/motion_scale.hpp"
#include "udar/petsc/array.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/log.hpp"

namespace udar {
namespace {

/// @name What is counted over all programs that a run goes through, beside the integrators' own.
/// @{
constexpr const char* kRepeatedSteps = "repeated_steps";
constexpr const char* kRejectedSteps = "rejected_steps";
constexpr const char* kEvaluations = "rhs_evaluations";
constexpr const char* kRowLineSolves = "row_line_solves";
constexpr const char* kLineSolves = "line_solves";
/// @}
/// @name Of the plastic hinges in a restart file.
/// @{
constexpr const char* kRotations = "hinge_rotations";
constexpr const char* kTurned = "hinge_turned";
/// @}
const std::string kCounted = "counted ";  ///< before these names in a restart file

using petsc::ReadArray;
using petsc::WriteArray;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Ends a run between the rows of a step: the way out of PETSc's time loop.
struct StoppedBetweenRows : std::exception {};

ContactParameters with_defaults(ContactParameters parameters, const MotionScale& scale) {
  if (parameters.hop_tolerance == 0.0) {
    parameters.hop_tolerance = kHopShare * scale.length;
  }
  return parameters;
}

/// Contact as a restart file keeps it. @note Collective.
void save_contact(const ContactState& contact, std::size_t nodes, MotionState& saved) {
  const auto& resting = contact.resting_supports();
  saved.fields["resting_on"].assign(resting.begin(), resting.end());
  if (!contact.supports().empty()) {
    auto& last = saved.fields["last_contact"];
    last = contact.last_contact();
    last.resize(nodes, -kInfinity);  // none on a rank that nothing can touch
  }
  const LineGap gap = contact.smallest_line_gap();
  const ContactCounts& counts = contact.counts();
  saved.scalars.insert({{"impacts", static_cast<double>(counts.impacts)},
                        {"rests", static_cast<double>(counts.rests)},
                        {"releases", static_cast<double>(counts.releases)},
                        {"resting", static_cast<double>(counts.resting)},
                        {"event_steps", static_cast<double>(counts.event_steps)},
                        {"first_contact_time", counts.first_contact_time},
                        {"last_contact_time", counts.last_contact_time},
                        {"lost_in_impacts", counts.lost},
                        {"support_work", counts.work},
                        {"lost_in_dampers", counts.damped},
                        {"radiated", counts.radiated},
                        {"lost_in_hinges", counts.yielded},
                        {"line_gap", gap.gap},
                        {"line_gap_x", gap.x},
                        {"line_gap_time", gap.time}});
  saved.tables["support_impulse"] = contact.support_impulses();
}

/// Refuses masses that rest where they cannot, or on springs. @note Collective.
void require_supports_to_rest_on(MPI_Comm comm, const ContactState& contact, std::span<const double> resting) {
  std::string failure;
  for (std::size_t node = 0; node < resting.size() && failure.empty(); ++node) {
    const auto holds = [&](const ContactSet& set) {
      return set.support + 1 == static_cast<PetscInt>(resting[node]) && node >= set.first && node < set.last &&
             !set.elastic();
    };
    if (resting[node] != 0.0 && std::ranges::none_of(contact.sets(), holds)) {
      failure = "restart file: a mass rests on support " + std::to_string(static_cast<PetscInt>(resting[node]) - 1) +
                " (counted from 0), which does not hold it";
    }
  }
  throw_together<InputError>(comm, failure);
}

void restore_contact(MPI_Comm comm, const MotionState& state, std::size_t nodes, ContactState& contact) {
  const auto count = [&](const char* name) { return static_cast<PetscInt>(state.scalar(name)); };
  const auto impulses = state.tables.find("support_impulse");
  if (impulses == state.tables.end() || impulses->second.size() != contact.supports().size()) {
    throw InputError{"restart file: it was written with another number of supports"};
  }
  const std::vector<double>& resting = state.field("resting_on", nodes);
  require_supports_to_rest_on(comm, contact, resting);
  ContactCounts counts;
  counts.impacts = count("impacts");
  counts.rests = count("rests");
  counts.releases = count("releases");
  counts.resting = count("resting");
  counts.event_steps = count("event_steps");
  counts.first_contact_time = state.scalar("first_contact_time");
  counts.last_contact_time = state.scalar("last_contact_time");
  counts.lost = state.scalar("lost_in_impacts");
  counts.work = state.scalar("support_work");
  counts.damped = state.scalar("lost_in_dampers");
  counts.radiated = state.scalar("radiated");
  counts.yielded = state.scalar("lost_in_hinges");
  ContactTotals totals{
      .counts = counts,
      .impulses = impulses->second,
      .line_gap = {
          .gap = state.scalar("line_gap"), .x = state.scalar("line_gap_x"), .time = state.scalar("line_gap_time")}};
  contact.restore(std::vector<std::int32_t>(resting.begin(), resting.end()), std::move(totals),
                  contact.supports().empty() ? std::span<const double>{} : state.field("last_contact", nodes));
}

}  // namespace

ImpactDynamics::ImpactDynamics(Model& model)
    : model_{&model},
      problem_{.equations = &model.equations,
               .contact = &contact_,
               .contacts = &model.contacts,
               .scale = motion_scale(model.equations, model.initial, model.contacts.sets, asked_end_time()),
               .kinks = &kinks_},
      contact_{model.structure->points(), model.contacts, with_defaults(model.contact, problem_.scale)},
      kinks_{model.loads, model.contacts.supports},
      balance_{model.equations, contact_, kinks_},
      guards_{model.equations, contact_, model.contacts.sets, problem_.scale},
      state_{place_masses(model.initial)},
      stepping_{configure_stepping(problem_, state_)},
      schedule_{stepping_.end_time},
      standstill_{model.equations.frequency_bound()} {
  refuse_hops_without_length(contact_.parameters(), problem_.scale, model.equations.frequency_bound(),
                             stepping_.end_time);
  UDAR_CALL(TSSetApplicationContext(stepping_.ts, this));
  UDAR_CALL(TSSetPostStep(stepping_.ts, post_step_callback));
}

/// The state of the TS at the start, masses on their own side of every support.
petsc::Vector ImpactDynamics::place_masses(const InitialState& initial) {
  const MassState masses = initial_masses(model_->structure->points(), initial);
  refuse_overlap(model_->structure->points(), contact_, model_->contacts.sets, masses);
  contact_.set_motion_length(problem_.scale.length);
  petsc::Vector state;
  UDAR_CALL(VecCreateMPI(model_->structure->points().comm(), static_cast<PetscInt>(2 * count()), PETSC_DETERMINE,
                         state.put()));
  const WriteArray access{state};
  std::ranges::copy(masses.position, access.values());
  std::ranges::copy(masses.velocity, access.values() + count());
  return state;
}

PetscErrorCode ImpactDynamics::post_step_callback(TS stepper) {
  PetscFunctionBeginUser;
  void* context = nullptr;
  PetscCall(TSGetApplicationContext(stepper, static_cast<void*>(&context)));
  auto* self = static_cast<ImpactDynamics*>(context);
  PetscCall(petsc::guarded([&] { self->after_step(); }));
  PetscFunctionReturn(0);
}

/// Loads that jump at the end of a step. @param begin since when they were as before
void ImpactDynamics::jump_loads(double begin) {
  LineState line;
  const auto side = [&](const Instant& at) {
    const ReadArray state{state_};
    return balance_.side(at, {state.values(), count()}, {state.values() + count(), count()}, line);
  };
  const EnergyBalance::Side before = side({time_, begin});
  const double gained = stepping_.integrator->follow_loads();
  balance_.end_jump({time_, begin}, before, side(time_), gained);
  const double wf = model_->line.filter_frequency();
  contact_.release_pulled(time_, wf * wf, line.stretch);
  contact_.commit(time_, {});
  tell_events();
  contact_.begin_step();
  stepping_.integrator->start(line);
}

/// Rows of a long step may take minutes: every so many of them, by their size, all ranks ask together.
bool ImpactDynamics::stop_between_rows(PetscInt rows) const {
  constexpr PetscInt kMostRows = 64;
  constexpr PetscInt kMostNodes = 2000000;  // some tenths of a second for the rows of so many nodes together
  const PetscInt every = std::clamp(kMostNodes / model_->structure->points().total(), PetscInt{1}, kMostRows);
  if (!requests_.stop || rows == 0 || rows % every != 0) {
    return false;
  }
  int stop = requests_.stop() ? 1 : 0;
  MPI_Allreduce(MPI_IN_PLACE, &stop, 1, MPI_INT, MPI_MAX, model_->structure->points().comm());
  return stop != 0;
}

std::vector<FieldInfo> ImpactDynamics::fields() const {
  const auto internal = model_->line.filter_operator().internal_fields();
  std::vector<FieldInfo> all{kMotionFields.begin(), kMotionFields.end()};
  all.insert(all.end(), internal.begin(), internal.end());
  if (model_->equations.hinges() != nullptr) {
    all.push_back(kRotationField);
  }
  all.push_back(kTouchedField);
  all.push_back(kRestingField);
  return all;
}

std::vector<Field> ImpactDynamics::fields_of(const Row& row) const {
  using Numbers = std::span<const double>;
  std::vector<Field> all{{kMotionFields[0], Numbers{row.masses.position}},
                         {kMotionFields[1], Numbers{row.masses.velocity}},
                         {kMotionFields[2], Numbers{row.line_position}}};
  Numbers values = row.internal;
  const FilterOperator& filter = model_->line.filter_operator();
  for (const FieldInfo& field : filter.internal_fields()) {
    all.push_back({field, values.first(filter.internal_places())});
    values = values.subspan(filter.internal_places());
  }
  if (model_->equations.hinges() != nullptr) {
    all.push_back({kRotationField, Numbers{row.rotation}});
  }
  all.push_back({kTouchedField, std::span<const std::uint8_t>{row.touched}});
  all.push_back({kRestingField, std::span<const std::uint8_t>{row.resting}});
  return all;
}

void ImpactDynamics::emit_snapshots(double until) {
  Row row;
  for (PetscInt rows = 0; schedule_.is_due(until); ++rows) {
    if (stop_between_rows(rows)) {
      throw StoppedBetweenRows{};
    }
    const petsc::LogScope output{petsc::log_events().output};
    last_row_time_ = schedule_.next();
    const double within = std::min(last_row_time_, until);
    fill(row, within, until);
    row.touched = row.resting;  // before the first row
    const std::vector<Field> fields = fields_of(row);
    Snapshot snapshot{
        .time = last_row_time_, .fields = fields, .energy = balance_.ledger(), .support_impulse = row.support_impulse};
    snapshot.places = row.places;
    snapshot.riders = row.riders;
    schedule_.tell(snapshot, [&](double since) { return contact_.zone(since, within, row.resting, row.touched); });
  }
}

/// The step control lets errors of the velocities pass that add up over the steps. They are in the balance squared and,
/// with a velocity that is no larger, once; ten times that hides neither.
double ImpactDynamics::tolerated_energy() const {
  constexpr double kMargin = 10.0;
  if (stepping_.integrator->fixed_step()) {
    return 0.0;
  }
  const double error = static_cast<double>(steps_) * stepping_.tolerance * problem_.scale.velocity;
  return kMargin * model_->structure->points().total_mass() * error * error;
}

/// @param time within the step that ends at `until`
void ImpactDynamics::fill(Row& row, double time, double until) {
  const Integrator& step = *stepping_.integrator;
  row.masses.position.resize(count());
  row.masses.velocity.resize(count());
  row.resting.resize(count());
  step.masses(time, row.masses.position, row.masses.velocity, row.resting);
  const PetscInt solves = model_->line.solves();
  model_->equations.evaluate({time, kinks_.piece_begin(time_, time)}, row.masses.position, row.line, true,
                             step.rotations(time));
  counters_.row_line_solves += model_->line.solves() - solves;
  if (const HingedLine* hinges = model_->equations.hinges(); hinges != nullptr) {
    row.rotation.resize(count());
    hinges->spread(row.line.rotation, row.rotation);
  }
  const FilterOperator& filter = model_->line.filter_operator();
  row.internal.resize(filter.internal_fields().size() * filter.internal_places());
  filter.internal_values(row.line.moment, row.internal);
  row.support_impulse.assign(contact_.support_impulses().size(), 0.0);  // within the step
  if (!step.add_impulses(time, row.support_impulse)) {
    contact_.journal().add_impulses(time, until > time_ ? (time - time_) / (until - time_) : 0.0, row.support_impulse);
  }
  const EnergyLedger before = balance_.ledger();
  const EnergyLedger now = balance_.update({.time = time, .step_begin = time_, .line = row.line, .masses = row.masses},
                                           step, row.support_impulse, tolerated_energy());
  guards_.see({.time = time, .before = before, .now = now, .masses = row.masses, .tolerance = stepping_.tolerance});
  guards_.tell(guards_.waiting());
  std::ranges::transform(contact_.support_impulses(), row.support_impulse, row.support_impulse.begin(), std::plus{});
  row.line_position = model_->equations.line_position(row.line, row.masses.position);
  row.places =
      model_->equations.places({time, kinks_.piece_begin(time_, time)}, row.masses.position, row.line_position);
  row.riders = model_->equations.riders(row.line, row.masses.position, row.masses.velocity);
  if (const LineContact* line_contact = model_->equations.line_contact(); !row.line.contact_force.empty()) {
    for (const std::size_t point : line_contact->mine()) {
      if (row.line.contact_force[point] > 0.0) {
        row.resting[line_contact->local(point)] = 1;
      }
    }
  }
}

void ImpactDynamics::tell_events() {
  if (contact_.any_events()) {
    const petsc::LogScope output{petsc::log_events().output};
    for (Observer* observer : schedule_.observers()) {
      observer->events(contact_.journal().impacts(), contact_.journal().rests(), contact_.all_events());
    }
  }
}

void ImpactDynamics::tell_progress(bool checkpoint) {
  const Progress progress{.time = time_,
                          .end_time = stepping_.end_time,
                          .steps = steps_,
                          .impacts = contact_.counts().impacts,
                          .resting = contact_.counts().resting,
                          .energy_drift = balance_.ledger().drift(),
                          .checkpoint = checkpoint};
  for (Observer* observer : schedule_.observers()) {
    const petsc::LogScope output{petsc::log_events().output};
    observer->step(progress);
  }
}

void ImpactDynamics::start() {
  // Up to here, or from `restore` to here, solves are none of the stepping.
  const PetscInt solves = model_->line.solves();
  counters_.before[kLineSolves] -= solves - std::exchange(counters_.setup_line_solves, solves);
  if (phase_ == Phase::restored) {
    schedule_.resume(std::max(time_, last_row_time_));  // up to there the run that wrote the restart file took them
  } else {
    settle_at_start();
  }
  phase_ = Phase::running;
  contact_.begin_step();
  limit_step(wanted_step_);
}

/// The rows at t = 0, and the masses that start on a support.
void ImpactDynamics::settle_at_start() {
  UDAR_CALL(TSGetTime(stepping_.ts, &time_));
  stepping_.integrator->settle();
  LineState line;
  {
    const ReadArray state{state_};
    const std::span<const double> position{state.values(), count()};
    model_->equations.evaluate(time_, position, line, true);
    stepping_.integrator->start(line);
    balance_.start({.time = time_, .step_begin = time_, .line = line, .masses = masses()}, *stepping_.integrator);
    const std::vector<double> stretch = model_->equations.line_stretch(line);
    for (const ContactSet& set : model_->contacts.sets) {
      for (std::size_t node = set.first; node < set.last; ++node) {
        const double height = set.height(node) + set.lift(time_).height;
        contact_.record_gap(set.side * (position[node] + stretch[node] - height), node, time_);
      }
    }
  }
  emit_snapshots(time_);
  UDAR_CALL(TSGetTimeStep(stepping_.ts, &wanted_step_));
  const double wf = model_->line.filter_frequency();
  {
    const WriteArray state{state_};
    contact_.resolve({.time = time_,
                      .acceleration = wf * wf,
                      .position = {state.values(), count()},
                      .velocity = {state.values() + count(), count()},
                      .stretch = line.stretch});
  }
  contact_.commit(time_, {});
  tell_events();
  stepping_.integrator->start(line);
}

/// The next step ends at the latest at a kink of a load table or at the end of the run.
void ImpactDynamics::limit_step(double next_step) {
  wanted_step_ = next_step;
  const double kink = kinks_.after(time_);
  double step = std::min(next_step, stepping_.end_time - time_);
  step_was_cut_ = !stepping_.integrator->fixed_step() && time_ + step > kink;
  if (step_was_cut_) {
    step = kink - time_;
  }
  if (step > 0.0) {
    UDAR_CALL(TSSetTimeStep(stepping_.ts, step));
  }
}

/// Ends the journal of the step, or the run. @param[out] stop not zero where some rank asked to
ImpactDynamics::Asked ImpactDynamics::judge_step(double time) {
  {
    const ReadArray state{state_};
    guards_.see({.begin = time_,
                 .time = time,
                 .before = stepping_.integrator->start_of_step(),
                 .after = {state.values(), 2 * count()},
                 .tolerance = stepping_.tolerance,
                 .late = stepping_.integrator->fixed_step()});
  }
  const bool stop_here = requests_.stop && requests_.stop();
  const bool wanted_here = requests_.checkpoint && requests_.checkpoint();
  std::array<double, 3> told{stop_here ? 1.0 : 0.0, wanted_here ? 1.0 : 0.0, guards_.waiting()};
  contact_.commit(time, told);
  guards_.tell(told[2]);
  standstill_.see(time_, time, contact_.any_events(), step_was_cut_);
  return {.stop = told[0] != 0.0, .checkpoint = told[1] != 0.0};
}

void ImpactDynamics::after_step() {
  const petsc::LogScope contact{petsc::log_events().contact};
  Integrator& integrator = *stepping_.integrator;
  const double time = integrator.end_step();
  emit_snapshots(time);
  const EnergyBalance::Work load_work = balance_.load_work(integrator, time_, time);
  integrator.apply_events();
  const Asked asked = judge_step(time);
  balance_.end_step(load_work);
  steps_ += time > time_ ? 1 : 0;
  tell_events();
  contact_.begin_step();
  const double piece = kinks_.piece_begin(time_, time);
  time_ = time;
  integrator.begin_step();
  if (model_->loads.jumps_at(time)) {
    jump_loads(piece);
  }
  const double next_step = integrator.next_step();
  limit_step(step_was_cut_ ? std::max(next_step, wanted_step_) : next_step);
  UDAR_CALL(TSGetStepRejections(stepping_.ts, &counters_.rejected_steps));
  const bool at_end = stepping_.end_time - time <= time_resolution(stepping_.end_time);
  if (asked.stop || at_end || requests_.until - time <= time_resolution(time)) {
    UDAR_CALL(TSSetConvergedReason(stepping_.ts, at_end && !asked.stop ? TS_CONVERGED_TIME : TS_CONVERGED_USER));
  }
  tell_progress(asked.checkpoint);
}

void ImpactDynamics::solve() {
  advance(kInfinity);
  for (Observer* observer : schedule_.observers()) {
    const petsc::LogScope output{petsc::log_events().output};
    observer->finish();
  }
}

void ImpactDynamics::advance(double until) {
  requests_.until = until;
  if (phase_ != Phase::running) {
    start();
  }
  completed_ = stepping_.end_time - time_ <= time_resolution(stepping_.end_time);
  if (!completed_ && until - time_ > time_resolution(time_)) {
    try {
      UDAR_CALL(TSSolve(stepping_.ts, nullptr));
      TSConvergedReason reason = TS_CONVERGED_ITERATING;
      UDAR_CALL(TSGetConvergedReason(stepping_.ts, &reason));
      if (reason < 0) {
        throw SolveError{std::string{"the time integration failed: "} + TSConvergedReasons[reason] +
                         " at t = " + std::to_string(time_) + " s (see -ts_monitor, -ts_adapt_monitor)"};
      }
      completed_ = reason == TS_CONVERGED_TIME;
    } catch (const StoppedBetweenRows&) {
      contact_.undo();
      stepping_.integrator->return_to_start();
    } catch (...) {
      contact_.undo();
      stepping_.integrator->return_to_start();
      throw;
    }
  }
}

RunCounts ImpactDynamics::counts() const {
  RunCounts counts{contact_.counts()};
  counts.steps = steps_;
  const std::map<std::string, PetscInt> all = counted();
  counts.repeated_steps = all.at(kRepeatedSteps);
  counts.rejected_steps = all.at(kRejectedSteps);
  counts.rhs_evaluations = all.at(kEvaluations);
  counts.row_line_solves = all.at(kRowLineSolves);
  counts.line_solves = all.at(kLineSolves);
  counts.setup_line_solves = counters_.setup_line_solves;
  return counts;
}

/// In this program, whatever has been counted before.
std::map<std::string, PetscInt> ImpactDynamics::counted_here() const {
  std::map<std::string, PetscInt> all = stepping_.integrator->tally();
  all.insert({{kRepeatedSteps, stepping_.integrator->repeated_steps()},
              {kRejectedSteps, counters_.rejected_steps},
              {kEvaluations, stepping_.integrator->evaluations()},
              {kRowLineSolves, counters_.row_line_solves},
              {kLineSolves, model_->line.solves()}});
  return all;
}

std::map<std::string, PetscInt> ImpactDynamics::counted() const {
  std::map<std::string, PetscInt> all = counted_here();
  for (auto& [name, count] : all) {
    const auto before = counters_.before.find(name);
    count += before != counters_.before.end() ? before->second : 0;
  }
  return all;
}

std::map<std::string, PetscInt> ImpactDynamics::tally() const {
  std::map<std::string, PetscInt> own = counted();
  const std::map<std::string, PetscInt> integrators = stepping_.integrator->tally();
  std::erase_if(own, [&](const auto& entry) { return !integrators.contains(entry.first); });
  return own;
}

double ImpactDynamics::streamed_bytes() const {
  const ChainSolver* chain = model_->line.chain();
  const double own = stepping_.integrator->streamed_bytes();
  if (own == 0.0 || chain == nullptr) {
    return 0.0;
  }
  const double number = 0.0;
  constexpr double kCorrection = 48.0;  // a node and mode: a dot product with three arrays, an axpy
  const double correction = kCorrection * static_cast<double>(model_->line.corrected_modes().size() * count());
  return own +
         static_cast<double>(model_->line.solves()) * (chain->bytes_per_solve({.displacement = &number}) + correction);
}

MassState ImpactDynamics::masses() const {
  const ReadArray state{state_};
  return {.position = {state.values(), state.values() + count()},
          .velocity = {state.values() + count(), state.values() + 2 * count()}};
}

MotionState ImpactDynamics::save() const {
  MotionState saved;
  MassState now = masses();
  saved.fields["mass_position"] = std::move(now.position);
  saved.fields["mass_velocity"] = std::move(now.velocity);
  saved.integrator = stepping_.name();
  saved.scalars = {{"time", time_},
                   {"last_row_time", last_row_time_},
                   {"wanted_step", wanted_step_},
                   {"steps", static_cast<double>(steps_)}};
  for (const auto& [name, number] : counted()) {
    saved.scalars[kCounted + name] = static_cast<double>(number);
  }
  save_contact(contact_, count(), saved);
  if (const HingedLine* hinges = model_->equations.hinges(); hinges != nullptr) {
    saved.tables[kRotations].assign(hinges->rotations().begin(), hinges->rotations().end());
    saved.tables[kTurned].assign(hinges->turned().begin(), hinges->turned().end());
  }
  balance_.save(saved);
  stepping_.integrator->save(saved);
  for (const Observer* observer : schedule_.observers()) {
    observer->save(saved);
  }
  return saved;
}

/// From another integrator.
void ImpactDynamics::take_over() {
  UDAR_CALL(TSGetTimeStep(stepping_.ts, &wanted_step_));
  LineState line;
  {
    const ReadArray state{state_};
    model_->equations.evaluate(time_, {state.values(), count()}, line);
  }
  stepping_.integrator->take_over(line);
}

void ImpactDynamics::restore(const MotionState& state) {
  const MPI_Comm comm = model_->structure->points().comm();
  state.require_sound(comm, contact_.supports().size());
  {
    const WriteArray now{state_};
    std::ranges::copy(state.field("mass_position", count()), now.values());
    std::ranges::copy(state.field("mass_velocity", count()), now.values() + count());
  }
  time_ = state.scalar("time");
  last_row_time_ = state.scalar("last_row_time");
  wanted_step_ = state.scalar("wanted_step");
  steps_ = static_cast<PetscInt>(state.scalar("steps"));
  if (HingedLine* hinges = model_->equations.hinges(); hinges != nullptr) {
    hinges->restore(state.table(kRotations), state.table(kTurned));
  }
  balance_.restore(state);
  restore_contact(comm, state, count(), contact_);
  UDAR_CALL(TSSetTime(stepping_.ts, time_));
  if (stepping_.goes_on_from(state.integrator)) {
    stepping_.integrator->restore(state);
  } else {
    take_over();
  }
  for (const auto& [name, here] : counted_here()) {
    const auto saved = state.scalars.find(kCounted + name);
    counters_.before[name] = saved != state.scalars.end() ? static_cast<PetscInt>(saved->second) - here : 0;
  }
  counters_.setup_line_solves = model_->line.solves();
  phase_ = Phase::restored;
}

}  // namespace udar
