#include "udar/integrators/ts_modal.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "udar/contact/line_contact.hpp"
#include "udar/integrators/problem_integrator.hpp"
#include "udar/modal/exact_phases.hpp"
#include "udar/modal/modal_model.hpp"
#include "udar/petsc/array.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/log.hpp"

namespace udar {
namespace {

class Modal final : public ProblemIntegrator {
 public:
  [[nodiscard]] Features can() const override { return kModalType.can; }

  void set_from_options(TS /*stepper*/, PetscOptionItems* PetscOptionsObject) override {
    std::array<char, 32> word{"auto"};
    UDAR_CALL(PetscOptionsString("-modal_modes",
                                 "so many of the lowest modes move exactly, rigid motions included, all others follow "
                                 "at rest; auto: as many as the supports ask for",
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

  /// Takes the motion up from the state of the TS.
  void start(const LineState& /*line*/) override {
    ProblemIntegrator::begin_step();
    const petsc::ReadArray state{state_};
    phases_->start(model_->project(begin_, {state.values(), count_}, {state.values() + count_, count_}),
                   model_->drive());
    entered_ = phases_->entered();
  }

  void begin_step() override {
    ProblemIntegrator::begin_step();
    entered_ = phases_->entered();
    impulse_.assign(impulse_.size(), 0.0);
  }

  bool advance() override {
    const double step = enter_step(std::numeric_limits<double>::infinity());
    const std::vector<std::uint8_t> touched = phases_->now().touches;
    motion_.emplace(phases_->phase());
    touches_ = touched;
    const double end = phases_->advance(begin_ + step);
    impulse_.assign(impulse_.size(), 0.0);
    motion_->add_impulses(begin_, end, impulse_);
    {
      const petsc::WriteArray written{state_};
      model_->expand(phases_->now(), {written.values(), count_}, {written.values() + count_, count_});
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

  [[nodiscard]] double line_integral(std::size_t /*node*/, double /*until*/) const override { return 0.0; }

  [[nodiscard]] EnergyFlow flow(double until) const override {
    const ModalState state = state_at(until);
    EnergyFlow flow;
    for (std::size_t i = 0; points_ != nullptr && points_->on_first_rank() && i < state.give.size(); ++i) {
      flow.stored += 0.5 * state.give[i] * state.force[i];
    }
    return flow;
  }

  [[nodiscard]] bool add_impulses(double until, std::span<double> sums) const override {
    if (stepped_ && points_ != nullptr && points_->on_first_rank()) {
      std::vector<double> of_points(model_->reduced().points());
      motion_->add_impulses(begin_, until, of_points);
      for (std::size_t i = 0; i < of_points.size(); ++i) {
        const LinePoint& point = points_->points()[i];
        sums[static_cast<std::size_t>(point.support)] += point.side * of_points[i];
      }
    }
    return true;
  }

  [[nodiscard]] std::map<std::string, PetscInt> tally() const override {
    return {{"contact_changes", static_cast<PetscInt>(phases_ ? phases_->changes() : 0)},
            {"setup_line_solves", static_cast<PetscInt>(model_ ? model_->solves() : 0)},
            {"modes", static_cast<PetscInt>(model_ ? model_->reduced().modes() : 0)}};
  }

  void save(MotionState& state) const override {
    const ModalState& entered = phases_->entered();
    state.scalars["modal_phase_begin"] = entered.time;
    state.tables["modal_amplitude"] = entered.amplitude;
    state.tables["modal_velocity"] = entered.velocity;
    state.tables["modal_touches"].assign(entered.touches.begin(), entered.touches.end());
  }

  void restore(const MotionState& state) override {
    ProblemIntegrator::begin_step();
    ModalState entered{model_->reduced().modes(), model_->reduced().points()};
    entered.time = state.scalar("modal_phase_begin");
    const auto table = [&state](const char* name, std::size_t size) -> const std::vector<double>& {
      const auto found = state.tables.find(name);
      if (found == state.tables.end() || found->second.size() != size) {
        throw InputError{"restart file: it was written with another number of modes or contact points"};
      }
      return found->second;
    };
    entered.amplitude = table("modal_amplitude", entered.amplitude.size());
    entered.velocity = table("modal_velocity", entered.velocity.size());
    std::ranges::transform(table("modal_touches", entered.touches.size()), entered.touches.begin(),
                           [](double touches) { return static_cast<std::uint8_t>(touches != 0.0); });
    phases_->resume(entered, model_->drive(), begin_);
    entered_ = phases_->entered();
  }

 private:
  void prepare() override {
    const BeamChain* const chain = equations_->line().structure().chain();
    if (chain == nullptr) {
      throw InputError{"ts type: modal is not allowed with an imported structure, expected a beam"};
    }
    if (equations_->loads().time_dependent()) {
      throw InputError{"ts type: modal is not allowed with loads that change, expected moreau or a filter frequency"};
    }
    points_ = equations_->line_contact();
    for (const Support& support : contact_->supports()) {
      if (support.restitution != 1.0) {
        throw InputError{"contact restitution: " + std::to_string(support.restitution) +
                         " is not allowed with `ts type` modal, expected 1: what holds the massless line has no law of "
                         "impact"};
      }
      if (support.elastic() && support.damping > 0.0) {
        throw InputError{"support damping: " + std::to_string(support.damping) +
                         " is not allowed with `ts type` modal, expected 0 [N s/m]; choose moreau"};
      }
    }
    const auto count = points_ != nullptr ? points_->points().size() : 0;
    std::vector<double> work;
    std::vector<double> force(count_, 0.0);
    std::ranges::copy(equations_->loads().force(0.0, work), force.begin());
    const auto axis = equations_->axis();
    const std::span<const LinePoint> points = points_ != nullptr ? points_->points() : std::span<const LinePoint>{};
    model_.emplace(*chain, equations_->line().parameters(), force, std::vector<double>{axis.begin(), axis.end()},
                   points, choice_);
    phases_.emplace(model_->reduced());
    impulse_.resize(count);
  }

  void take_back() override { phases_->resume(entered_, model_->drive(), begin_); }

  void within(double elapsed, std::span<double> position, std::span<double> velocity,
              std::span<std::uint8_t> resting) const override {
    model_->expand(state_at(begin_ + elapsed), position, velocity);
    std::ranges::fill(resting, std::uint8_t{0});
    if (points_ == nullptr) {
      return;
    }
    for (const std::size_t i : points_->mine()) {
      resting[points_->local(i)] |= touches_[i];
    }
  }

  /// Before the step is taken, or after it at one of its times.
  [[nodiscard]] ModalState state_at(double time) const {
    ModalState state = phases_->now();
    if (stepped_) {
      motion_->state_at(model_->reduced(), std::min(time, begin_ + length_), state);
    }
    return state;
  }

  void write_journal(double end) {
    if (points_ == nullptr) {
      return;
    }
    const petsc::ReadArray now{state_};
    for (const std::size_t i : points_->mine()) {
      const LinePoint& point = points_->points()[i];
      const std::size_t node = points_->local(i);
      const double gap = point.side * (now.values()[node] - point.height) + phases_->now().give[i];
      contact_->record_gap(phases_->now().touches[i] != 0 ? 0.0 : gap, node, end);
      if (touches_[i] != 0) {
        contact_->journal().record_contact_time(node, {begin_, end});
        contact_->journal().record_force(point.support, point.side * impulse_[i]);
      }
    }
    if (std::ranges::any_of(touches_, [](std::uint8_t touches) { return touches != 0; })) {
      contact_->journal().record_line_contact({begin_, end});
    }
  }

  ModalChoice choice_;
  LineContact* points_ = nullptr;  // null: nothing to touch
  std::optional<ModalModel> model_;
  std::optional<ExactPhases> phases_;
  std::optional<PhaseMotion> motion_;  // of the step at hand
  ModalState entered_{0, 0};           // its phase, to take it back
  std::vector<std::uint8_t> touches_;  // in it
  std::vector<double> impulse_;        // of it, by contact point [N s]
};

}  // namespace

PetscErrorCode register_ts_modal() { return petsc::register_integrator<Modal>(kTsModal); }

}  // namespace udar
