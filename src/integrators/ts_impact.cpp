#include "udar/integrators/ts_impact.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>

#include "udar/integrators/line_forces.hpp"
#include "udar/integrators/problem_integrator.hpp"
#include "udar/integrators/rigid_flight.hpp"
#include "udar/integrators/sweep.hpp"
#include "udar/integrators/sweep_tally.hpp"
#include "udar/integrators/swept_line.hpp"
#include "udar/integrators/touching_masses.hpp"
#include "udar/local/step_maps.hpp"
#include "udar/motion/finite.hpp"
#include "udar/numerics/gauss.hpp"
#include "udar/numerics/legendre.hpp"
#include "udar/numerics/power_series.hpp"
#include "udar/petsc/array.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/log.hpp"

namespace udar {
namespace {

using petsc::ReadArray;

// Sweeps are over when all that further ones could still change is this share of the tolerance.
constexpr double kSettled = 0.05;
constexpr int kMostSweeps = 12;
// The last bits of places, some three of them in what a solve makes of them, must stay below that share of this.
constexpr double kLastBits = 64.0 * std::numeric_limits<double>::epsilon();
// After so many sweeps, those that would not settle by then have met masses whose impacts come and go, or are too long.
constexpr int kSweepsBeforeForecast = 4;
// A step that sweeps slowly is too long.
constexpr double kLongestAngle = 1.5;
// Nor is one taken whose sweeps are known to gain less than this: two shorter ones cost less.
constexpr double kSlowest = 0.5;
// The integral of a Legendre polynomial over a part of the step, at most: what a neglected term of the drive does to a
// speed within the step. At the end little is left of that, but what dampers take is summed up on the way.
constexpr double kWithin = 0.1;
// A failed step is cut at an impact that holds this share of all momentum exchanged in it.
constexpr double kHeavy = 0.3;
// ... unless it already lies at a border of the step.
constexpr double kShortestCut = 0.02;
constexpr double kLongestCut = 0.999;

class Impact final : public ProblemIntegrator {
 public:
  [[nodiscard]] Features can() const override { return kImpactType.can; }

  void set_from_options(TS stepper, PetscOptionItems* PetscOptionsObject) override {
    UDAR_CALL(
        PetscOptionsInt("-ts_impact_moments",
                        "Legendre terms of the line's motion over a step; line solves a sweep; 5 by default where "
                        "supports touch the line",
                        "TSIMPACT", moments_, &moments_, &moments_given_));
    if (moments_ < 2 || moments_ > static_cast<PetscInt>(kMostTerms)) {
      throw InputError{"ts impact moments: " + std::to_string(moments_) +
                       " is not allowed, expected an integer from 2 to 5"};
    }
    set_default_tolerance(stepper, kTolerance);
  }

  void start(const LineState& line) override {
    double step = 0.0;
    UDAR_CALL(TSGetTimeStep(ts_, &step));
    const ReadArray now{state_};
    line_->start(line, *contact_, now.values() + count_, std::min(step, longest_));
    may_fly_ = true;
    ProblemIntegrator::begin_step();
  }

  /// After a step the line's motion counts from the new positions.
  void begin_step() override {
    if (flight_->flies()) {
      end_flight();
    } else if (stepped_) {
      line_->begin_step(length_);
      touching_->release_memory();
      touching_->history().end_step();
    }
    ProblemIntegrator::begin_step();
  }

  bool advance() override {
    double step = enter_step(longest_);
    if (takes_off()) {
      {
        const petsc::WriteArray end{state_};
        flight_->at(flight_->length(), {end.values(), count_}, {end.values() + count_, count_});
      }
      leave_step(flight_->length(), next_step_);
      flight_->track_line();
      return true;
    }
    note_scale();
    if (damps_by_rate()) {
      line_->solve_start();
    }
    bool accepted = false;
    double next = step;
    for (int attempt = 0; !accepted; ++attempt) {
      if (attempt > kMostAttempts) {
        return false;
      }
      const bool settled = converge(step);
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
          ++counts_.cuts;
        }
        step = next;
      }
    }
    next_step_ = std::min(next, longest_);
    ++counts_.steps;
    leave_step(step, next_step_);
    const petsc::LogScope contact{petsc::log_events().contact};
    touching_->write_journal();
    if (sweep_.damped()) {
      contact_->journal().record_flow({.damped = dragged(1.0)});
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
    UDAR_CALL(PetscViewerASCIIPrintf(viewer, "  steps %d, sweeps %d, rejected %d, cut at impacts %d, flights %d\n",
                                     static_cast<int>(steps()), static_cast<int>(counts_.sweeps),
                                     static_cast<int>(rejected), static_cast<int>(counts_.cuts),
                                     static_cast<int>(counts_.flights)));
  }

  [[nodiscard]] double next_step() const override { return next_step_; }

  void line_integrals(std::span<const std::size_t> nodes, double until, std::span<double> integrals) const override {
    if (!stepped_) {
      std::ranges::fill(integrals, 0.0);
    } else if (flight_->flies()) {
      flight_->line_integrals(std::clamp(until - begin_, 0.0, length_), nodes, integrals);
    } else {
      const double tau = std::clamp((until - begin_) / length_, 0.0, 1.0);
      std::ranges::transform(nodes, integrals.begin(), [&](std::size_t node) {
        return length_ * tau * (start_[node] + line_->mean_stretch(node, tau));
      });
    }
  }
  void mass_integrals(double until, std::span<double> integrals) const override {
    if (!stepped_) {
      std::ranges::fill(integrals, 0.0);
    } else if (flight_->flies()) {
      flight_->mass_integrals(std::clamp(until - begin_, 0.0, length_), integrals);
    } else {
      touching_->integrals(std::clamp((until - begin_) / length_, 0.0, 1.0), integrals);
    }
  }
  [[nodiscard]] std::vector<double> amplitude_integrals(double until) const override {
    if (flight_->flies()) {
      return flight_->amplitude_integrals(std::clamp(until - begin_, 0.0, length_));
    }
    return line_->amplitude_integrals(stepped_ ? std::clamp((until - begin_) / length_, 0.0, 1.0) : 0.0, length_);
  }

  [[nodiscard]] EnergyFlow flow(double until) const override {
    if (!stepped_) {
      const ReadArray now{state_};
      return {.stored = touching_->stored(begin_, {now.values(), count_})};
    }
    if (flight_->flies()) {
      return {};
    }
    const double tau = std::clamp((until - begin_) / length_, 0.0, 1.0);
    EnergyFlow flow = touching_->flow(tau);
    flow.damped += sweep_.damped() ? dragged(tau) : 0.0;
    flow.work += line_forces_ ? line_forces_->flow(tau).work : 0.0;
    return flow;
  }

  [[nodiscard]] std::map<std::string, PetscInt> tally() const override {
    return {{"sweeps", counts_.sweeps}, {"steps_cut_at_impacts", counts_.cuts}, {"rigid_flights", counts_.flights}};
  }
  [[nodiscard]] double streamed_bytes() const override {
    const auto m = static_cast<double>(sweep_.terms);
    std::size_t contact_nodes = 0;
    for (const ContactSet& set : contact_->sets()) {
      contact_nodes += set.last - set.first;
    }
    // A sweep: moments and line read and written; steady part, position, velocity, axis read; ends written. To
    // predict: the line twice, moments written. A step: the state copied, its size, the line counted anew.
    double per_node =
        8.0 * ((4.0 * m + 6.0) * counts_.sweeps + (4.0 * m + 3.0) * counts_.attempts + 11.0 * counts_.steps);
    // The line's rate by moments, stretches and both ends, and the drive by it and the line.
    per_node += damps_by_rate()
                    ? 8.0 * ((8.0 * m + 3.0) * counts_.sweeps + 6.0 * m * counts_.attempts + 3.0 * counts_.steps)
                    : 0.0;
    // Who rests, and the line's distance at the end.
    const double per_contact_node = 4.0 * (counts_.sweeps + counts_.attempts) + 8.0 * (m + 1.0) * counts_.steps;
    return per_node * static_cast<double>(count_) + per_contact_node * static_cast<double>(contact_nodes);
  }
  void save(MotionState& state) const override {
    line_->save(state);
    touching_->history().save(count_, state);
    state.scalars["next_step"] = next_step_;
    state.scalars["may_fly"] = may_fly_ ? 1.0 : 0.0;
    state.scalars["scale_length"] = scale_.length;
    state.scalars["scale_velocity"] = scale_.velocity;
  }
  void restore(const MotionState& state) override {
    line_->restore(state);
    touching_->history().restore(count_, state);
    next_step_ = state.scalar("next_step");
    may_fly_ = state.scalars.contains("may_fly") && state.scalar("may_fly") != 0.0;
    scale_ = {.length = state.scalar("scale_length"), .velocity = state.scalar("scale_velocity")};
    ProblemIntegrator::begin_step();
  }

 private:
  static constexpr double kTolerance = 1e-7;
  static constexpr int kMostAttempts = 100;

  /// Whether the line's rate drives the masses.
  [[nodiscard]] bool damps_by_rate() const { return sweep_.line_damping != 0.0; }

  /// Whether the integrator may choose the length of a step as it likes.
  [[nodiscard]] static bool steps_are_free(TSAdapt adapt) {
    PetscBool fixed = PETSC_FALSE;
    PetscBool limited = PETSC_FALSE;
    UDAR_CALL(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(adapt), TSADAPTNONE, &fixed));
    UDAR_CALL(PetscOptionsHasName(nullptr, nullptr, "-ts_adapt_dt_max", &limited));
    return fixed == PETSC_FALSE && limited == PETSC_FALSE;
  }

  /// Whether the step at hand is a rigid flight: looked for where the motion starts, and where such a flight has ended
  /// without touching anything.
  [[nodiscard]] bool takes_off() {
    if (!can_fly_ || !may_fly_ || contact_->counts().resting > 0) {
      return false;
    }
    double last = 0.0;
    UDAR_CALL(TSGetMaxTime(ts_, &last));
    const double until = std::min(last, kinks_->after(begin_)) - begin_;
    // Far below the error of an ordinary step, and far above the rounding of a solve of a million elements.
    const double negligible = 1e-3 * tolerance_ * scale_.length;
    const bool flies = until > longest_ && flight_->begin(begin_, {start_, 2 * count_}, longest_, until, negligible);
    may_fly_ = until <= longest_ || (flies && !flight_->touches());
    counts_.flights += flies ? 1 : 0;
    next_step_ = flies && next_step_ == 0.0 ? longest_ : next_step_;
    return flies;
  }

  /// The line goes on as in the last ordinary step of the flight.
  void end_flight() {
    const ReadArray now{state_};
    line_->follow(now.values() + count_, longest_, [&](std::size_t i) { return flight_->acceleration(length_, i); });
    flight_->end();
  }

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
    jump_integral_ = jump_integral(sweep_.terms);
    sweep_.drag = equations_->damping().mass;
    sweep_.line_damping = equations_->damping().stiffness;
    sweep_.frequency = wf_;
    longest_ = std::min(most, kLongestAngle / (highest_ + sweep_.drag + sweep_.line_drag()));
    // An answer below zero: a corrected mode above wf.
    line_answer_.least = std::min(0.0, 1.0 - highest_ * highest_ / (wf_ * wf_));
    for (set_maps(longest_); sweep_.map.contraction > kSlowest; set_maps(longest_)) {
      constexpr double kShorter = 0.9;
      longest_ *= kShorter;
    }
    for (std::size_t j = 0; j < sweep_.unknowns(); ++j) {
      sweep_.moment_rows[j].assign(count_, 0.0);
    }
    for (std::size_t j = 0; j < sweep_.terms; ++j) {
      sweep_.series.rows[j].assign(count_, 0.0);
      sweep_.series.rates[j].assign(damps_by_rate() ? count_ : 0, 0.0);
      sweep_.series.drives[j].assign(damps_by_rate() ? count_ : 0, 0.0);
    }
    sweep_.series.start_stretch.assign(damps_by_rate() ? count_ : 0, 0.0);
    sweep_.series.end_stretch.assign(damps_by_rate() ? count_ : 0, 0.0);
    sweep_.series.steady[0].assign(count_, 0.0);
    sweep_.series.steady[1].assign(equations_->loads().time_dependent() ? count_ : 0, 0.0);
    sweep_.series.corrected = equations_->line().corrected_modes();
    sweep_.series.amplitude.resize(sweep_.series.corrected.size());
    sweep_.count = count_;
    sweep_.frequency = wf_;
    sweep_.start = start_;
    sweep_.end = petsc::WriteArray{state_}.values();  // stays where it is, too
    sweep_.axis = equations_->axis();
    sweep_.mass = equations_->line().mass();
    line_.emplace(*equations_, sweep_);
    touching_.emplace(sweep_, *contact_, equations_->line());
    flight_.emplace(*equations_, *contact_, contacts_);
    can_fly_ = kinks_ != nullptr && contacts_ != nullptr && !sweep_.damped() && steps_are_free(adapt) &&
               std::ranges::all_of(contacts_->supports, &Support::plain);
    if (equations_->line_contact() != nullptr) {
      line_forces_.emplace(sweep_, *equations_->line_contact(), *contact_);
    }
  }
  void take_back() override {
    if (flight_->flies()) {
      flight_->end();
      may_fly_ = true;
    } else {
      line_->take_back();
      touching_->history().forget();
    }
  }
  void within(double elapsed, std::span<double> position, std::span<double> velocity,
              std::span<std::uint8_t> resting) const override {
    if (flight_->flies()) {
      std::ranges::fill(resting, std::uint8_t{0});
      return flight_->at(elapsed, position, velocity);
    }
    const double tau = elapsed / length_;
    const DenseMap map = dense_map(sweep_.scale(), sweep_.terms, tau);
    for (std::size_t i = 0; i < count_; ++i) {
      double place = map.place_of_start * start_[count_ + i] * length_;
      double speed = map.speed_of_start * start_[count_ + i] * length_;
      for (std::size_t j = 0; j < sweep_.terms; ++j) {
        place += map.place[j] * sweep_.drive(j)[i];
        speed += map.speed[j] * sweep_.drive(j)[i];
      }
      position[i] = start_[i] + place;
      velocity[i] = speed / length_;
      resting[i] = 0;
    }
    touching_->at(tau, position, velocity, resting);
  }

  /// What damping of the structure took of the masses that touched nothing, up to a share of the step [J].
  [[nodiscard]] double dragged(double until) const {
    double sum = 0.0;
    for (const auto& [at, weight] : kGauss) {
      const double tau = at * until;
      const DenseMap map = dense_map(sweep_.scale(), sweep_.terms, tau);
      std::array<double, kMostTerms> legendre{};
      for (std::size_t j = 0; j < sweep_.terms; ++j) {
        legendre[j] = power_series::value(kLegendre[j].data(), sweep_.terms, tau);
      }
      const auto taken = [&](std::size_t i) {
        double speed = map.speed_of_start * start_[count_ + i];
        double rate = 0.0;
        for (std::size_t j = 0; j < sweep_.terms; ++j) {
          speed += map.speed[j] / length_ * sweep_.drive(j)[i];
          rate += damps_by_rate() ? legendre[j] * sweep_.series.rates[j][i] : 0.0;
        }
        return sweep_.mass[i] * speed * (sweep_.drag * speed + sweep_.line_drag() * (speed - rate));
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

  /// What depends on the length of the step alone.
  void set_maps(double step) {
    sweep_.step = step;
    sweep_.map = dense_map(sweep_.scale(), sweep_.terms);
    set_gain(sweep_.map, sweep_.scale(), sweep_.terms, line_answer_);
    sweep_.reach = response_bounds(sweep_.scale(), sweep_.terms);
  }

  /// Repeats solves and local motion until they agree; false if they do not.
  bool converge(double step) {
    ++counts_.attempts;
    sweep_.begin = begin_;
    set_maps(step);
    if (line_forces_) {
      line_forces_->begin();
    }
    line_->load(begin_, step);
    line_->extrapolate(step);
    move(true);
    double before = std::numeric_limits<double>::infinity();
    for (int sweeps = 1; sweeps <= kMostSweeps; ++sweeps) {
      line_->solve(line_forces_ ? &*line_forces_ : nullptr);
      move(false);
      if (line_forces_) {
        line_forces_->tell(tally_);
      }
      ++counts_.sweeps;
      reduce_(tally_, equations_->points().comm());
      if (tally_.most[Tally::broken] != 0.0) {
        require_finite(*equations_, {sweep_.end, count_}, {sweep_.end + count_, count_}, begin_);
        throw not_finite();  // what drives a mass at rest
      }
      scale_.grow(tally_.most[Tally::speed], highest_);
      // The line and its rate are known but for their last bits; what pulls the masses by these counts for nothing.
      const double way_of_step = step * tally_.most[Tally::speed];
      const double z2 = sweep_.angle() * sweep_.angle();
      const double rate = sweep_.line_drag() * step;
      const double bits = kLastBits * (z2 * std::max(tally_.most[Tally::extent], way_of_step) + rate * way_of_step);
      const double length = std::max(tolerance_ * scale_.length, bits);
      const double way = std::max(tolerance_ * step * scale_.velocity, bits);
      const auto relative = [&](double place, double speed) { return std::max(place / length, speed / way); };
      // What the next sweep could change, and by how much that shrinks from one to the next.
      const double push = z2 * tally_.most[Tally::change] + rate * tally_.most[Tally::rate];
      const double change = relative(0.5 * push, push);
      const double contraction = std::max(sweep_.map.contraction, sweeps > 1 && before > 0.0 ? change / before : 0.0);
      const double left = contraction < 1.0 ? change / (1.0 - contraction) : std::numeric_limits<double>::infinity();
      const double last = tally_.most[Tally::last_term];
      const double within = sweep_.damped() ? kWithin * z2 * last : 0.0;
      const double smooth = relative(std::max(std::abs(sweep_.map.place[sweep_.terms - 1]) * last, kWithin * within),
                                     std::max(std::abs(sweep_.map.speed[sweep_.terms - 1]) * last, within));
      const double kink = (z2 * kink_integral_ + rate * jump_integral_) * tally_.most[Tally::kink];
      // A series that ends before its last two terms has no rate of decay, and no error.
      const double decay = last > 0.0 ? std::min(1.0, last / tally_.most[Tally::term_before]) : 0.0;
      error_ = std::max(smooth * decay, relative(0.5 * kink, kink));
      if (left <= kSettled) {
        return true;
      }
      if (sweeps > kSweepsBeforeForecast && left * std::pow(contraction, kMostSweeps - sweeps) > kSettled) {
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
    SweepMaxima largest;
    for (std::size_t from = 0; from < count_; from += kBlock) {
      const std::size_t to = std::min(from + kBlock, count_);
      BlockRows rows = sweep_.rows(from);
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

  void finish_tally(const SweepMaxima& largest) {
    auto& most = tally_.most;
    most[Tally::speed] = speed_;
    most[Tally::extent] = extent_;
    most[Tally::change] = largest.change;
    most[Tally::rate] = largest.rate;
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
  std::optional<SweptLine> line_;
  std::optional<TouchingMasses> touching_;
  std::optional<LineForces> line_forces_;
  std::optional<RigidFlight> flight_;
  bool can_fly_ = false;
  bool may_fly_ = false;  // nothing has touched or strained the structure since the start, but for what loads did
  double kink_integral_ = 0.0;
  double speed_ = 0.0;   // largest of this rank at the start of the step [m/s]
  double extent_ = 0.0;  // the same of the distance from the axis [m]
  double jump_integral_ = 0.0;
  LineAnswer line_answer_;
  Tally tally_;
  TallyReduction reduce_;
  double next_step_ = 0.0;
  double error_ = 0.0;
  struct Counts {  // of this run; the steps of the TS go on through a restart
    PetscInt steps = 0;
    PetscInt attempts = 0;
    PetscInt sweeps = 0;
    PetscInt cuts = 0;
    PetscInt flights = 0;
  } counts_;
};

}  // namespace

PetscErrorCode register_ts_impact() { return petsc::register_integrator<Impact>(kTsImpact); }

}  // namespace udar
