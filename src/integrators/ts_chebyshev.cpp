#include "udar/integrators/ts_chebyshev.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include "udar/integrators/free_motion.hpp"
#include "udar/integrators/problem_integrator.hpp"
#include "udar/numerics/bernstein.hpp"
#include "udar/numerics/roots.hpp"
#include "udar/numerics/step_polynomial.hpp"
#include "udar/petsc/array.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/log.hpp"

namespace udar {
namespace {

constexpr double kNoEvent = std::numeric_limits<double>::infinity();

// Search grid in units of 1 / wf: coarse points tell whether a node comes near its support, and where it does, a
// quintic through fine points is off by less than 1e-10 v / wf (docs/theory.md).
constexpr double kCoarse = 0.5;
constexpr int kFine = 4;
// Terms added at a time while no event is found.
constexpr std::size_t kStage = 3;
constexpr std::size_t kFewestTerms = 4;
constexpr int kNewtonSteps = 20;

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
  }

  bool advance() override {
    const double step = enter_step(fullest_);
    if (line_.stretch.empty()) {
      equations_->evaluate(begin_, {start_, count_}, line_);
    }
    start_motion();
    find_end(step);
    const double end = begin_ + length_;

    next_.position.resize(count_);
    next_.velocity.resize(count_);
    fields(length_, next_.position, next_.velocity);
    check_finite();
    resting_before_ = contact_->resting_supports();
    track_contact();
    LineState line;
    equations_->evaluate({end, begin_}, next_.position, line);
    line_before_ = std::exchange(line_, std::move(line));
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
    {
      const petsc::WriteArray state{state_};
      std::ranges::copy(next_.position, state.values());
      std::ranges::copy(next_.velocity, state.values() + count_);
    }
    leave_step(length_, fullest_);
    return true;
  }

  void view(TS /*stepper*/, PetscViewer viewer) const override {
    UDAR_CALL(PetscViewerASCIIPrintf(viewer, "  Chebyshev series: at most %d terms, %g s a step, error of a step %g\n",
                                     static_cast<int>(terms_max_), fullest_, tolerance_));
    UDAR_CALL(PetscViewerASCIIPrintf(viewer, "  steps %d, terms %d, events located %d\n", static_cast<int>(steps()),
                                     static_cast<int>(terms_), static_cast<int>(located_)));
  }

  void start(const LineState& line) override {
    line_ = line;
    line_.moment.clear();
    begin_step();
  }
  [[nodiscard]] double next_step() const override { return fullest_; }

  [[nodiscard]] double line_integral(std::size_t node, double until) const override {
    if (!stepped_) {
      return 0.0;
    }
    const double time = std::clamp(until - begin_, 0.0, length_);
    const double position = start_[node] * time;
    const FreeMotion::Weights sum = motion_->weights(-1, time);
    if (resting_before_[node] != 0) {
      return position + stretch_integral(node, time, sum);
    }
    const double speed = motion_->at(motion_->weights(1, time), node);
    return position + motion_->at(sum, node) + (speed - start_[count_ + node]) / (wf_ * wf_);
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

  [[nodiscard]] std::map<std::string, PetscInt> tally() const override {
    return {{"terms", terms_}, {"steps_to_events", located_}};
  }
  [[nodiscard]] double streamed_bytes() const override {
    // A term: two recurrences, and its share of two sums. A step: the state copied and written, the motion started.
    constexpr double kTerm = 80.0;
    constexpr double kStep = 112.0;
    return (kTerm * terms_ + kStep * own_steps_) * static_cast<double>(count_);
  }
  void save(MotionState& state) const override { save_line(line_, state); }
  void restore(const MotionState& state) override { start(saved_line(state, count_)); }

 private:
  static constexpr double kTolerance = 1e-14;

  void prepare() override {
    motion_.emplace(equations_->line());
    fullest_ = motion_->reach(static_cast<std::size_t>(terms_max_), tolerance_);
  }
  void take_back() override { line_ = line_before_; }
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
  /// Weights of displacement, velocity and acceleration at one time of the search.
  struct Sample {
    double time;
    std::array<FreeMotion::Weights, 3> weights;
  };

  void start_motion() {
    acceleration_.resize(count_);
    for (std::size_t i = 0; i < count_; ++i) {
      acceleration_[i] = wf_ * wf_ * line_.stretch[i];
    }
    amplitude_ = line_.amplitude;
    const LoadRate& rate = equations_->load_rate(begin_);
    amplitude_rate_ = rate.amplitude;
    jerk_ = rate.stretch;
    for (double& value : jerk_) {
      value *= wf_ * wf_;
    }
    motion_->start({.velocity = {start_ + count_, count_},
                    .acceleration = acceleration_,
                    .jerk = jerk_,
                    .resting = contact_->resting_supports()});
  }

  /// What the terms at hand reach; resting masses lack the last term.
  [[nodiscard]] double reach() const {
    return motion_->reach(motion_->terms() - (contact_->counts().resting > 0 ? 1 : 0), tolerance_);
  }
  [[nodiscard]] std::size_t terms_for(double time) const {
    const auto most = static_cast<std::size_t>(terms_max_);
    const std::size_t spare = contact_->counts().resting > 0 ? 1 : 0;
    std::size_t terms = kFewestTerms;
    while (terms < most && motion_->reach(terms - spare, tolerance_) < time) {
      ++terms;
    }
    return terms;
  }

  /// Adds terms until the first event or `step` is reached; sets the length of the step and its candidates.
  void find_end(double step) {
    const petsc::LogScope contact{petsc::log_events().contact};
    const MPI_Comm comm = equations_->points().comm();
    candidates_.clear();
    const bool supported = !contact_->supports().empty();
    double guess = supported ? guess_event(step) : step;
    if (supported) {
      const petsc::LogScope reduction{petsc::log_events().reduction};
      MPI_Allreduce(MPI_IN_PLACE, &guess, 1, MPI_DOUBLE, MPI_MIN, comm);
    }
    std::size_t terms = terms_for(std::min(guess, step));
    double searched = 0.0;
    for (;;) {
      motion_->extend(terms);
      const bool all = terms >= static_cast<std::size_t>(terms_max_);
      const double horizon = std::min(reach(), step);
      length_ = horizon;
      double event = kNoEvent;
      if (supported) {
        search(searched, horizon);
        for (const Candidate& candidate : candidates_) {
          event = std::min(event, candidate.time);
        }
        const petsc::LogScope reduction{petsc::log_events().reduction};
        MPI_Allreduce(MPI_IN_PLACE, &event, 1, MPI_DOUBLE, MPI_MIN, comm);
      }
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

  /// When a contact node could meet its support if its acceleration stayed: where the search aims first.
  [[nodiscard]] double guess_event(double step) const {
    double first = step;
    for (const ContactSet& set : contact_->sets()) {
      for (std::size_t node = set.first; node < set.last; ++node) {
        const double gap = set.side * (start_[node] - set.height(node));
        const double speed = set.side * start_[count_ + node];
        const double pull = set.side * acceleration_[node];
        if (contact_->resting(node)) {
          continue;
        }
        const double square = speed * speed - 2.0 * pull * gap;
        double time = kNoEvent;
        if (square >= 0.0) {
          const double root = std::sqrt(square);
          if (pull < 0.0) {
            time = (speed + root) / -pull;
          } else if (speed < 0.0) {
            time = 2.0 * std::max(gap, 0.0) / (root - speed);
          }
        }
        if (time > 0.0) {
          first = std::min(first, time * (1.0 + 1e-6));
        }
      }
    }
    return first;
  }

  [[nodiscard]] Sample sample(double time) const {
    return {.time = time, .weights = {motion_->weights(0, time), motion_->weights(1, time), motion_->weights(2, time)}};
  }

  /// Gap, its rate and its second derivative.
  [[nodiscard]] Kinematics gap(const ContactSet& set, std::size_t node, const Sample& at) const {
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
  [[nodiscard]] std::array<double, 2> pressing(const ContactSet& set, std::size_t node, const Sample& at) const {
    const double steady = jerk_.empty() ? 0.0 : jerk_[node] / (wf_ * wf_);
    return {-set.side * (line_.stretch[node] + steady * at.time + motion_->stretch(at.weights[0], node)),
            -set.side * (steady + motion_->stretch(at.weights[1], node))};
  }

  /// Adds the first event of every contact node between two times of the step.
  void search(double from, double to) {
    if (contact_->sets().empty() || to < from) {
      return;
    }
    const auto intervals =
        std::max<std::size_t>(1, static_cast<std::size_t>(std::ceil((to - from) * highest_ / kCoarse)));
    std::vector<Sample> coarse;
    for (std::size_t i = 0; i <= intervals; ++i) {
      coarse.push_back(sample(from + (to - from) * static_cast<double>(i) / static_cast<double>(intervals)));
    }
    std::vector<std::vector<Sample>> fine(intervals);  // made where needed
    for (const ContactSet& set : contact_->sets()) {
      for (std::size_t node = set.first; node < set.last; ++node) {
        if (contact_->resting(node) && !contact_->resting_on(node, set)) {
          continue;
        }
        Kinematics start = gap(set, node, coarse.front());
        for (std::size_t i = 0; i < intervals; ++i) {
          const Kinematics end = gap(set, node, coarse[i + 1]);
          const bool skipped = !near(set, node, start, end, coarse[i + 1].time - coarse[i].time);
          start = end;
          if (skipped) {
            continue;
          }
          if (fine[i].empty()) {
            for (int j = 0; j <= kFine; ++j) {
              const double share = static_cast<double>(j) / kFine;
              fine[i].push_back(sample((1.0 - share) * coarse[i].time + share * coarse[i + 1].time));
            }
          }
          bool found = false;
          for (std::size_t j = 0; j < kFine && !found; ++j) {
            found = closing(set, node, fine[i][j], fine[i][j + 1]);
          }
          if (found) {
            break;
          }
        }
      }
    }
  }

  [[nodiscard]] bool near(const ContactSet& set, std::size_t node, const Kinematics& start, const Kinematics& end,
                          double length) const {
    // An interval resolves the motion: a gap changes by less than twice the larger end speed times its length.
    const double reach = 2.0 * length * std::max(std::abs(start.velocity), std::abs(end.velocity));
    return contact_->resting_on(node, set) || std::min(start.position, end.position) <= reach;
  }

  bool closing(const ContactSet& set, std::size_t node, const Sample& from, const Sample& to) {
    const double length = to.time - from.time;
    if (contact_->resting(node)) {
      const double resolution = contact_->pull_resolution(set.height(node));
      const auto pressing_at = [&](const Sample& at) {
        const auto [value, rate] = pressing(set, node, at);
        return std::array{value + resolution, rate};
      };
      const auto start = pressing_at(from);
      const auto end = pressing_at(to);
      const auto theta = first_closing(cubic_bernstein(start[0], start[1], end[0], end[1], length), 0);
      if (theta) {
        const double time = polished(from.time + *theta * length, from.time, to.time, pressing_at);
        candidates_.push_back({.set = &set, .node = node, .time = time});
      }
      return theta.has_value();
    }
    Kinematics start = gap(set, node, from);
    const Kinematics end = gap(set, node, to);
    int touching = 0;
    if (from.time == 0.0 && start.position <= 0.0 && start.velocity >= 0.0) {
      start.position = 0.0;
      touching = 1;
      if (start.velocity == 0.0) {
        start.acceleration = std::max(start.acceleration, 0.0);  // just released: zero but for round-off
        touching = 2;
      }
    }
    const auto theta = first_closing(StepPolynomial{start, end, length}.bernstein(), touching);
    if (!theta) {
      return false;
    }
    // A root at the start by construction is divided out here, too.
    const double time = polished(from.time + *theta * length, from.time, to.time, [&](const Sample& at) {
      const Kinematics now = gap(set, node, at);
      std::array<double, 2> value{now.position, now.velocity};
      for (int root = 0; root < touching; ++root) {
        value = {value[0] / at.time, (value[1] - value[0] / at.time) / at.time};
      }
      return value;
    });
    candidates_.push_back({.set = &set, .node = node, .time = time});
    return true;
  }

  /// Newton's method for the time at which a falling value is zero, kept between two times.
  template <class Value>
  [[nodiscard]] double polished(double time, double from, double to, const Value& value) const {
    for (int i = 0; i < kNewtonSteps && time > 0.0; ++i) {
      const auto [now, slope] = value(sample(time));
      if (!(slope < 0.0)) {
        break;
      }
      const double next = std::clamp(time - now / slope, from, to);
      const double change = std::abs(next - time);
      time = next;
      if (change <= time_resolution(begin_ + time) || change <= 1e-15 * time) {
        break;
      }
    }
    return time;
  }

  void fields(double time, std::span<double> position, std::span<double> velocity) const {
    motion_->at(motion_->weights(0, time), position);
    motion_->at(motion_->weights(1, time), velocity);
    for (std::size_t i = 0; i < count_; ++i) {
      position[i] += start_[i];
    }
  }

  void check_finite() const {
    double zero = 0.0;  // stays zero unless some value is not finite
    for (std::size_t i = 0; i < count_; ++i) {
      zero += 0.0 * (next_.position[i] + next_.velocity[i]);
    }
    throw_together<SolveError>(equations_->points().comm(), zero == 0.0 ? std::string{} : not_finite().what());
  }

  [[nodiscard]] double stretch_integral(std::size_t node, double time, const FreeMotion::Weights& sum) const {
    const double steady = jerk_.empty() ? 0.0 : jerk_[node] / (wf_ * wf_);
    const double first = acceleration_[node] / (wf_ * wf_);
    return first * time + 0.5 * steady * time * time + motion_->stretch(sum, node);
  }

  /// What corrected modes put into the pull on the masses without the line being there: by sample, then mode.
  [[nodiscard]] std::vector<std::vector<double>> amplitudes_at(const std::vector<Sample>& samples) const {
    std::vector<std::vector<double>> amplitudes;
    for (const Sample& at : samples) {
      auto& now = amplitudes.emplace_back(amplitude_);
      for (std::size_t mode = 0; mode < now.size(); ++mode) {
        now[mode] +=
            (amplitude_rate_.empty() ? 0.0 : amplitude_rate_[mode] * at.time) + motion_->amplitude(at.weights[0], mode);
      }
    }
    return amplitudes;
  }

  /// Distance of the line from a support [m]. @param amplitudes in corrected modes
  [[nodiscard]] double line_distance(const ContactSet& set, std::size_t node, const Sample& at,
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
    const auto intervals =
        std::max<std::size_t>(1, static_cast<std::size_t>(std::ceil(length_ * highest_ * kFine / kCoarse / 2.0)));
    std::vector<Sample> samples;
    for (std::size_t i = 1; i <= intervals; ++i) {
      samples.push_back(sample(length_ * static_cast<double>(i) / static_cast<double>(intervals)));
    }
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
  void track_pressing(const std::vector<Sample>& samples) {
    std::vector<FreeMotion::Weights> sums;  // of the integrals up to each sample
    sums.reserve(samples.size());
    for (const Sample& at : samples) {
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
