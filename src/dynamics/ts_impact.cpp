#include "udar/dynamics/ts_impact.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "udar/dynamics/dense_map.hpp"
#include "udar/dynamics/local_motion.hpp"
#include "udar/dynamics/problem_stepper.hpp"
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
// A sweep that gains less than this after some has met masses whose impacts come and go: a shorter step settles.
constexpr double kLeastGain = 0.9;
constexpr int kPatience = 4;
// A step that sweeps slowly is too long.
constexpr double kLongestAngle = 1.5;
// A failed step is cut at an impact that holds this share of all momentum exchanged in it.
constexpr double kHeavy = 0.3;
constexpr std::size_t kBins = 8;
// ... unless it already lies at a border of the step.
constexpr double kShortestCut = 0.02;
constexpr double kLongestCut = 0.999;
constexpr std::size_t kBlock = 512;

local::Problem unit_problem(double angle, std::size_t terms) {
  local::Problem problem;
  problem.angle = angle;
  problem.terms = terms;
  problem.powers = local::powers_for(angle);
  return problem;
}

DenseMap dense_map(double angle, std::size_t terms, double until = 1.0) {
  DenseMap map;
  local::Problem problem = unit_problem(angle, terms);
  problem.until = until;
  problem.velocity = 1.0;
  local::Outcome outcome = local::advance(problem);
  map.start = outcome.moments;
  map.place_of_start = outcome.displacement;
  map.speed_of_start = outcome.velocity;
  problem.velocity = 0.0;
  for (std::size_t j = 0; j < terms; ++j) {
    problem.line = local::kLegendre[j];
    outcome = local::advance(problem);
    for (std::size_t i = 0; i < terms; ++i) {
      map.line[i][j] = outcome.moments[i];
    }
    map.place[j] = outcome.displacement;
    map.speed[j] = outcome.velocity;
  }
  return map;
}

/// (1 - share line)^-1 by Neumann's series: |share line| <= angle^2 / 2.
Square sweep_gain(const Square& line, std::size_t terms) {
  Square gain{};
  Square power{};
  for (std::size_t i = 0; i < terms; ++i) {
    gain[i][i] = 1.0;
    power[i][i] = 1.0;
  }
  for (int order = 0; order < 60; ++order) {
    Square next{};
    for (std::size_t i = 0; i < terms; ++i) {
      for (std::size_t j = 0; j < terms; ++j) {
        for (std::size_t k = 0; k < terms; ++k) {
          next[i][j] += kLineShare * line[i][k] * power[k][j];
        }
        gain[i][j] += next[i][j];
      }
    }
    power = next;
  }
  return gain;
}

/// What all ranks learn from one sweep: maxima, then sums, then minima.
struct Tally {
  enum Maximum : std::size_t { change, kink, last_term, term_before, broken, maxima };
  std::array<double, maxima> most{};
  std::array<double, kBins> kick{};
  std::array<double, kBins> first{};

  Tally() { first.fill(2.0); }
};
static_assert(sizeof(Tally) == (Tally::maxima + 2 * kBins) * sizeof(double));

// NOLINTNEXTLINE(readability-non-const-parameter): MPI_User_function
void combine(void* from, void* into, int* length, MPI_Datatype* /*type*/) {
  for (int i = 0; i < *length; ++i) {
    const Tally& a = static_cast<const Tally*>(from)[i];
    Tally& b = static_cast<Tally*>(into)[i];
    for (std::size_t k = 0; k < Tally::maxima; ++k) {
      b.most[k] = std::max(a.most[k], b.most[k]);
    }
    for (std::size_t k = 0; k < kBins; ++k) {
      b.kick[k] += a.kick[k];
      b.first[k] = std::min(a.first[k], b.first[k]);
    }
  }
}

/// What the projection of the line's motion on `terms` polynomials misses of a kink of unit slope, as seen by the mass
/// that causes it at the same time: the largest integral of the miss from the kink to the end.
double kink_integral(std::size_t terms) {
  double largest = 0.0;
  for (int k = 1; k < 100; ++k) {
    const double at = 0.01 * k;
    const double left = 1.0 - at;
    const std::array<double, 2> ramp{0.0, 1.0};
    const std::array<double, 1> one{1.0};
    std::array<double, kMostTerms> of_ramp{};
    std::array<double, kMostTerms> of_one{};
    local::detail::add_moments(ramp.data(), 2, at, left, terms, of_ramp);
    local::detail::add_moments(one.data(), 1, at, left, terms, of_one);
    double miss = 0.5 * left * left;
    for (std::size_t j = 0; j < terms; ++j) {
      miss -= of_ramp[j] * of_one[j] / static_cast<double>(2 * j + 1);
    }
    largest = std::max(largest, std::abs(miss));
  }
  return largest;
}

class Impact final : public ProblemStepper {
 public:
  Impact() {
    MPI_Type_contiguous(static_cast<int>(sizeof(Tally)), MPI_BYTE, &tally_type_);
    MPI_Type_commit(&tally_type_);
    MPI_Op_create(combine, 1, &tally_op_);
  }
  Impact(const Impact&) = delete;
  Impact& operator=(const Impact&) = delete;
  ~Impact() override {
    int finalized = 0;
    MPI_Finalized(&finalized);
    if (finalized == 0) {
      MPI_Op_free(&tally_op_);
      MPI_Type_free(&tally_type_);
    }
  }

  void set_from_options(TS stepper, PetscOptionItems* PetscOptionsObject) override {
    UDAR_CALL(PetscOptionsInt("-ts_impact_moments",
                              "Legendre terms of the line's motion over a step; line solves a sweep", "TSIMPACT",
                              moments_, &moments_, nullptr));
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
      line_[0][i] = line.stretch[i] + half;  // seen as the step that ends here
      line_[1][i] = -half;
      for (std::size_t j = 2; j < terms_; ++j) {
        line_[j][i] = 0.0;
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
        line_[0][i] -= end_.position[i] - start_[i];
      }
    }
    ProblemStepper::begin_step();
  }

  void step(TS stepper) override {
    double step = enter_step(longest_);
    bool accepted = false;
    double next = step;
    for (int attempt = 0; !accepted; ++attempt) {
      if (attempt > kMostAttempts) {
        UDAR_CALL(TSSetConvergedReason(stepper, TS_DIVERGED_STEP_REJECTED));
        return;
      }
      const bool settled = sweep(step);
      if (settled) {
        const petsc::Judgement judged = petsc::judge_step(stepper, step);
        accepted = judged.accepted;
        next = judged.next_step;
      } else {
        next = 0.5 * step;
      }
      if (!accepted) {
        petsc::count_rejection(stepper);
        const double cut = settled ? heavy_impact() * step : 0.0;
        if (cut > kShortestCut * step && cut < kLongestCut * step) {
          next = cut;
          ++cuts_;
        }
        step = next;
      }
    }
    next_step_ = std::min(next, longest_);
    leave_step(end_, step, next_step_);
    const petsc::LogScope contact{petsc::log_events().contact};
    write_journal();
    track_line();
  }

  [[nodiscard]] Error error() const override { return {.norm = error_, .order = static_cast<int>(terms_)}; }

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
    const auto powers = line_powers(node);
    double sum = 0.0;
    for (std::size_t k = terms_; k-- > 0;) {
      sum = sum * tau + powers[k] / static_cast<double>(k + 1);
    }
    return length_ * tau * (start_[node] + sum);
  }

  [[nodiscard]] std::map<std::string, PetscInt> tally() const override {
    return {{"sweeps", sweeps_}, {"steps_cut_at_impacts", cuts_}};
  }
  void save(MotionState& state) const override {
    for (std::size_t j = 0; j < terms_; ++j) {
      state.fields["line_" + std::to_string(j)] = line_[j];
    }
    state.scalars["line_step"] = polynomial_step_;
    state.scalars["next_step"] = next_step_;
  }
  void restore(const MotionState& state) override {
    for (std::size_t j = 0; j < terms_; ++j) {
      line_[j] = state.field("line_" + std::to_string(j), count_);
    }
    polynomial_step_ = state.scalar("line_step");
    next_step_ = state.scalar("next_step");
    from_end_ = true;
    ProblemStepper::begin_step();
  }

 private:
  static constexpr double kTolerance = 1e-7;
  static constexpr int kMostAttempts = 100;

  struct Touching {
    std::size_t node;
    std::array<double, kMostTerms> moment;  // u before the sweep
    std::array<double, kMostTerms> line;    // p
    std::int32_t resting;                   // support + 1 at the start of the step
  };

  struct Pressed {
    const ContactRun* run;
    std::size_t node;
  };

  void prepare() override {
    TSAdapt adapt = nullptr;
    double least = 0.0;
    double most = 0.0;
    UDAR_CALL(TSGetAdapt(ts_, &adapt));
    UDAR_CALL(TSAdaptGetStepLimits(adapt, &least, &most));
    terms_ = static_cast<std::size_t>(moments_);
    kink_integral_ = kink_integral(terms_);
    longest_ = std::min(most, kLongestAngle / wf_);
    for (std::size_t j = 0; j < terms_; ++j) {
      moment_[j].assign(count_, 0.0);
      line_[j].assign(count_, 0.0);
    }
    for (std::vector<double>& steady : steady_) {
      steady.assign(count_, 0.0);
    }
    end_.position.resize(count_);
    end_.velocity.resize(count_);
    for (const ContactRun& run : contact_->runs()) {
      for (std::size_t node = run.first; node < run.last; ++node) {
        contact_nodes_.push_back(node);
      }
    }
    std::ranges::sort(contact_nodes_);
    const auto repeated = std::ranges::unique(contact_nodes_);
    contact_nodes_.erase(repeated.begin(), repeated.end());
  }
  void take_back() override { from_end_ = false; }  // the polynomial is that of the step taken back
  void within(double elapsed, std::span<double> position, std::span<double> velocity,
              std::span<std::uint8_t> resting) const override {
    const double tau = elapsed / length_;
    const DenseMap map = dense_map(wf_ * length_, terms_, tau);
    for (std::size_t i = 0; i < count_; ++i) {
      double place = map.place_of_start * start_[count_ + i] * length_;
      double speed = map.speed_of_start * start_[count_ + i] * length_;
      for (std::size_t j = 0; j < terms_; ++j) {
        place += map.place[j] * line_[j][i];
        speed += map.speed[j] * line_[j][i];
      }
      position[i] = start_[i] + place;
      velocity[i] = speed / length_;
      resting[i] = 0;
    }
    for (const auto& [run, node] : pressed_) {
      position[node] = run->height;
      velocity[node] = 0.0;
      resting[node] = 1;
    }
    for (const Touching& mass : touching_) {
      local::Problem problem = meeting_of(mass, length_).problem;
      problem.until = tau;
      const local::Outcome outcome = local::advance(problem);
      position[mass.node] = start_[mass.node] + outcome.displacement;
      velocity[mass.node] = outcome.velocity / length_;
      resting[mass.node] = outcome.resting >= 0 ? 1 : 0;
    }
  }

  /// The line's motion over a new step: the polynomial at hand, gone on with or cut.
  void extrapolate(double step) {
    const double offset = from_end_ ? 1.0 : 0.0;
    const double ratio = step / polynomial_step_;
    Square change{};  // [new][old]
    for (std::size_t old = 0; old < terms_; ++old) {
      // Legendre coefficients on [0, 1] of L_old(offset + ratio tau), by its powers.
      std::array<double, kMostTerms> powers = local::kLegendre[old];
      local::detail::shift(powers, terms_, offset);
      double scale = 1.0;
      for (std::size_t k = 0; k < terms_; ++k) {
        powers[k] *= scale;
        scale *= ratio;
      }
      for (std::size_t k = terms_; k-- > 0;) {
        const double share = powers[k] / local::kLegendre[k][k];
        change[k][old] = share;
        for (std::size_t i = 0; i <= k; ++i) {
          powers[i] -= share * local::kLegendre[k][i];
        }
      }
    }
    for (std::size_t i = 0; i < count_; ++i) {
      std::array<double, kMostTerms> old{};
      for (std::size_t j = 0; j < terms_; ++j) {
        old[j] = line_[j][i];
      }
      for (std::size_t j = 0; j < terms_; ++j) {
        double sum = 0.0;
        for (std::size_t k = j; k < terms_; ++k) {
          sum += change[j][k] * old[k];
        }
        line_[j][i] = sum;
      }
    }
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
    equations_->line().solve(none, loads.force(begin_, work_), steady_[0], {});
    if (loads.time_dependent()) {
      equations_->line().solve(none, loads.rate(begin_, work_), steady_[1], {});
      for (std::size_t i = 0; i < count_; ++i) {
        steady_[1][i] *= 0.5 * step;
        steady_[0][i] += steady_[1][i];
      }
    }
  }

  /// Repeats solves and local motion until they agree; false if they do not.
  bool sweep(double step) {
    const MPI_Comm comm = equations_->beam().comm();
    map_ = dense_map(wf_ * step, terms_);
    map_.gain = sweep_gain(map_.line, terms_);
    load_line(step);
    extrapolate(step);
    move<true>(step);
    double before = std::numeric_limits<double>::infinity();
    for (int sweeps = 1; sweeps <= kMostSweeps; ++sweeps) {
      std::array<chain::Column, kMostTerms> columns;
      for (std::size_t j = 0; j < terms_; ++j) {
        columns[j] = {.displacement = moment_[j].data(), .stretch = line_[j].data()};
      }
      equations_->line().solve({columns.data(), terms_});
      move<false>(step);
      ++sweeps_;
      {
        const petsc::LogScope reduction{petsc::log_events().reduction};
        MPI_Allreduce(MPI_IN_PLACE, &tally_, 1, tally_type_, tally_op_, comm);
      }
      if (tally_.most[Tally::broken] != 0.0) {
        throw not_finite();
      }
      const double z2 = wf_ * wf_ * step * step;
      const double change =
          z2 * tally_.most[Tally::change] * std::max(0.5 / scale_.length, 1.0 / (step * scale_.velocity)) / tolerance_;
      const auto relative = [&](double place, double speed) {
        return std::max(place / scale_.length, speed / (step * scale_.velocity)) / tolerance_;
      };
      const double last = tally_.most[Tally::last_term];
      const double smooth = relative(std::abs(map_.place[terms_ - 1]) * last, std::abs(map_.speed[terms_ - 1]) * last);
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

  [[nodiscard]] std::array<double, kMostTerms> line_powers(std::size_t node) const {
    std::array<double, kMostTerms> powers{};
    for (std::size_t j = 0; j < terms_; ++j) {
      for (std::size_t k = 0; k <= j; ++k) {
        powers[k] += line_[j][node] * local::kLegendre[j][k];
      }
    }
    return powers;
  }

  /// A mass near its supports, and the support behind each stop: the first it meets, and the one it rests on.
  struct Meeting {
    local::Problem problem;
    std::array<const ContactRun*, 2> runs{};
  };
  [[nodiscard]] Meeting meeting_of(const Touching& mass, double step) const {
    const std::size_t node = mass.node;
    Meeting meeting{.problem = unit_problem(wf_ * step, terms_)};
    local::Problem& problem = meeting.problem;
    problem.line = line_powers(node);
    problem.velocity = start_[count_ + node] * step;
    problem.hop_tolerance = contact_->parameters().hop_tolerance;
    for (const ContactRun& run : contact_->runs()) {
      if (node < run.first || node >= run.last) {
        continue;
      }
      const std::size_t index = run.side > 0.0 ? 0 : 1;
      local::Stop& stop = problem.stops[index];
      const double at = run.height - start_[node];
      const bool rests = mass.resting == run.support + 1;
      const bool held = problem.resting == static_cast<int>(index);
      if (rests || (!held && (!stop.present || run.side * at > run.side * stop.at))) {
        stop = {.at = at, .restitution = run.restitution, .present = true};
        meeting.runs[index] = &run;
      }
      if (rests) {
        problem.resting = static_cast<int>(index);
      }
      problem.together = std::max(problem.together, contact_->together(start_[node], run.height));
    }
    return meeting;
  }

  /// How much of a mass's displacement the line takes on at once at its node: dx / 2 l on an even Winkler bed of decay
  /// length l = (4 EI / rhoA wf^2)^(1/4), four times that at an end.
  [[nodiscard]] double kink_share(std::size_t node) const {
    const BeamChain& beam = equations_->beam();
    const PetscInt global = beam.begin() + static_cast<PetscInt>(node);
    double compliance = std::numeric_limits<double>::infinity();
    double length = 0.0;
    bool end = false;
    for (const BeamElement& element : {beam.element(global - 1), beam.element(global)}) {
      const bool present = std::isfinite(element.flexural_compliance);
      compliance = std::min(compliance, element.flexural_compliance);
      length += present ? 0.5 * element.length : 0.0;
      end = end || !present;
    }
    const double bed = beam.mass(global) * wf_ * wf_ / length;
    const double decay = std::pow(4.0 / (compliance * bed), 0.25);
    return std::min(1.0, (end ? 2.0 : 0.5) * length / decay);
  }

  /// Whether a mass may come near a support within the step, for sure not if false.
  [[nodiscard]] bool may_touch(const ContactRun& run, std::size_t node, double step,
                               const std::array<double, kMostTerms>& p) const {
    const double gap = run.side * (start_[node] - run.height);
    const double speed = run.side * start_[count_ + node] * step;
    const double z2 = wf_ * wf_ * step * step;
    double reach = 0.0;
    for (std::size_t j = 0; j < terms_; ++j) {
      reach += std::abs(p[j]);
    }
    // |P| <= reach and |z| <= |speed| + z2 / 2 reach bound the acceleration.
    const double pull = 0.5 * z2 * (reach * (1.0 + 0.5 * z2) + std::abs(speed));
    const double together = contact_->together(start_[node], run.height);
    return std::min(gap, gap + speed - pull) <= together || gap <= together;
  }

  /// Local motion of all masses: moments for the next sweep, end of the step, line polynomial in place of the stretch.
  template <bool Predict>
  void move(double step) {
    const petsc::LogScope scope{petsc::log_events().local_motion};
    tally_ = {};
    touching_.clear();
    pressed_.clear();
    const auto& runs = contact_->runs();
    Largest largest;
    auto next_contact = contact_nodes_.begin();
    for (std::size_t from = 0; from < count_; from += kBlock) {
      const std::size_t to = std::min(from + kBlock, count_);
      apart_.clear();
      const std::size_t first_touching = touching_.size();
      for (; next_contact != contact_nodes_.end() && *next_contact < to; ++next_contact) {
        const std::size_t node = *next_contact;
        std::array<double, kMostTerms> u{};
        std::array<double, kMostTerms> p{};
        for (std::size_t j = 0; j < terms_; ++j) {
          u[j] = moment_[j][node] - (j == 0 ? start_[node] - equations_->axis()[node] : 0.0);
          p[j] = line_[j][node] + (Predict ? 0.0 : u[j] + (j < 2 ? steady_[j][node] : 0.0));
        }
        if (contact_->resting(node) && stays_at_rest<Predict>(node, u, p, largest)) {
          continue;
        }
        bool touches = contact_->resting(node);
        for (std::size_t r = 0; r < runs.size() && !touches; ++r) {
          touches = node >= runs[r].first && node < runs[r].last && may_touch(runs[r], node, step, p);
        }
        if (touches) {
          apart_.push_back(node);
          touching_.push_back({.node = node, .moment = u, .line = p, .resting = contact_->resting_supports()[node]});
        }
      }
      std::size_t done = from;
      for (const std::size_t node : apart_) {
        map_free<Predict>(done, node, step, largest);
        done = node + 1;
      }
      for (std::size_t k = first_touching; k < touching_.size(); ++k) {
        move_touching<Predict>(touching_[k], step, largest);
      }
      map_free<Predict>(done, to, step, largest);
    }
    finish_tally(largest);
  }

  /// Most resting masses are pressed down all along the step, as a bound of the line's motion tells: nothing to
  /// compute.
  template <bool Predict>
  bool stays_at_rest(std::size_t node, const std::array<double, kMostTerms>& u, const std::array<double, kMostTerms>& p,
                     Largest& largest) {
    for (const ContactRun& run : contact_->runs()) {
      if (!contact_->resting_on(node, run)) {
        continue;
      }
      double pull = run.side * (p[0] + start_[node] - run.height);
      double change = 0.0;
      for (std::size_t j = 0; j < terms_; ++j) {
        pull += j > 0 ? std::abs(p[j]) : 0.0;
        change = std::max(change, Predict ? 0.0 : std::abs(u[j]));
      }
      if (!(pull < 0.0)) {
        return false;
      }
      for (std::size_t j = 0; j < terms_; ++j) {
        moment_[j][node] = j == 0 ? start_[node] - equations_->axis()[node] : 0.0;
        line_[j][node] = p[j];
      }
      end_.position[node] = run.height;
      end_.velocity[node] = 0.0;
      largest.change = std::max(largest.change, change);
      largest.last = std::max(largest.last, std::abs(p[terms_ - 1]));
      largest.before = std::max(largest.before, std::abs(p[terms_ - 2]));
      pressed_.push_back({.run = &run, .node = node});
      apart_.push_back(node);
      return true;
    }
    return false;
  }

  template <bool Predict>
  void map_free(std::size_t from, std::size_t to, double step, Largest& largest) {
    if (from >= to) {
      return;
    }
    Rows rows{};
    for (std::size_t j = 0; j < terms_; ++j) {
      rows.moment[j] = moment_[j].data() + from;
      rows.line[j] = line_[j].data() + from;
    }
    rows.steady = {steady_[0].data() + from, steady_[1].data() + from};
    rows.position = start_ + from;
    rows.axis = equations_->axis().data() + from;
    rows.velocity = start_ + count_ + from;
    rows.place = end_.position.data() + from;
    rows.speed = end_.velocity.data() + from;
    map_masses(terms_, Predict, rows, to - from, map_, step, largest);
  }

  template <bool Predict>
  void move_touching(const Touching& mass, double step, Largest& largest) {
    const std::size_t node = mass.node;
    for (std::size_t j = 0; j < terms_; ++j) {
      line_[j][node] = mass.line[j];
    }
    largest.last = std::max(largest.last, std::abs(mass.line[terms_ - 1]));
    largest.before = std::max(largest.before, std::abs(mass.line[terms_ - 2]));
    const Meeting meeting = meeting_of(mass, step);
    const local::Outcome outcome = local::advance(meeting.problem);
    std::array<double, kMostTerms> residual{};
    for (std::size_t j = 0; j < terms_; ++j) {
      residual[j] = outcome.moments[j] - mass.moment[j];
      largest.change = std::max(largest.change, std::abs(residual[j]));
      tally_.most[Tally::broken] += std::isfinite(mass.line[j]) ? 0.0 : 1.0;  // a mass at rest would not show it
    }
    for (std::size_t j = 0; j < terms_; ++j) {
      double next = Predict ? outcome.moments[j] : mass.moment[j];
      for (std::size_t k = 0; k < terms_ && !Predict; ++k) {
        next += map_.gain[j][k] * residual[k];
      }
      moment_[j][node] = next + (j == 0 ? start_[node] - equations_->axis()[node] : 0.0);
    }
    end_.position[node] = start_[node] + outcome.displacement;
    end_.velocity[node] = outcome.velocity / step;
    if (outcome.resting >= 0) {
      end_.position[node] = meeting.runs[static_cast<std::size_t>(outcome.resting)]->height;
      end_.velocity[node] = 0.0;
    }
    if (outcome.impacts > 0) {
      const auto bin = std::min(static_cast<std::size_t>(outcome.first_impact * kBins), kBins - 1);
      tally_.most[Tally::kink] = std::max(tally_.most[Tally::kink], kink_share(node) * outcome.kick);
      tally_.kick[bin] += equations_->line().mass()[node] * outcome.kick;
      tally_.first[bin] = std::min(tally_.first[bin], outcome.first_impact);
    }
  }

  void finish_tally(const Largest& largest) {
    auto& most = tally_.most;
    most[Tally::change] = largest.change;
    most[Tally::last_term] = largest.last;
    most[Tally::term_before] = largest.before;
    double zero = 0.0;
    for (std::size_t i = 0; i < count_; ++i) {
      zero += 0.0 * (end_.position[i] + end_.velocity[i]);
    }
    most[Tally::broken] += zero == 0.0 ? 0.0 : 1.0;
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

  /// Tells contact what happened in the step: the touching masses once more, now that the line's motion is final.
  void write_journal() {
    struct Journal {
      const Impact* self;
      const Meeting* meeting;
      std::size_t node;
      [[nodiscard]] const ContactRun& run(int stop) const { return *meeting->runs[static_cast<std::size_t>(stop)]; }
      [[nodiscard]] double at(double tau) const { return self->begin_ + tau * self->length_; }
      [[nodiscard]] double energy(double speed) const {
        return 0.5 * self->equations_->line().mass()[node] * speed * speed;
      }
      void impact(int stop, double tau, double before, double after) const {
        const double v0 = before / self->length_;
        const double v1 = after / self->length_;
        self->contact_->hit(run(stop), node, at(tau), v0, v1, energy(v0) - energy(v1));
      }
      void rest(int stop, double tau, double speed) const {
        self->contact_->rest(run(stop), node, at(tau), energy(speed / self->length_));
      }
      void release(int stop, double tau) const { self->contact_->release(run(stop), node, at(tau)); }
      void pressed(int stop, double stretch) const { self->press(run(stop), node, stretch); }
    };
    for (const auto& [run, node] : pressed_) {
      const double stretch = line_[0][node] + start_[node] - run->height;  // its mean
      press(*run, node, stretch);
    }
    for (const Touching& mass : touching_) {
      const Meeting meeting = meeting_of(mass, length_);
      local::advance(meeting.problem, Journal{.self = this, .meeting = &meeting, .node = mass.node});
    }
  }

  /// @param stretch of the mass at rest, its integral over the step's own time [m]
  void press(const ContactRun& run, std::size_t node, double stretch) const {
    contact_->press(run.support, -wf_ * wf_ * equations_->line().mass()[node] * stretch * length_);
  }

  /// Offers the smallest distance of the line from the supports in this step.
  void track_line() {
    for (const ContactRun& run : contact_->runs()) {
      for (std::size_t node = run.first; node < run.last; ++node) {
        double low = run.side * (start_[node] + line_[0][node] - run.height);
        for (std::size_t j = 1; j < terms_; ++j) {
          low -= std::abs(line_[j][node]);
        }
        if (!contact_->smallest(low)) {
          continue;
        }
        const auto powers = line_powers(node);
        for (int k = 1; k <= 8; ++k) {
          const double tau = 0.125 * k;
          const double line = start_[node] + local::detail::value(powers.data(), terms_, tau);
          contact_->line_at(run.side * (line - run.height), node, begin_ + tau * length_);
        }
      }
    }
  }

  PetscInt moments_ = 4;
  std::size_t terms_ = 4;
  double longest_ = 0.0;
  MassState end_;
  std::array<std::vector<double>, kMostTerms> moment_;
  std::array<std::vector<double>, kMostTerms> line_;
  std::array<std::vector<double>, 2> steady_;
  bool steady_known_ = false;
  std::vector<double> work_;
  std::vector<std::size_t> contact_nodes_;
  std::vector<Touching> touching_;
  std::vector<Pressed> pressed_;    // at rest all along the step
  std::vector<std::size_t> apart_;  // of a block: not for the dense map
  DenseMap map_;
  double kink_integral_ = 0.0;
  Tally tally_;
  MPI_Datatype tally_type_ = MPI_DATATYPE_NULL;
  MPI_Op tally_op_ = MPI_OP_NULL;
  double polynomial_step_ = 0.0;  // over which `line_` is a polynomial [s]
  bool from_end_ = true;          // the next step starts at its end, not at its start
  double next_step_ = 0.0;
  double error_ = 0.0;
  PetscInt sweeps_ = 0;
  PetscInt cuts_ = 0;
};

}  // namespace

PetscErrorCode register_ts_impact() { return petsc::register_integrator<Impact>(kTsImpact); }

}  // namespace udar
