#include "udar/integrators/ts_modal.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "udar/contact/line_contact.hpp"
#include "udar/integrators/problem_integrator.hpp"
#include "udar/modal/exact_phases.hpp"
#include "udar/modal/kernel_steps.hpp"
#include "udar/modal/modal_model.hpp"
#include "udar/petsc/array.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/log.hpp"

namespace udar {
namespace {

// The retardation of the rest over rigid supports, where the waves of a touch run on for ever (docs/theory.md).
constexpr double kRadiating = 0.07;

class Modal final : public ProblemIntegrator {
 public:
  [[nodiscard]] Features can() const override { return kModalType.can; }

  void set_from_options(TS stepper, PetscOptionItems* PetscOptionsObject) override {
    constexpr double kTolerance = 1e-4;  // of the energy (docs/theory.md)
    set_default_tolerance(stepper, kTolerance);
    PetscReal retardation = kRadiating;
    PetscBool given = PETSC_FALSE;
    UDAR_CALL(PetscOptionsReal("-modal_retardation",
                               "alpha: what is left out follows forces by alpha / w_k late, and so takes the energy "
                               "that the beam radiates into it; 0: at once; default only where a support is rigid",
                               "TSMODAL", retardation, &retardation, &given));
    constexpr double kMostRetardation = 1.0;
    if (!(retardation >= 0.0 && retardation <= kMostRetardation)) {
      throw InputError{"modal retardation: " + std::to_string(retardation) +
                       " is not allowed, expected a number from 0 to 1"};
    }
    if (given == PETSC_TRUE) {
      retardation_ = retardation;
    }
    std::array<char, 32> word{"auto"};
    UDAR_CALL(PetscOptionsString("-modal_modes",
                                 "so many of the lowest modes move exactly, rigid motions included, more where several "
                                 "share the last frequency; all others follow at rest; auto: as many as the supports "
                                 "ask for",
                                 "TSMODAL", word.data(), word.data(), word.size(), nullptr));
    if (std::string_view{word.data()} == "auto") {
      choice_.modes = 0;
      return;
    }
    PetscInt modes = 0;
    const PetscErrorCode unread = PetscOptionsStringToInt(word.data(), &modes);
    constexpr PetscInt kMost = 1000;
    if (unread != 0 || modes < 1 || modes > kMost) {
      throw InputError{std::string{"modal modes: '"} + word.data() +
                       "' is not allowed, expected auto or an integer from 1 to 1000"};
    }
    choice_.modes = modes;
  }

  /// Takes the motion up from the state of the TS. Supports that press from the start, and loads on the rest, move the
  /// line at once.
  void settle() override {
    ProblemIntegrator::begin_step();
    {
      const petsc::ReadArray state{state_};
      motion_->start(model_->project(begin_, {state.values(), count_}, {state.values() + count_, count_}),
                     model_->drive());
    }
    std::vector<double> position(count_);
    std::vector<double> velocity(count_);
    model_->expand(motion_->now(), position, velocity);
    constexpr double kRounding = 1e-12;  // of the motion: what tens of modes add up to
    if (distance_of_masses(position) > kRounding * scale_.length) {
      const petsc::WriteArray state{state_};
      std::ranges::copy(position, state.values());
      std::ranges::copy(velocity, state.values() + count_);
    }
  }

  /// The modes move on by themselves.
  void start(const LineState& /*line*/) override { ProblemIntegrator::begin_step(); }

  void begin_step() override {
    ProblemIntegrator::begin_step();
    if (begin_ >= next_kink_ - time_resolution(begin_) && !equations_->loads().jumps_at(begin_)) {
      turn(false);
    }
  }

  double follow_loads() override {
    const double before = stored(motion_->now());
    turn(true);
    const petsc::WriteArray written{state_};
    model_->expand(motion_->now(), {written.values(), count_}, {written.values() + count_, count_});
    return equations_->points().owns(0) ? stored(motion_->now()) - before : 0.0;
  }

  bool advance() override {
    const double step = enter_step(std::numeric_limits<double>::infinity());
    const double end = motion_->advance(begin_ + step);
    {
      const petsc::WriteArray written{state_};
      model_->expand(motion_->at(end), {written.values(), count_}, {written.values() + count_, count_});
    }
    leave_step(end - begin_, std::numeric_limits<double>::max());
    write_journal(end);
    return true;
  }

  void view(TS /*stepper*/, PetscViewer viewer) const override {
    if (!model_) {
      return;
    }
    UDAR_CALL(PetscViewerASCIIPrintf(
        viewer, "  modal: %d modes up to %g rad/s, with contact at most %g rad/s, %d contact points, %d line solves\n",
        static_cast<int>(model_->reduced().modes()), model_->reduced().frequency.back(), model_->frequency_bound(),
        static_cast<int>(model_->reduced().points()), static_cast<int>(model_->solves())));
  }

  [[nodiscard]] double next_step() const override { return std::numeric_limits<double>::max(); }

  void line_integrals(std::span<const std::size_t> nodes, double until, std::span<double> integrals) const override {
    const ModalFlow flow = motion_->flow(until);
    std::ranges::transform(nodes, integrals.begin(), [&](std::size_t node) {
      return model_->passed(node, begin_, until, flow.amplitude, flow.rest_force);
    });
  }

  [[nodiscard]] EnergyFlow flow(double until) const override {
    if (!equations_->points().owns(0)) {
      return {};
    }
    const ModalFlow passed = stepped_ ? motion_->flow(until) : ModalFlow{0, 0};
    return {.work = passed.support_work,
            .damped = passed.in_supports + passed.in_modes,
            .radiated = passed.radiated,
            .stored = stored(state_at(until))};
  }

  [[nodiscard]] bool add_impulses(double until, std::span<double> sums) const override {
    if (stepped_ && equations_->points().owns(0)) {
      const ModalFlow passed = motion_->flow(until);
      for (std::size_t i = 0; i < points_.size(); ++i) {
        sums[static_cast<std::size_t>(points_[i].support)] += points_[i].side * passed.impulse[i];
      }
    }
    return true;
  }

  [[nodiscard]] std::map<std::string, PetscInt> tally() const override {
    return {{exact_ ? "contact_changes" : "modal_steps", static_cast<PetscInt>(motion_ ? motion_->count() : 0)},
            {"setup_line_solves", static_cast<PetscInt>(model_ ? model_->solves() : 0)},
            {"modes", static_cast<PetscInt>(model_ ? model_->reduced().modes() : 0)}};
  }

  void save(MotionState& state) const override {
    const ModalMemory memory = motion_->memory();
    state.scalars["modal_begin"] = memory.entered.time;
    state.scalars["modal_level"] = memory.level;
    state.scalars["modal_largest_energy"] = memory.largest_energy;
    each_table(memory.entered, [&state](const char* name, const auto& values) {
      state.tables[name].assign(values.begin(), values.end());
    });
  }

  void restore(const MotionState& state) override {
    ProblemIntegrator::begin_step();
    ModalMemory memory{.entered = {model_->reduced().modes(), model_->reduced().points()},
                       .level = state.scalar("modal_level"),
                       .largest_energy = state.scalar("modal_largest_energy")};
    memory.entered.time = state.scalar("modal_begin");
    each_table(memory.entered, [&state](const char* name, auto& values) {
      const auto found = state.tables.find(name);
      if (found == state.tables.end() || found->second.size() != values.size()) {
        throw InputError{"restart file: it was written with another number of modes or contact points"};
      }
      std::ranges::copy(found->second, values.begin());
    });
    drive_from(begin_);
    motion_->resume(memory, model_->drive(), begin_);
    std::vector<double> position(count_);
    std::vector<double> velocity(count_);
    model_->expand(motion_->now(), position, velocity);
    constexpr double kSame = 1e-6;  // of the motion: what modes found on other ranks differ by is far below
    if (!(distance_of_masses(position) <= kSame * scale_.length)) {
      throw InputError{
          "restart file: its modes are not those of this run, which puts masses elsewhere; run on as many ranks as the "
          "run that wrote it"};
    }
  }

 private:
  void prepare() override {
    bool rigid = false;
    for (const Support& support : contact_->supports()) {
      rigid = rigid || !support.elastic();
      if (support.restitution != 1.0) {
        throw InputError{"contact restitution: " + std::to_string(support.restitution) +
                         " is not allowed with `ts type` modal, expected 1: what holds the massless line has no law of "
                         "impact"};
      }
    }
    points_ = line_points(equations_->points(), *contacts_);
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (equations_->points().owns(points_[i].node)) {
        mine_.push_back(i);
      }
    }
    kinks_.emplace(equations_->loads(), contact_->supports());
    choice_.retardation = retardation_.value_or(rigid ? kRadiating : 0.0);
    choice_.damping_ratio = equations_->damping_ratio();
    const auto axis = equations_->axis();
    model_.emplace(equations_->line().structure(), equations_->line().parameters(), equations_->loads(),
                   std::vector<double>{axis.begin(), axis.end()}, points_, choice_);
    const ReducedModel& reduced = model_->reduced();
    drive_from(0.0);
    exact_ = reduced.conservative() && reduced.points() <= ExactPhases::kMostPoints && model_->drive().retreat.empty();
    if (exact_) {
      motion_ = std::make_unique<ExactPhases>(reduced);
    } else {
      motion_ = std::make_unique<KernelSteps>(reduced, tolerance_);
    }
  }

  void take_back() override { motion_->take_back(); }

  /// The furthest that masses are from given places [m]. @note Collective.
  [[nodiscard]] double distance_of_masses(std::span<const double> position) const {
    const petsc::ReadArray state{state_};
    double furthest = 0.0;
    for (std::size_t i = 0; i < count_; ++i) {
      furthest = std::max(furthest, std::abs(position[i] - state.values()[i]));
    }
    MPI_Allreduce(MPI_IN_PLACE, &furthest, 1, MPI_DOUBLE, MPI_MAX, equations_->points().comm());
    return furthest;
  }

  /// Loads and supports as they go on from the last kink before a time.
  void drive_from(double time) {
    const double just_after = time + 3.0 * time_resolution(time);
    model_->drive_from(kinks_->piece_begin(0.0, just_after));
    next_kink_ = kinks_->after(time);
  }

  void turn(bool jump) {
    drive_from(begin_);
    motion_->turn(model_->drive(), jump);
  }

  void within(double elapsed, std::span<double> position, std::span<double> velocity,
              std::span<std::uint8_t> resting) const override {
    const ModalState state = state_at(begin_ + elapsed);
    model_->expand(state, position, velocity);
    std::ranges::fill(resting, std::uint8_t{0});
    for (const std::size_t i : mine_) {
      resting[local(i)] |= state.touches[i];
    }
  }

  /// Before the step is taken, or after it at one of its times.
  [[nodiscard]] ModalState state_at(double time) const {
    return stepped_ ? motion_->at(std::min(time, begin_ + length_)) : motion_->now();
  }

  [[nodiscard]] std::size_t local(std::size_t point) const {
    return static_cast<std::size_t>(points_[point].node - equations_->points().begin());
  }

  /// In the springs of supports [J].
  [[nodiscard]] double stored(const ModalState& state) const {
    return modal_energy(model_->reduced(), model_->drive(), state).springs;
  }

  /// What a restart keeps of a state.
  template <class State, class Visit>
  static void each_table(State& state, const Visit& visit) {
    visit("modal_amplitude", state.amplitude);
    visit("modal_velocity", state.velocity);
    visit("modal_force", state.force);
    visit("modal_rest_force", state.rest_force);
    visit("modal_give", state.give);
    visit("modal_touches", state.touches);
  }

  void write_journal(double end) {
    ContactJournal& journal = contact_->journal();
    const ModalState state = motion_->at(end);
    const ModalFlow passed = motion_->flow(end);
    const petsc::ReadArray now{state_};
    for (const std::size_t i : mine_) {
      const LinePoint& point = points_[i];
      const double face = point.height + point.lift(end).height;
      const double gap = point.side * (now.values()[local(i)] - face);
      contact_->record_gap(state.touches[i] != 0 ? -state.give[i] : gap, local(i), end);
      journal.record_force(point.support, point.side * passed.impulse[i]);
    }
    for (const ModalContact& contact : motion_->contacts()) {
      const ContactJournal::Interval time{contact.from, contact.until};
      if (equations_->points().owns(points_[contact.point].node)) {
        journal.record_contact_time(local(contact.point), time);
      }
      journal.record_line_contact(time);
    }
    record_sags(end);
    if (equations_->points().owns(0)) {
      journal.record_flow(
          {.work = passed.support_work, .damped = passed.in_supports + passed.in_modes, .radiated = passed.radiated});
    }
  }

  /// How deep springs are pressed within the step.
  void record_sags(double end) {
    constexpr int kSamples = 16;
    if (std::ranges::all_of(points_, [](const LinePoint& point) { return point.compliance == 0.0; })) {
      return;
    }
    for (int k = 1; k < kSamples; ++k) {
      const double time = begin_ + (end - begin_) * k / kSamples;
      const ModalState state = motion_->at(time);
      for (const std::size_t i : mine_) {
        if (state.touches[i] != 0) {
          contact_->record_gap(-state.give[i], local(i), time);
        }
      }
    }
  }

  ModalChoice choice_;
  std::optional<double> retardation_;  // none: by the supports
  std::vector<LinePoint> points_;      // of all ranks
  std::vector<std::size_t> mine_;      // on this rank's nodes
  std::optional<Kinks> kinks_;
  double next_kink_ = 0.0;
  std::optional<ModalModel> model_;
  bool exact_ = false;
  std::unique_ptr<ModalMotion> motion_;
};

}  // namespace

PetscErrorCode register_ts_modal() { return petsc::register_integrator<Modal>(kTsModal); }

}  // namespace udar
