#include "udar/dynamics/ts_impact.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "udar/dynamics/line_forces.hpp"
#include "udar/dynamics/problem_stepper.hpp"
#include "udar/dynamics/step_maps.hpp"
#include "udar/dynamics/sweep.hpp"
#include "udar/dynamics/sweep_tally.hpp"
#include "udar/dynamics/touching_masses.hpp"
#include "udar/petsc/array.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/session.hpp"

namespace udar {
namespace {

using local::kMostTerms;
using petsc::ReadArray;

// The line's answer to a change of the masses, in units of that change: near 1 for low modes, which dominate, near 0
// for high ones. The sweep is exact for this share of it.
constexpr double kLineShare = 0.8;
// Sweeps are over when what they still change is this share of the tolerance.
constexpr double kSettled = 0.05;
constexpr int kMostSweeps = 12;
// The last bits of places, some three of them in what a solve makes of them, must stay below that share of this.
constexpr double kLastBits = 64.0 * std::numeric_limits<double>::epsilon();
// A sweep that gains less than this after some has met masses whose impacts come and go: a shorter step settles.
constexpr double kLeastGain = 0.9;
constexpr int kPatience = 4;
// A step that sweeps slowly is too long.
constexpr double kLongestAngle = 1.5;
// A failed step is cut at an impact that holds this share of all momentum exchanged in it.
constexpr double kHeavy = 0.3;
// ... unless it already lies at a border of the step.
constexpr double kShortestCut = 0.02;
constexpr double kLongestCut = 0.999;

class Impact final : public ProblemStepper {
 public:
  void set_from_options(TS stepper, PetscOptionItems* PetscOptionsObject) override {
    UDAR_CALL(PetscOptionsInt("-ts_impact_moments",
                              "Legendre terms of the line's motion over a step; line solves a sweep; 5 by default on "
                              "-contact_surface line",
                              "TSIMPACT", moments_, &moments_, &moments_given_));
    if (moments_ < 2 || moments_ > static_cast<PetscInt>(kMostTerms)) {
      throw InputError{"option -ts_impact_moments: " + std::to_string(moments_) +
                       " is not allowed, expected an integer from 2 to 5"};
    }
    set_default_tolerance(stepper, kTolerance);
  }

  void start(const LineState& line) override {
    // The line's motion is first taken to go on as the masses do.
    UDAR_CALL(TSGetTimeStep(ts_, &polynomial_step_));
    polynomial_step_ = std::min(polynomial_step_, longest_);
    const ReadArray now{state_};
    for (std::size_t i = 0; i < count_; ++i) {
      const double half = contact_->resting(i) ? 0.0 : -0.5 * polynomial_step_ * now.values()[count_ + i];
      sweep_.line_rows[0][i] = line.stretch[i] + half;  // seen as the step that ends here
      sweep_.line_rows[1][i] = -half;
      for (std::size_t j = 2; j < sweep_.terms; ++j) {
        sweep_.line_rows[j][i] = 0.0;
      }
    }
    from_end_ = true;
    ProblemStepper::begin_step();
  }

  /// After a step the line's motion counts from the new positions.
  void begin_step() override {
    if (stepped_) {
      polynomial_step_ = length_;
      from_end_ = true;
      for (std::size_t i = 0; i < count_; ++i) {
        sweep_.line_rows[0][i] -= sweep_.end[i] - start_[i];
      }
      touching_->release_memory();
    }
    ProblemStepper::begin_step();
  }

  bool advance() override {
    double step = enter_step(longest_);
    note_scale();
    bool accepted = false;
    double next = step;
    for (int attempt = 0; !accepted; ++attempt) {
      if (attempt > kMostAttempts) {
        return false;
      }
      const bool settled = settle(step);
      if (settled) {
        const petsc::Judgement judged = petsc::judge_step(ts_, step);
        accepted = judged.accepted;
        next = judged.next_step;
      } else {
        next = 0.5 * step;
      }
      if (!accepted) {
        petsc::count_rejection(ts_);
        const double cut = settled ? heavy_impact() * step : 0.0;
        if (cut > kShortestCut * step && cut < kLongestCut * step) {
          next = cut;
          ++cuts_;
        }
        step = next;
      }
    }
    next_step_ = std::min(next, longest_);
    ++own_steps_;
    leave_step(step, next_step_);
    const petsc::LogScope contact{petsc::log_events().contact};
    touching_->write_journal();
    if (sweep_.damped()) {
      contact_->flow({.damped = dragged(1.0)});
    }
    if (line_forces_) {
      line_forces_->write_journal();
    }
    touching_->track_line();
    return true;
  }

  [[nodiscard]] Error error() const override { return {.norm = error_, .order = static_cast<int>(sweep_.terms)}; }

  void view(TS stepper, PetscViewer viewer) const override {
    UDAR_CALL(PetscViewerASCIIPrintf(viewer, "  impact integrator: %d moments, longest step %g s, error of a step %g\n",
                                     static_cast<int>(moments_), longest_, tolerance_));
    PetscInt rejected = 0;
    UDAR_CALL(TSGetStepRejections(stepper, &rejected));
    UDAR_CALL(PetscViewerASCIIPrintf(viewer, "  steps %d, sweeps %d, rejected %d, cut at impacts %d\n",
                                     static_cast<int>(steps()), static_cast<int>(sweeps_), static_cast<int>(rejected),
                                     static_cast<int>(cuts_)));
  }

  [[nodiscard]] double next_step() const override { return next_step_; }

  [[nodiscard]] double line_integral(std::size_t node, double until) const override {
    if (!stepped_) {
      return 0.0;
    }
    const double tau = std::clamp((until - begin_) / length_, 0.0, 1.0);
    const auto powers = sweep_.line_powers(node);
    double sum = 0.0;
    for (std::size_t k = sweep_.terms; k-- > 0;) {
      sum = sum * tau + powers[k] / static_cast<double>(k + 1);
    }
    return length_ * tau * (start_[node] + sum);
  }
  [[nodiscard]] std::vector<double> amplitude_integrals(double until) const override {
    std::vector<double> integrals(sweep_.corrected.size());
    const double tau = stepped_ ? std::clamp((until - begin_) / length_, 0.0, 1.0) : 0.0;
    for (std::size_t mode = 0; mode < integrals.size(); ++mode) {
      const auto powers = sweep_.powers([&](std::size_t j) { return sweep_.amplitude[mode][j]; });
      for (std::size_t k = sweep_.terms; k-- > 0;) {
        integrals[mode] = integrals[mode] * tau + powers[k] / static_cast<double>(k + 1);
      }
      integrals[mode] *= length_ * tau;
    }
    return integrals;
  }

  [[nodiscard]] EnergyFlow flow(double until) const override {
    if (!stepped_) {
      return {};
    }
    const double tau = std::clamp((until - begin_) / length_, 0.0, 1.0);
    EnergyFlow flow = touching_->flow(tau);
    flow.damped += sweep_.damped() ? dragged(tau) : 0.0;
    flow.work += line_forces_ ? line_forces_->flow(tau).work : 0.0;
    return flow;
  }

  [[nodiscard]] std::map<std::string, PetscInt> tally() const override {
    return {{"sweeps", sweeps_}, {"steps_cut_at_impacts", cuts_}};
  }
  [[nodiscard]] double streamed_bytes() const override {
    const auto m = static_cast<double>(sweep_.terms);
    std::size_t contact_nodes = 0;
    for (const ContactRun& run : contact_->runs()) {
      contact_nodes += run.last - run.first;
    }
    // A sweep: moments and line read and written; steady part, position, velocity, axis read; ends written. To
    // predict: the line twice, moments written. A step: the state copied, its size, the line counted anew.
    const double per_node = 8.0 * ((4.0 * m + 6.0) * sweeps_ + (4.0 * m + 3.0) * attempts_ + 11.0 * own_steps_);
    // Who rests, and the line's distance at the end.
    const double per_contact_node = 4.0 * (sweeps_ + attempts_) + 8.0 * (m + 1.0) * own_steps_;
    return per_node * static_cast<double>(count_) + per_contact_node * static_cast<double>(contact_nodes);
  }
  void save(MotionState& state) const override {
    for (std::size_t j = 0; j < sweep_.terms; ++j) {
      state.fields["line_" + std::to_string(j)] = sweep_.line_rows[j];
    }
    state.scalars["line_step"] = polynomial_step_;
    state.scalars["next_step"] = next_step_;
    state.scalars["scale_length"] = scale_.length;
    state.scalars["scale_velocity"] = scale_.velocity;
  }
  void restore(const MotionState& state) override {
    for (std::size_t j = 0; j < sweep_.terms; ++j) {
      sweep_.line_rows[j] = state.field("line_" + std::to_string(j), count_);
    }
    polynomial_step_ = state.scalar("line_step");
    next_step_ = state.scalar("next_step");
    scale_ = {.length = state.scalar("scale_length"), .velocity = state.scalar("scale_velocity")};
    from_end_ = true;
    ProblemStepper::begin_step();
  }

 private:
  static constexpr double kTolerance = 1e-7;
  static constexpr int kMostAttempts = 100;

  void prepare() override {
    TSAdapt adapt = nullptr;
    double least = 0.0;
    double most = 0.0;
    UDAR_CALL(TSGetAdapt(ts_, &adapt));
    UDAR_CALL(TSAdaptGetStepLimits(adapt, &least, &most));
    if (moments_given_ == PETSC_FALSE && equations_->line_contact() != nullptr) {
      moments_ = 5;  // as few solves as 4 there, and ten times less error within a step (docs/verification.md)
    }
    sweep_.terms = static_cast<std::size_t>(moments_);
    kink_integral_ = kink_integral(sweep_.terms);
    sweep_.drag = equations_->damping().mass;
    sweep_.line_damping = equations_->damping().stiffness;
    sweep_.frequency = wf_;
    longest_ = std::min(most, kLongestAngle / (highest_ + sweep_.drag + sweep_.line_drag()));
    for (std::size_t j = 0; j < sweep_.terms; ++j) {
      sweep_.moment_rows[j].assign(count_, 0.0);
      sweep_.line_rows[j].assign(count_, 0.0);
    }
    sweep_.steady[0].assign(count_, 0.0);
    sweep_.steady[1].assign(equations_->loads().time_dependent() ? count_ : 0, 0.0);
    sweep_.corrected = equations_->line().corrected_modes();
    sweep_.amplitude.resize(sweep_.corrected.size());
    steady_amplitude_.resize(sweep_.corrected.size());
    sweep_.all_free.fill(1.0);
    sweep_.count = count_;
    sweep_.frequency = wf_;
    sweep_.start = start_;
    sweep_.end = petsc::WriteArray{state_}.values();  // stays where it is, too
    sweep_.axis = equations_->axis();
    sweep_.mass = equations_->line().mass();
    touching_.emplace(sweep_, *contact_, equations_->beam());
    if (equations_->line_contact() != nullptr) {
      line_forces_.emplace(sweep_, *equations_->line_contact(), *contact_);
    }
  }
  void take_back() override { from_end_ = false; }  // the polynomial is that of the step taken back
  void within(double elapsed, std::span<double> position, std::span<double> velocity,
              std::span<std::uint8_t> resting) const override {
    const double tau = elapsed / length_;
    const DenseMap map = dense_map(scale_of(length_), sweep_.terms, tau);
    for (std::size_t i = 0; i < count_; ++i) {
      double place = map.place_of_start * start_[count_ + i] * length_;
      double speed = map.speed_of_start * start_[count_ + i] * length_;
      for (std::size_t j = 0; j < sweep_.terms; ++j) {
        place += map.place[j] * sweep_.line_rows[j][i];
        speed += map.speed[j] * sweep_.line_rows[j][i];
      }
      position[i] = start_[i] + place;
      velocity[i] = speed / length_;
      resting[i] = 0;
    }
    touching_->at(tau, position, velocity, resting);
  }

  [[nodiscard]] StepScale scale_of(double step) const {
    return {.angle = wf_ * step, .drag = sweep_.drag * step, .line_drag = sweep_.line_drag() * step};
  }

  /// What damping of the structure took of the masses that touched nothing, up to a share of the step [J].
  [[nodiscard]] double dragged(double until) const {
    double sum = 0.0;
    for (const auto& [at, weight] : local::detail::kGauss) {
      const double tau = at * until;
      const DenseMap map = dense_map(scale_of(length_), sweep_.terms, tau);
      std::array<double, kMostTerms> rate{};
      for (std::size_t j = 0; j < sweep_.terms; ++j) {
        rate[j] = local::detail::slope(local::kLegendre[j].data(), sweep_.terms, tau) / length_;
      }
      const auto taken = [&](std::size_t i) {
        double speed = map.speed_of_start * start_[count_ + i];
        double line = 0.0;
        for (std::size_t j = 0; j < sweep_.terms; ++j) {
          speed += map.speed[j] / length_ * sweep_.line_rows[j][i];
          line += rate[j] * sweep_.line_rows[j][i];
        }
        return sweep_.mass[i] * speed * (sweep_.drag * speed + sweep_.line_drag() * (speed - line));
      };
      double power = 0.0;
      for (std::size_t i = 0; i < count_; ++i) {
        power += taken(i);
      }
      touching_->each([&](std::size_t node) { power -= taken(node); });
      sum += weight * until * length_ * power;
    }
    return sum;
  }

  /// The line's motion over a new step: the polynomial at hand, gone on with or cut.
  void extrapolate(double step) {
    std::array<double*, kMostTerms> lines{};
    for (std::size_t j = 0; j < sweep_.terms; ++j) {
      lines[j] = sweep_.line_rows[j].data();
    }
    change_basis(sweep_.terms, lines, count_,
                 legendre_change(sweep_.terms, from_end_ ? 1.0 : 0.0, step / polynomial_step_));
    polynomial_step_ = step;
    from_end_ = false;
  }

  /// What forces add to the line's motion of this step: all of it but what hangs on the masses.
  void load_line(double step) {
    const Loads& loads = equations_->loads();
    if (steady_known_ && !loads.time_dependent()) {
      return;
    }
    steady_known_ = true;
    const std::vector<double> none(count_, 0.0);
    FilteredLine& line = equations_->line();
    line.solve(none, loads.force(begin_, work_), sweep_.steady[0], {});
    for (std::size_t mode = 0; mode < steady_amplitude_.size(); ++mode) {
      steady_amplitude_[mode][0] = line.amplitudes()[mode];
    }
    if (loads.time_dependent()) {
      line.solve(none, loads.rate(begin_, work_), sweep_.steady[1], {});
      for (std::size_t mode = 0; mode < steady_amplitude_.size(); ++mode) {
        steady_amplitude_[mode][1] = 0.5 * step * line.amplitudes()[mode];
        steady_amplitude_[mode][0] += steady_amplitude_[mode][1];
      }
      for (std::size_t i = 0; i < count_; ++i) {
        sweep_.steady[1][i] *= 0.5 * step;
        sweep_.steady[0][i] += sweep_.steady[1][i];
      }
    }
  }

  /// Repeats solves and local motion until they agree; false if they do not.
  bool settle(double step) {
    ++attempts_;
    sweep_.begin = begin_;
    sweep_.step = step;
    sweep_.map = dense_map(scale_of(step), sweep_.terms);
    sweep_.map.gain = sweep_gain(sweep_.map.line, kLineShare, sweep_.terms);
    sweep_.reach = reach_of(scale_of(step), sweep_.terms);
    if (line_forces_) {
      line_forces_->begin();
    }
    load_line(step);
    extrapolate(step);
    move(true);
    double before = std::numeric_limits<double>::infinity();
    for (int sweeps = 1; sweeps <= kMostSweeps; ++sweeps) {
      std::array<chain::Column, kMostTerms> columns;
      for (std::size_t j = 0; j < sweep_.terms; ++j) {
        columns[j] = {.displacement = sweep_.moment_rows[j].data(), .stretch = sweep_.line_rows[j].data()};
      }
      equations_->line().solve({columns.data(), sweep_.terms});
      for (std::size_t mode = 0; mode < steady_amplitude_.size(); ++mode) {
        sweep_.amplitude[mode] = steady_amplitude_[mode];
        for (std::size_t j = 0; j < sweep_.terms; ++j) {
          sweep_.amplitude[mode][j] += equations_->line().amplitudes(j)[mode];
        }
      }
      if (line_forces_) {
        const petsc::LogScope contact{petsc::log_events().contact};
        line_forces_->apply();
      }
      move(false);
      if (line_forces_) {
        line_forces_->tell(tally_);
      }
      ++sweeps_;
      reduce_(tally_, equations_->beam().comm());
      if (tally_.most[Tally::broken] != 0.0) {
        throw not_finite();
      }
      scale_.grow(tally_.most[Tally::speed], highest_);
      // The line is known but for its last bits; what pulls the masses by these counts for nothing.
      const double extent = std::max(tally_.most[Tally::extent], step * tally_.most[Tally::speed]);
      const double z2 = wf_ * wf_ * step * step;
      const double length = std::max(tolerance_ * scale_.length, z2 * kLastBits * extent);
      const double way = std::max(tolerance_ * step * scale_.velocity, z2 * kLastBits * extent);
      const auto relative = [&](double place, double speed) { return std::max(place / length, speed / way); };
      const double change = z2 * tally_.most[Tally::change] * std::max(0.5 / length, 1.0 / way);
      const double last = tally_.most[Tally::last_term];
      const double smooth = relative(std::abs(sweep_.map.place[sweep_.terms - 1]) * last,
                                     std::abs(sweep_.map.speed[sweep_.terms - 1]) * last);
      const double kink = z2 * kink_integral_ * tally_.most[Tally::kink];
      // A series that ends before its last two terms has no rate of decay, and no error.
      const double decay = last > 0.0 ? std::min(1.0, last / tally_.most[Tally::term_before]) : 0.0;
      error_ = std::max(smooth * decay, relative(0.5 * kink, kink));
      if (change <= kSettled) {
        return true;
      }
      if (change > kLeastGain * before && sweeps > kPatience) {
        return false;
      }
      before = change;
    }
    return false;
  }

  /// Local motion of all masses: moments for the next sweep, end of the step, line polynomial in place of the stretch.
  void move(bool predict) {
    const petsc::LogScope scope{petsc::log_events().local_motion};
    tally_ = {};
    sweep_.predict = predict;
    touching_->begin(tally_);
    Largest largest;
    for (std::size_t from = 0; from < count_; from += kBlock) {
      const std::size_t to = std::min(from + kBlock, count_);
      Rows rows = sweep_.rows(from);
      rows.free = touching_->take_out(from, to, largest);
      map_masses(sweep_.terms, predict, rows, to - from, sweep_.map, sweep_.step, largest);
      touching_->move(from, largest);
    }
    touching_->finish(largest);
    finish_tally(largest);
  }

  /// How far masses are from the axis and how fast they are, at the start of the step.
  void note_scale() {
    speed_ = 0.0;
    extent_ = 0.0;
    for (std::size_t i = 0; i < count_; ++i) {
      speed_ = std::max(speed_, std::abs(start_[count_ + i]));
      extent_ = std::max(extent_, std::abs(start_[i] - sweep_.axis[i]));
    }
  }

  void finish_tally(const Largest& largest) {
    auto& most = tally_.most;
    most[Tally::speed] = speed_;
    most[Tally::extent] = extent_;
    most[Tally::change] = largest.change;
    most[Tally::last_term] = largest.last;
    most[Tally::term_before] = largest.before;
    most[Tally::broken] += largest.finite ? 0.0 : 1.0;
  }

  /// Share of the step at which most momentum is exchanged at once; 0: nothing stands out.
  [[nodiscard]] double heavy_impact() const {
    double all = 0.0;
    std::size_t heaviest = 0;
    for (std::size_t k = 0; k < kBins; ++k) {
      all += tally_.kick[k];
      heaviest = tally_.kick[k] > tally_.kick[heaviest] ? k : heaviest;
    }
    return tally_.kick[heaviest] > kHeavy * all ? tally_.first[heaviest] : 0.0;
  }

  PetscInt moments_ = 4;
  PetscBool moments_given_ = PETSC_FALSE;
  double longest_ = 0.0;
  Sweep sweep_;
  std::optional<TouchingMasses> touching_;
  std::optional<LineForces> line_forces_;
  bool steady_known_ = false;
  std::vector<std::array<double, kMostTerms>> steady_amplitude_;  // of what forces add, as Sweep::amplitude
  std::vector<double> work_;
  double kink_integral_ = 0.0;
  double speed_ = 0.0;   // largest of this rank at the start of the step [m/s]
  double extent_ = 0.0;  // the same of the distance from the axis [m]
  Tally tally_;
  TallyReduction reduce_;
  double polynomial_step_ = 0.0;  // over which the line is a polynomial [s]
  bool from_end_ = true;          // the next step starts at its end, not at its start
  double next_step_ = 0.0;
  double error_ = 0.0;
  PetscInt own_steps_ = 0;  // of this run; that of the TS goes on through a restart
  PetscInt attempts_ = 0;
  PetscInt sweeps_ = 0;
  PetscInt cuts_ = 0;
};

}  // namespace

PetscErrorCode register_ts_impact() { return petsc::register_integrator<Impact>(kTsImpact); }

}  // namespace udar
