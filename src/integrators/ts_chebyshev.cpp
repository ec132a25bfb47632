#include "udar/integrators/ts_chebyshev.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <tuple>
#include <utility>

#include "udar/integrators/free_motion.hpp"
#include "udar/integrators/problem_integrator.hpp"
#include "udar/integrators/series_search.hpp"
#include "udar/integrators/touching_points.hpp"
#include "udar/integrators/yielding_hinges.hpp"
#include "udar/motion/finite.hpp"
#include "udar/numerics/bernstein.hpp"
#include "udar/numerics/roots.hpp"
#include "udar/petsc/array.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/log.hpp"

namespace udar {
namespace {

constexpr double kNoEvent = std::numeric_limits<double>::infinity();

// Terms added at a time while no event is found.
constexpr std::size_t kStage = 3;
constexpr std::size_t kFewestTerms = 4;

class Chebyshev final : public ProblemIntegrator {
 public:
  [[nodiscard]] Features can() const override { return kChebyshevType.can; }

  void set_from_options(TS stepper, PetscOptionItems* PetscOptionsObject) override {
    UDAR_CALL(PetscOptionsInt("-ts_chebyshev_terms_max",
                              "most terms of a step; 16 bytes per node each, two line solves each", "TSCHEBYSHEV",
                              terms_max_, &terms_max_, nullptr));
    constexpr PetscInt kFewest = 6;
    constexpr PetscInt kMost = 400;
    if (terms_max_ < kFewest || terms_max_ > kMost) {
      throw InputError{"ts chebyshev terms max: " + std::to_string(terms_max_) +
                       " is not allowed, expected an integer from 6 to 400"};
    }
    set_default_tolerance(stepper, kTolerance);
    PetscBool step_given = PETSC_FALSE;
    UDAR_CALL(PetscOptionsHasName(nullptr, nullptr, "-ts_dt", &step_given));
    if (step_given == PETSC_FALSE) {
      UDAR_CALL(TSSetTimeStep(stepper, next_step()));
    }
  }

  bool advance() override {
    const double step = enter_step(kNoEvent);
    if (line_.stretch.empty()) {
      equations_->evaluate(begin_, {start_, count_}, line_);
    }
    start_motion();
    find_end(step);
    const double end = begin_ + length_;

    next_.position.resize(count_);
    next_.velocity.resize(count_);
    fields(length_, next_.position, next_.velocity);
    require_finite(*equations_, next_.position, next_.velocity, begin_);
    resting_before_ = contact_->resting_supports();
    track_contact();
    if (hinges_) {
      hinges_->end_step(*motion_, length_);
    }
    LineState line;
    equations_->evaluate({end, begin_}, next_.position, line);
    line_before_ = std::exchange(line_, std::move(line));
    meet_supports(end);
    {
      const petsc::WriteArray state{state_};
      std::ranges::copy(next_.position, state.values());
      std::ranges::copy(next_.velocity, state.values() + count_);
    }
    leave_step(length_, next_step());
    if (points_) {
      points_->write_journal(*motion_, length_);
    }
    contact_->journal().record_flow(flow(end));
    return true;
  }

  void view(TS /*stepper*/, PetscViewer viewer) const override {
    UDAR_CALL(PetscViewerASCIIPrintf(viewer, "  Chebyshev series: at most %d terms, %g s a step, error of a step %g\n",
                                     static_cast<int>(terms_max_), fullest_, tolerance_));
    UDAR_CALL(PetscViewerASCIIPrintf(viewer, "  steps %d, terms %d, events located %d\n", static_cast<int>(steps()),
                                     static_cast<int>(terms_), static_cast<int>(located_)));
  }

  /// Hinges that the line is beyond the bounds of turn at once, before the first row; what that takes is no loss of the
  /// motion.
  void settle() override {
    if (hinges_) {
      double time = 0.0;
      UDAR_CALL(TSGetTime(ts_, &time));
      hinges_->settle(time, state_);
    }
  }
  double follow_loads() override {
    const double lost = hinges_ ? hinges_->settle(begin_, state_) : 0.0;
    contact_->journal().record_flow({.yielded = lost});
    return lost;
  }
  void start(const LineState& line) override {
    take_up(line);
    if (hinges_) {
      hinges_->start(line.time, state_);
    }
    if (points_) {
      const petsc::ReadArray state{state_};
      points_->start(line_, {state.values(), count_}, {state.values() + count_, count_});
    }
  }
  /// A step goes as far as its terms reach, and for ever if the motion is rigid.
  [[nodiscard]] double next_step() const override { return std::numeric_limits<double>::max(); }

  void line_integrals(std::span<const std::size_t> nodes, double until, std::span<double> integrals) const override {
    if (!stepped_) {
      std::ranges::fill(integrals, 0.0);
      return;
    }
    const double time = std::clamp(until - begin_, 0.0, length_);
    const FreeMotion::Weights sum = motion_->weights(-1, time);
    const FreeMotion::Weights speeds = motion_->weights(1, time);
    std::ranges::transform(nodes, integrals.begin(), [&](std::size_t node) {
      const double position = start_[node] * time;
      if (resting_before_[node] != 0) {
        return position + stretch_integral(node, time, sum);
      }
      const double speed = motion_->at(speeds, node);
      return position + motion_->at(sum, node) + (speed - start_[count_ + node]) / (wf_ * wf_);
    });
  }
  void mass_integrals(double until, std::span<double> integrals) const override {
    motion_->integrals({start_, count_}, std::clamp(until - begin_, 0.0, length_), integrals);
  }
  [[nodiscard]] std::vector<double> amplitude_integrals(double until) const override {
    std::vector<double> integrals(equations_->line().corrected_modes().size());
    const double time = stepped_ ? std::clamp(until - begin_, 0.0, length_) : 0.0;
    if (time > 0.0) {
      const FreeMotion::Weights sum = motion_->weights(-1, time);
      for (std::size_t mode = 0; mode < integrals.size(); ++mode) {
        const double steady = amplitude_rate_.empty() ? 0.0 : amplitude_rate_[mode];
        integrals[mode] = amplitude_[mode] * time + 0.5 * steady * time * time + motion_->amplitude(sum, mode);
      }
    }
    return integrals;
  }

  [[nodiscard]] EnergyFlow flow(double until) const override {
    const double time = std::clamp(until - begin_, 0.0, length_);
    return {.yielded = hinges_ && stepped() ? hinges_->lost(*motion_, time) : 0.0};
  }
  [[nodiscard]] std::vector<double> rotations(double time) const override {
    return hinges_ && stepped() ? hinges_->rotations(*motion_, std::clamp(time - begin_, 0.0, length_))
                                : std::vector<double>{};
  }

  [[nodiscard]] std::map<std::string, PetscInt> tally() const override {
    return {{"terms", terms_}, {"steps_to_events", located_}};
  }
  [[nodiscard]] double streamed_bytes() const override {
    // A term: two recurrences, and its share of two sums. A step: the state copied and written, the motion started.
    constexpr double kTerm = 80.0;
    constexpr double kStep = 112.0;
    return (kTerm * terms_ + kStep * own_steps_) * static_cast<double>(count_);
  }
  [[nodiscard]] bool add_impulses(double until, std::span<double> sums) const override {
    if (points_ && stepped_) {
      points_->add_impulses(*motion_, std::clamp(until - begin_, 0.0, length_), sums);
    }
    return points_.has_value();
  }
  void save(MotionState& state) const override {
    save_line(line_, state);
    if (points_) {
      points_->save(state);
    }
    if (hinges_) {
      hinges_->save(state);
    }
  }
  void restore(const MotionState& state) override {
    LineState line = saved_line(state, *equations_, count_);
    if (line.amplitude.size() != equations_->line().corrected_modes().size() ||
        (points_ && line.contact_force.size() != equations_->line_contact()->points().size())) {
      throw InputError{"restart file: the line's amplitudes or contact forces are missing"};
    }
    take_up(line);
    if (points_) {
      points_->restore(state);
    }
    if (hinges_) {
      hinges_->restore(state);
    }
  }

 private:
  static constexpr double kTolerance = 1e-14;

  void prepare() override {
    if (equations_->line_contact() != nullptr) {
      points_.emplace(*equations_, *contact_, scale_);
    }
    if (equations_->hinges() != nullptr) {
      hinges_.emplace(*equations_);
    }
    AlteredLine* const held = points_   ? static_cast<AlteredLine*>(&points_->line())
                              : hinges_ ? &hinges_->line()
                                        : nullptr;
    motion_.emplace(equations_->line(), held);
    fullest_ = motion_->reach(static_cast<std::size_t>(terms_max_), tolerance_);
  }
  void take_up(const LineState& line) {
    line_ = line;
    line_.moment.clear();
    begin_step();
  }
  void take_back() override {
    line_ = line_before_;
    if (points_) {
      points_->take_back();
    }
    if (hinges_) {
      hinges_->take_back();
    }
  }
  void within(double elapsed, std::span<double> position, std::span<double> velocity,
              std::span<std::uint8_t> resting) const override {
    fields(elapsed, position, velocity);
    for (std::size_t i = 0; i < count_; ++i) {
      resting[i] = resting_before_[i] != 0 ? 1 : 0;
    }
  }

  struct Candidate {
    const ContactSet* set;
    std::size_t node;
    double time;  // since the start of the step [s]
  };

  void start_motion() {
    acceleration_.resize(count_);
    for (std::size_t i = 0; i < count_; ++i) {
      acceleration_[i] = wf_ * wf_ * line_.stretch[i];
    }
    amplitude_ = line_.amplitude;
    LoadRate rate = equations_->load_rate(begin_);
    if (points_) {
      points_->begin_step(line_, {start_, count_}, rate);
    }
    if (hinges_) {
      hinges_->begin_step(begin_, {start_, count_}, {start_ + count_, count_}, rate);
    }
    amplitude_rate_ = std::move(rate.amplitude);
    jerk_ = std::move(rate.stretch);
    for (double& value : jerk_) {
      value *= wf_ * wf_;
    }
    motion_->start({.velocity = {start_ + count_, count_},
                    .acceleration = acceleration_,
                    .jerk = jerk_,
                    .resting = contact_->resting_supports()});
  }

  /// Who is on a support at the end of the step.
  void meet_supports(double end) {
    if (points_) {
      points_->end_step(*motion_, length_);
      return;
    }
    std::vector<std::int32_t> due(candidates_.empty() ? 0 : count_, 0);
    for (const Candidate& candidate : candidates_) {
      if (candidate.time <= length_ + 2.0 * time_resolution(end)) {
        due[candidate.node] = candidate.set->support + 1;
      }
    }
    contact_->resolve({.time = end,
                       .due = due,
                       .acceleration = wf_ * wf_,
                       .position = next_.position,
                       .velocity = next_.velocity,
                       .stretch = line_.stretch});
  }

  /// Answers to the line's motion lack the last term.
  [[nodiscard]] std::size_t spare() const { return points_ || contact_->counts().resting > 0 ? 1 : 0; }
  /// What the terms at hand reach.
  [[nodiscard]] double reach() const {
    return motion_->rigid() ? kNoEvent : motion_->reach(motion_->terms() - spare(), tolerance_);
  }
  [[nodiscard]] std::size_t terms_for(double time) const {
    const auto most = static_cast<std::size_t>(terms_max_);
    std::size_t terms = kFewestTerms;
    while (terms < most && motion_->reach(terms - spare(), tolerance_) < time) {
      ++terms;
    }
    return terms;
  }

  /// Asks the line for its answer to the first terms, which tells whether the motion is rigid. @return when an event is
  /// to be expected, at the latest after `step`
  [[nodiscard]] double look_ahead(double step) {
    motion_->answer();
    double guess = step;
    if (points_) {
      guess = points_->any() ? 0.0 : std::min(step, points_->guess(*motion_));  // forces turn: no guess of use
    } else if (!contact_->supports().empty()) {
      guess = guess_event(step);
    }
    if (hinges_) {
      guess = std::min(guess, hinges_->guess(*motion_));
    }
    std::array<double, std::tuple_size_v<FreeMotion::Sizes> + 1> most{-guess};
    FreeMotion::Sizes sizes = motion_->first_sizes();
    std::ranges::copy(sizes, most.begin() + 1);
    const petsc::LogScope reduction{petsc::log_events().reduction};
    MPI_Allreduce(MPI_IN_PLACE, most.data(), static_cast<int>(most.size()), MPI_DOUBLE, MPI_MAX,
                  equations_->points().comm());
    std::copy(most.begin() + 1, most.end(), sizes.begin());
    if (contact_->counts().resting == 0 && !(points_ && points_->any()) && !(hinges_ && hinges_->any())) {
      motion_->end_if_rigid(sizes, step, 0.0);
    }
    return -most[0];
  }

  /// Adds terms until the first event or `step` is reached; sets the length of the step and its candidates.
  void find_end(double step) {
    const petsc::LogScope contact{petsc::log_events().contact};
    candidates_.clear();
    const double guess = look_ahead(step);
    if (!motion_->rigid()) {
      step = std::min(step, fullest_);
    }
    std::size_t terms = terms_for(std::min(guess, step));
    double searched = 0.0;
    for (;;) {
      motion_->extend(terms);
      if (hinges_) {
        motion_->answer();  // steps of a beam that does not yield are those of one that cannot
      }
      const bool all = motion_->rigid() || terms >= static_cast<std::size_t>(terms_max_);
      const double horizon = std::min(reach(), step);
      length_ = horizon;
      const double event = first_event(searched, horizon);
      if (event <= horizon) {
        length_ = std::max(event, 0.0);
        ++located_;
        break;
      }
      if (horizon >= step || all) {
        break;
      }
      searched = horizon;
      terms = std::min(terms + kStage, static_cast<std::size_t>(terms_max_));
    }
    terms_ += static_cast<PetscInt>(motion_->terms());
    ++own_steps_;
  }

  /// Between two times of the step; infinite: none.
  [[nodiscard]] double first_event(double from, double to) {
    if (points_) {
      return points_->search(*motion_, from, to);
    }
    double event = hinges_ ? hinges_->search(*motion_, from, to) : kNoEvent;
    if (contact_->supports().empty()) {
      return event;
    }
    search(from, to);
    for (const Candidate& candidate : candidates_) {
      event = std::min(event, candidate.time);
    }
    const petsc::LogScope reduction{petsc::log_events().reduction};
    MPI_Allreduce(MPI_IN_PLACE, &event, 1, MPI_DOUBLE, MPI_MIN, equations_->points().comm());
    return event;
  }

  /// When a contact node could meet its support if its acceleration stayed: where the search aims first.
  [[nodiscard]] double guess_event(double step) const {
    double first = step;
    for (const ContactSet& set : contact_->sets()) {
      for (std::size_t node = set.first; node < set.last; ++node) {
        if (contact_->resting(node)) {
          continue;
        }
        const double time = guessed_closing({.position = set.side * (start_[node] - set.height(node)),
                                             .velocity = set.side * start_[count_ + node],
                                             .acceleration = set.side * acceleration_[node]});
        if (time > 0.0) {
          first = std::min(first, time * (1.0 + 1e-6));
        }
      }
    }
    return first;
  }

  /// Gap, its rate and its second derivative.
  [[nodiscard]] Kinematics gap(const ContactSet& set, std::size_t node, const SeriesSample& at) const {
    if (at.time == 0.0) {
      return {.position = set.side * (start_[node] - set.height(node)),
              .velocity = set.side * start_[count_ + node],
              .acceleration = set.side * acceleration_[node]};
    }
    return {.position = set.side * (start_[node] - set.height(node) + motion_->at(at.weights[0], node)),
            .velocity = set.side * motion_->at(at.weights[1], node),
            .acceleration = set.side * motion_->at(at.weights[2], node)};
  }

  /// How hard a resting mass presses, as stretch [m], and its rate [m/s]; it stays while that is above minus its
  /// resolution.
  [[nodiscard]] std::array<double, 2> pressing(const ContactSet& set, std::size_t node, const SeriesSample& at) const {
    const double steady = jerk_.empty() ? 0.0 : jerk_[node] / (wf_ * wf_);
    return {-set.side * (line_.stretch[node] + steady * at.time + motion_->stretch(at.weights[0], node)),
            -set.side * (steady + motion_->stretch(at.weights[1], node))};
  }

  /// Adds the first event of every contact node between two times of the step.
  void search(double from, double to) {
    if (contact_->sets().empty() || to < from) {
      return;
    }
    SeriesGrid grid{*motion_, from, to, highest_};
    for (const ContactSet& set : contact_->sets()) {
      for (std::size_t node = set.first; node < set.last; ++node) {
        const bool rests = contact_->resting(node);
        if (rests && !contact_->resting_on(node, set)) {
          continue;
        }
        const std::optional<double> time =
            grid.first([&](const SeriesSample& at) { return gap(set, node, at); },
                       [&](const Kinematics& start, const Kinematics& end, double length) {
                         return rests || comes_near(start, end, length);
                       },
                       [&](const SeriesSample& start, const SeriesSample& end) {
                         return rests ? lifting(set, node, start, end) : closing(set, node, start, end);
                       });
        if (time) {
          candidates_.push_back({.set = &set, .node = node, .time = *time});
        }
      }
    }
  }

  [[nodiscard]] std::optional<double> lifting(const ContactSet& set, std::size_t node, const SeriesSample& from,
                                              const SeriesSample& to) const {
    const double length = to.time - from.time;
    const double resolution = contact_->pull_resolution(set.height(node));
    const auto pressing_at = [&](const SeriesSample& at) {
      const auto [value, rate] = pressing(set, node, at);
      return std::array{value + resolution, rate};
    };
    const auto start = pressing_at(from);
    const auto end = pressing_at(to);
    const auto theta = first_closing(cubic_bernstein(start[0], start[1], end[0], end[1], length), 0);
    if (!theta) {
      return std::nullopt;
    }
    return polished(*motion_, from.time + *theta * length, from.time, to.time, time_resolution(begin_ + to.time),
                    pressing_at);
  }

  [[nodiscard]] std::optional<double> closing(const ContactSet& set, std::size_t node, const SeriesSample& from,
                                              const SeriesSample& to) const {
    return first_closing(*motion_, from, to, time_resolution(begin_ + to.time),
                         [&](const SeriesSample& at) { return gap(set, node, at); });
  }

  void fields(double time, std::span<double> position, std::span<double> velocity) const {
    motion_->at(motion_->weights(0, time), position);
    motion_->at(motion_->weights(1, time), velocity);
    for (std::size_t i = 0; i < count_; ++i) {
      position[i] += start_[i];
    }
  }

  [[nodiscard]] double stretch_integral(std::size_t node, double time, const FreeMotion::Weights& sum) const {
    const double steady = jerk_.empty() ? 0.0 : jerk_[node] / (wf_ * wf_);
    const double first = acceleration_[node] / (wf_ * wf_);
    return first * time + 0.5 * steady * time * time + motion_->stretch(sum, node);
  }

  /// What corrected modes put into the pull on the masses without the line being there: by sample, then mode.
  [[nodiscard]] std::vector<std::vector<double>> amplitudes_at(const std::vector<SeriesSample>& samples) const {
    std::vector<std::vector<double>> amplitudes;
    for (const SeriesSample& at : samples) {
      auto& now = amplitudes.emplace_back(amplitude_);
      for (std::size_t mode = 0; mode < now.size(); ++mode) {
        now[mode] +=
            (amplitude_rate_.empty() ? 0.0 : amplitude_rate_[mode] * at.time) + motion_->amplitude(at.weights[0], mode);
      }
    }
    return amplitudes;
  }

  /// Distance of the line from a support [m]. @param amplitudes in corrected modes
  [[nodiscard]] double line_distance(const ContactSet& set, std::size_t node, const SeriesSample& at,
                                     const std::vector<double>& amplitudes) const {
    double line = 0.0;
    if (contact_->resting(node)) {
      line = set.side * (start_[node] - set.height(node)) -
             (contact_->resting_on(node, set) ? pressing(set, node, at)[0] : 0.0);
    } else {
      const Kinematics now = gap(set, node, at);
      line = now.position + now.acceleration / (wf_ * wf_);
    }
    const auto& corrected = equations_->line().corrected_modes();
    for (std::size_t mode = 0; mode < corrected.size(); ++mode) {
      line -= set.side * amplitudes[mode] * corrected[mode].shape[node];
    }
    return line;
  }

  /// Smallest distance of the line at the contact nodes, and what resting masses pressed.
  void track_contact() {
    if (contact_->sets().empty()) {
      return;
    }
    constexpr double kDensity = kFine / kCoarse / 2.0;
    std::vector<SeriesSample> samples =
        samples_between(*motion_, 0.0, length_, parts_of(*motion_, length_, kDensity * highest_));
    samples.erase(samples.begin());
    const std::vector<std::vector<double>> amplitudes = amplitudes_at(samples);
    for (const ContactSet& set : contact_->sets()) {
      for (std::size_t node = set.first; node < set.last; ++node) {
        for (std::size_t s = 0; s < samples.size(); ++s) {
          contact_->record_gap(line_distance(set, node, samples[s], amplitudes[s]), node, begin_ + samples[s].time);
        }
      }
    }
    if (contact_->any_resting()) {
      track_pressing(samples);
    }
  }

  /// What resting masses pressed, by intervals: a step may be much longer than what a force is averaged over.
  void track_pressing(const std::vector<SeriesSample>& samples) {
    std::vector<FreeMotion::Weights> sums;  // of the integrals up to each sample
    sums.reserve(samples.size());
    for (const SeriesSample& at : samples) {
      sums.push_back(motion_->weights(-1, at.time));
    }
    for (const ContactSet& set : contact_->sets()) {
      std::vector<double> pressed(samples.size());
      bool presses = false;
      for (std::size_t node = set.first; node < set.last; ++node) {
        if (!contact_->resting_on(node, set)) {
          continue;
        }
        presses = true;
        const double stiffness = wf_ * wf_ * equations_->line().mass()[node];
        double before = 0.0;
        for (std::size_t i = 0; i < samples.size(); ++i) {
          const double stretch = stretch_integral(node, samples[i].time, sums[i]);
          pressed[i] -= stiffness * (stretch - before);
          before = stretch;
        }
      }
      for (std::size_t i = 0; i < samples.size() && presses; ++i) {
        contact_->journal().record_force(set.support, pressed[i],
                                         {begin_ + (i > 0 ? samples[i - 1].time : 0.0), begin_ + samples[i].time});
      }
    }
  }

  /// Whether there is a step whose motion is known.
  [[nodiscard]] bool stepped() const { return length_ > 0.0 && motion_->terms() > 0; }

  std::optional<TouchingPoints> points_;  // where supports hold the line
  std::optional<YieldingHinges> hinges_;  // where the line may yield
  PetscInt terms_max_ = 20;
  double fullest_ = 0.0;  // longest step [s]
  std::optional<FreeMotion> motion_;
  LineState line_;  // at the start of the next step
  LineState line_before_;
  std::vector<double> acceleration_;
  std::vector<double> jerk_;
  std::vector<double> amplitude_;       // of the stretch in corrected modes at the start of the step at hand
  std::vector<double> amplitude_rate_;  // what changing loads add
  MassState next_;
  std::vector<std::int32_t> resting_before_;
  std::vector<Candidate> candidates_;
  PetscInt own_steps_ = 0;
  PetscInt terms_ = 0;
  PetscInt located_ = 0;
};

}  // namespace

PetscErrorCode register_ts_chebyshev() { return petsc::register_integrator<Chebyshev>(kTsChebyshev); }

}  // namespace udar
