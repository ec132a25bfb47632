#include "udar/dynamics/ts_impact.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>

#include "udar/dynamics/dense_map.hpp"
#include "udar/dynamics/local_batch.hpp"
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

/// Bernstein coefficient `i` of a power series on [0, 1] up to `degree`.
double bernstein(const double* series, std::size_t degree, std::size_t i) {
  double sum = 0.0;
  double share = 1.0;  // binomial(i, k) / binomial(degree, k)
  for (std::size_t k = 0; k <= i; ++k) {
    sum += share * series[k];
    share *= k < degree ? static_cast<double>(i - k) / static_cast<double>(degree - k) : 0.0;
  }
  return sum;
}

/// Bernstein coefficients and what is beyond, of the power series of a mass on the line's motion P [m].
void bound_series(double angle, const std::array<double, kMostTerms>& line, double velocity,
                  std::array<double, kBounds>& bounds, double& rest) {
  std::array<double, local::kMostPowers> series{};
  series[1] = velocity;
  for (std::size_t k = 0; k + 2 < series.size(); ++k) {
    series[k + 2] =
        angle * angle * ((k < kMostTerms ? line[k] : 0.0) - series[k]) / static_cast<double>((k + 1) * (k + 2));
  }
  rest = 0.0;
  for (std::size_t k = kBounds; k < series.size(); ++k) {
    rest += std::abs(series[k]);
  }
  for (std::size_t i = 0; i < kBounds; ++i) {
    bounds[i] = bernstein(series.data(), kBounds - 1, i);
  }
}

Reach reach_of(double angle, std::size_t terms) {
  Reach reach;
  bound_series(angle, {}, 1.0, reach.start, reach.rest_of_start);
  for (std::size_t j = 0; j < terms; ++j) {
    bound_series(angle, local::kLegendre[j], 0.0, reach.line[j], reach.rest_of_line[j]);
  }
  return reach;
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
        line_[0][i] -= end_[i] - start_[i];
      }
      release_if_large(touching_);
    }
    ProblemStepper::begin_step();
  }

  bool advance() override {
    double step = enter_step(longest_);
    bool accepted = false;
    double next = step;
    for (int attempt = 0; !accepted; ++attempt) {
      if (attempt > kMostAttempts) {
        return false;
      }
      const bool settled = sweep(step);
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
    write_journal();
    track_line();
    return true;
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
  [[nodiscard]] double streamed_bytes() const override {
    const auto m = static_cast<double>(terms_);
    std::size_t contact_nodes = 0;
    for (const ContactRun& run : contact_->runs()) {
      contact_nodes += run.last - run.first;
    }
    // A sweep: moments and line read and written; steady part, position, velocity, axis read; ends written. To
    // predict: the line twice, moments written. A step: the state copied, the line counted anew.
    const double per_node = 8.0 * ((4.0 * m + 6.0) * sweeps_ + (4.0 * m + 3.0) * attempts_ + 8.0 * own_steps_);
    // Who rests, and the line's distance at the end.
    const double per_contact_node = 4.0 * (sweeps_ + attempts_) + 8.0 * (m + 1.0) * own_steps_;
    return per_node * static_cast<double>(count_) + per_contact_node * static_cast<double>(contact_nodes);
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

  using Moments = std::array<double, kMostTerms>;

  /// A mass that may touch something in this step. One for every mass of a flat fall: kept small.
  struct Touching {
    std::uint32_t node = 0;
    std::int32_t resting = 0;  // support + 1 at the start of the step
    std::int32_t run = 0;      // of the following
    bool known = false;        // all it meets is one impact of the following, or none
    double impact = 2.0;       // tau; 2: none
    double before = 0.0;       // velocity [m per step]
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
    steady_[0].assign(count_, 0.0);
    steady_[1].assign(equations_->loads().time_dependent() ? count_ : 0, 0.0);
    end_ = petsc::WriteArray{state_}.values();  // stays where it is, too
    free_.fill(1.0);
    for (std::size_t j = 0; j < terms_; ++j) {
      for (std::size_t i = 0; i < terms_; ++i) {
        line_bernstein_[i][j] = bernstein(local::kLegendre[j].data(), terms_ - 1, i);
      }
    }
    kink_share_.assign(contact_->runs().empty() ? 0 : count_, 0.0F);
    for (std::size_t from = 0; from < count_; from += kBlock) {
      first_run_.push_back(block_runs_.size());
      for (std::size_t index = 0; index < contact_->runs().size(); ++index) {
        const ContactRun& run = contact_->runs()[index];
        const std::size_t first = std::max(run.first, from);
        const std::size_t last = std::min(run.last, from + kBlock);
        if (first < last) {
          block_runs_.push_back(index);
        }
        for (std::size_t node = first; node < last; ++node) {
          kink_share_[node] = static_cast<float>(kink_share(node));
        }
      }
    }
    first_run_.push_back(block_runs_.size());
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
    std::array<double*, kMostTerms> lines{};
    for (std::size_t j = 0; j < terms_; ++j) {
      lines[j] = line_[j].data();
    }
    change_basis(terms_, lines, count_, change);
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
    ++attempts_;
    map_ = dense_map(wf_ * step, terms_);
    map_.gain = sweep_gain(map_.line, terms_);
    reach_ = reach_of(wf_ * step, terms_);
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
    for (const std::size_t of_block : runs_at(node)) {
      const ContactRun& run = contact_->runs()[of_block];
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
    const double decay = std::sqrt(std::sqrt(4.0 / (compliance * bed)));
    return std::min(1.0, (end ? 2.0 : 0.5) * length / decay);
  }

  /// Local motion of all masses: moments for the next sweep, end of the step, line polynomial in place of the stretch.
  template <bool Predict>
  void move(double step) {
    const petsc::LogScope scope{petsc::log_events().local_motion};
    tally_ = {};
    touching_.clear();
    pressed_.clear();
    waiting_ = 0;
    Largest largest;
    for (std::size_t from = 0; from < count_; from += kBlock) {
      const std::size_t to = std::min(from + kBlock, count_);
      const auto runs = runs_at(from);
      const std::size_t first_touching = touching_.size();
      const std::size_t first_pressed = pressed_.size();
      listed_ = 0;
      const Rows rows = rows_from(from);
      if (!runs.empty()) {
        bound_masses(
            terms_, Predict, rows, to - from, reach_, step,
            {.low = low_.data(), .high = high_.data(), .line_low = line_low_.data(), .line_high = line_high_.data()});
        find_touching<Predict>(from, to, runs, largest);
      }
      map_masses(terms_, Predict, rows, to - from, map_, step, largest);
      for (std::size_t k = first_pressed; k < pressed_.size(); ++k) {
        hold(pressed_[k]);
        free_[pressed_[k].node - from] = 1.0;
      }
      for (std::size_t k = first_touching; k < touching_.size(); ++k) {
        free_[touching_[k].node - from] = 1.0;
        move_touching<Predict>(k, block_moments_[k - first_touching], step, largest);
      }
    }
    finish_batch<Predict>(step, largest);
    finish_tally(largest);
  }

  /// Lists the masses of a block that may touch something in this step, by bounds of their motion; takes them out of
  /// what is free.
  template <bool Predict>
  void find_touching(std::size_t from, std::size_t to, std::span<const std::size_t> runs, Largest& largest) {
    for (const std::size_t index : runs) {
      const ContactRun& run = contact_->runs()[index];
      const std::span<const double> bound = run.side > 0.0 ? low_ : high_;
      const std::span<const double> line = run.side > 0.0 ? line_high_ : line_low_;
      const std::size_t first = std::max(from, run.first);
      const std::size_t last = std::min(to, run.last);
      mark_near({.side = run.side, .height = run.height, .together = contact_->together(0.0, run.height)}, last - first,
                start_ + first, bound.data() + (first - from), contact_->resting_supports().data() + first,
                near_.data());
      for (std::size_t near = next_near(0, last - first); near < last - first;
           near = next_near(near + 1, last - first)) {
        const std::size_t node = first + near;
        const std::size_t i = node - from;
        if (free_[i] == 0.0) {
          continue;
        }
        if (contact_->resting(node)) {
          if (!contact_->resting_on(node, run)) {
            continue;
          }
          // Most resting masses are pressed down all along the step: nothing to compute.
          if (run.side * (start_[node] + line[i] - run.height) < 0.0) {
            free_[i] = 0.0;
            pressed_.push_back({.run = &run, .node = node});
            for (std::size_t j = 0; j < terms_ && !Predict; ++j) {
              largest.change = std::max(largest.change, std::abs(moment(j, node)));
            }
            continue;
          }
        }
        free_[i] = 0.0;
        touching_.push_back({.node = static_cast<std::uint32_t>(node), .resting = contact_->resting_supports()[node]});
        Moments& before = block_moments_[listed_++];
        for (std::size_t j = 0; j < terms_; ++j) {
          before[j] = moment(j, node);
        }
      }
    }
  }

  /// The first marked mass from `i` on, `count` if there is none.
  [[nodiscard]] std::size_t next_near(std::size_t i, std::size_t count) const {
    std::uint64_t eight = 0;
    while (i < count && i % sizeof eight != 0 && near_[i] == 0) {
      ++i;
    }
    while (i % sizeof eight == 0 && i + sizeof eight <= count) {
      std::memcpy(&eight, near_.data() + i, sizeof eight);
      if (eight != 0) {
        break;
      }
      i += sizeof eight;
    }
    while (i < count && near_[i] == 0) {
      ++i;
    }
    return i;
  }

  /// Legendre coefficient of the displacement since the start of the step [m], as the line was solved for it.
  [[nodiscard]] double moment(std::size_t j, std::size_t node) const {
    return moment_[j][node] - (j == 0 ? start_[node] - equations_->axis()[node] : 0.0);
  }
  void set_moment(std::size_t j, std::size_t node, double value) {
    moment_[j][node] = value + (j == 0 ? start_[node] - equations_->axis()[node] : 0.0);
  }

  /// Moments and end of a mass that stays at rest.
  void hold(const Pressed& mass) {
    for (std::size_t j = 0; j < terms_; ++j) {
      set_moment(j, mass.node, 0.0);
    }
    end_[mass.node] = mass.run->height;
    end_[count_ + mass.node] = 0.0;
  }

  [[nodiscard]] Rows rows_from(std::size_t from) {
    Rows rows{};
    for (std::size_t j = 0; j < terms_; ++j) {
      rows.moment[j] = moment_[j].data() + from;
      rows.line[j] = line_[j].data() + from;
    }
    rows.steady = {steady_[0].data() + from, steady_[1].empty() ? nothing_.data() : steady_[1].data() + from};
    rows.position = start_ + from;
    rows.axis = equations_->axis().data() + from;
    rows.velocity = start_ + count_ + from;
    rows.free = free_.data();
    rows.place = end_ + from;
    rows.speed = end_ + count_ + from;
    return rows;
  }

  /// Runs that have nodes in the block of a node, by index.
  [[nodiscard]] std::span<const std::size_t> runs_at(std::size_t node) const {
    const std::size_t block = node / kBlock;
    return std::span{block_runs_}.subspan(first_run_[block], first_run_[block + 1] - first_run_[block]);
  }

  /// Moves a mass that may touch something: in the next batch if that may do, else at once.
  template <bool Predict>
  void move_touching(std::size_t index, const Moments& before, double step, Largest& largest) {
    Touching& mass = touching_[index];
    const std::size_t node = mass.node;
    double sum = 0.0;
    for (std::size_t j = 0; j < terms_; ++j) {
      sum += line_[j][node];
    }
    largest.finite = largest.finite && std::isfinite(sum);  // a mass at rest would not show it
    const ContactRun* only = nullptr;
    bool simple = mass.resting == 0;
    for (const std::size_t at : runs_at(node)) {
      const ContactRun& run = contact_->runs()[at];
      if (node >= run.first && node < run.last) {
        simple = simple && only == nullptr &&
                 run.side * (start_[node] - run.height) > contact_->together(start_[node], run.height);
        only = &run;
        mass.run = static_cast<std::int32_t>(at);
      }
    }
    if (!simple) {
      return move_alone<Predict>(mass, before, step, largest);
    }
    for (std::size_t j = 0; j < terms_; ++j) {
      batch_.line[j][waiting_] = line_[j][node];
    }
    batch_.velocity[waiting_] = start_[count_ + node] * step;
    batch_.at[waiting_] = only->height - start_[node];
    batch_.side[waiting_] = only->side;
    batch_.restitution[waiting_] = only->restitution;
    batch_mass_[waiting_] = index;
    batch_before_[waiting_] = before;
    if (++waiting_ == local::kLanes) {
      finish_batch<Predict>(step, largest);
    }
  }

  template <bool Predict>
  void finish_batch(double step, Largest& largest) {
    if (waiting_ == 0) {
      return;
    }
    local::advance(batch_, wf_ * step, terms_, local::powers_for(wf_ * step), contact_->parameters().hop_tolerance);
    for (std::size_t lane = 0; lane < waiting_; ++lane) {
      Touching& mass = touching_[batch_mass_[lane]];
      if (batch_.simple[lane] == 0.0) {
        move_alone<Predict>(mass, batch_before_[lane], step, largest);
        continue;
      }
      local::Outcome outcome;
      for (std::size_t j = 0; j < terms_; ++j) {
        outcome.moments[j] = batch_.moments[j][lane];
      }
      outcome.displacement = batch_.displacement[lane];
      outcome.velocity = batch_.end_velocity[lane];
      mass.known = batch_.rests[lane] == 0.0;  // a rest is told by going through it
      if (batch_.impact[lane] <= 1.0) {
        outcome.impacts = 1;
        outcome.first_impact = batch_.impact[lane];
        outcome.kick = std::abs(batch_.after[lane] - batch_.before[lane]);
        mass.before = batch_.before[lane];
      }
      mass.impact = outcome.first_impact;
      const ContactRun* rests = mass.known ? nullptr : &run_of(mass);
      take<Predict>(mass, batch_before_[lane], outcome, rests, step, largest);
    }
    waiting_ = 0;
  }

  template <bool Predict>
  void move_alone(const Touching& mass, const Moments& before, double step, Largest& largest) {
    const Meeting meeting = meeting_of(mass, step);
    const local::Outcome outcome = local::advance(meeting.problem);
    const auto stop = static_cast<std::size_t>(outcome.resting);
    take<Predict>(mass, before, outcome, outcome.resting < 0 ? nullptr : meeting.runs[stop], step, largest);
  }

  [[nodiscard]] const ContactRun& run_of(const Touching& mass) const {
    return contact_->runs()[static_cast<std::size_t>(mass.run)];
  }

  /// @param before u before the sweep @param rests where it rests at the end; null: nowhere
  template <bool Predict>
  void take(const Touching& mass, const Moments& before, const local::Outcome& outcome, const ContactRun* rests,
            double step, Largest& largest) {
    const std::size_t node = mass.node;
    std::array<double, kMostTerms> residual{};
    for (std::size_t j = 0; j < terms_; ++j) {
      residual[j] = outcome.moments[j] - before[j];
      largest.change = std::max(largest.change, std::abs(residual[j]));
    }
    for (std::size_t j = 0; j < terms_; ++j) {
      double next = Predict ? outcome.moments[j] : before[j];
      for (std::size_t k = 0; k < terms_ && !Predict; ++k) {
        next += map_.gain[j][k] * residual[k];
      }
      set_moment(j, node, next);
    }
    end_[node] = rests != nullptr ? rests->height : start_[node] + outcome.displacement;
    end_[count_ + node] = rests != nullptr ? 0.0 : outcome.velocity / step;
    largest.finite = largest.finite && std::isfinite(end_[node]) && std::isfinite(end_[count_ + node]);
    if (outcome.impacts > 0) {
      const auto bin = std::min(static_cast<std::size_t>(outcome.first_impact * kBins), kBins - 1);
      tally_.most[Tally::kink] =
          std::max(tally_.most[Tally::kink], static_cast<double>(kink_share_[node]) * outcome.kick);
      tally_.kick[bin] += equations_->line().mass()[node] * outcome.kick;
      tally_.first[bin] = std::min(tally_.first[bin], outcome.first_impact);
    }
  }

  void finish_tally(const Largest& largest) {
    auto& most = tally_.most;
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

  /// Tells contact what happened in the step: the touching masses once more, now that the line's motion is final.
  void write_journal() {
    struct Journal {
      const Impact* self;
      const Meeting* meeting;
      std::size_t node;
      [[nodiscard]] const ContactRun& run(int stop) const { return *meeting->runs[static_cast<std::size_t>(stop)]; }
      [[nodiscard]] double at(double tau) const { return self->begin_ + tau * self->length_; }
      void impact(int stop, double tau, double before, double after) const {
        self->tell_impact(run(stop), node, tau, before, after);
      }
      void rest(int stop, double tau, double speed) const {
        self->contact_->rest(run(stop), node, at(tau), self->energy(node, speed / self->length_));
      }
      void release(int stop, double tau) const { self->contact_->release(run(stop), node, at(tau)); }
      void pressed(int stop, double stretch) const { self->press(run(stop), node, stretch); }
    };
    for (const auto& [run, node] : pressed_) {
      const double stretch = line_[0][node] + start_[node] - run->height;  // its mean
      press(*run, node, stretch);
    }
    contact_->expect(touching_.size());
    for (const Touching& mass : touching_) {
      if (mass.known) {
        if (mass.impact <= 1.0) {
          const ContactRun& run = run_of(mass);
          tell_impact(run, mass.node, mass.impact, mass.before, -run.restitution * mass.before);
        }
        continue;
      }
      const Meeting meeting = meeting_of(mass, length_);
      local::advance(meeting.problem, Journal{.self = this, .meeting = &meeting, .node = mass.node});
    }
  }

  [[nodiscard]] double energy(std::size_t node, double speed) const {
    return 0.5 * equations_->line().mass()[node] * speed * speed;
  }

  /// @param tau of the step @param before, after velocities [m per step]
  void tell_impact(const ContactRun& run, std::size_t node, double tau, double before, double after) const {
    const double v0 = before / length_;
    const double v1 = after / length_;
    contact_->hit(run, node, begin_ + tau * length_, v0, v1, energy(node, v0) - energy(node, v1));
  }

  /// @param stretch of the mass at rest, its integral over the step's own time [m]
  void press(const ContactRun& run, std::size_t node, double stretch) const {
    contact_->press(run.support, -wf_ * wf_ * equations_->line().mass()[node] * stretch * length_);
  }

  /// Offers the smallest distance of the line from the supports in this step.
  void track_line() {
    for (const ContactRun& run : contact_->runs()) {
      block_low_.clear();
      for (std::size_t first = run.first; first < run.last; first += kBlock) {
        const std::size_t count = std::min(kBlock, run.last - first);
        block_low_.push_back(lowest_line(terms_, rows_from(first), count, run.side, line_bernstein_) -
                             run.side * run.height);
      }
      // The lowest blocks first: after one or two no other can be lower.
      for (;;) {
        const auto lowest = std::ranges::min_element(block_low_);
        if (!contact_->smallest(*lowest)) {
          break;
        }
        *lowest = std::numeric_limits<double>::infinity();
        const std::size_t first = run.first + kBlock * static_cast<std::size_t>(lowest - block_low_.begin());
        track_nodes(run, first, std::min(first + kBlock, run.last));
      }
    }
  }

  void track_nodes(const ContactRun& run, std::size_t first, std::size_t last) {
    for (std::size_t node = first; node < last; ++node) {
      const auto powers = line_powers(node);
      for (int k = 1; k <= 8; ++k) {
        const double tau = 0.125 * k;
        const double line = start_[node] + local::detail::value(powers.data(), terms_, tau);
        contact_->line_at(run.side * (line - run.height), node, begin_ + tau * length_);
      }
    }
  }

  PetscInt moments_ = 4;
  std::size_t terms_ = 4;
  double longest_ = 0.0;
  double* end_ = nullptr;  // of the step at hand: the values of the TS's solution, which starts from `start_`
  std::array<std::vector<double>, kMostTerms> moment_;
  std::array<std::vector<double>, kMostTerms> line_;
  std::array<std::vector<double>, 2> steady_;
  bool steady_known_ = false;
  std::vector<double> work_;
  std::vector<std::size_t> block_runs_;  // of every block, by index
  std::vector<std::size_t> first_run_;   // of a block, in `block_runs_`
  std::vector<float> kink_share_;        // of every node
  std::vector<Touching> touching_;
  std::vector<Pressed> pressed_;  // at rest all along the step
  std::array<double, kBlock> nothing_{};
  std::array<double, kBlock> free_{};
  std::array<double, kBlock> low_{};
  std::array<double, kBlock> high_{};
  std::array<double, kBlock> line_low_{};
  std::array<double, kBlock> line_high_{};
  std::array<std::uint8_t, kBlock> near_{};
  local::Batch batch_;
  std::array<std::size_t, local::kLanes> batch_mass_{};
  std::array<Moments, local::kLanes> batch_before_{};  // u before the sweep
  std::array<Moments, kBlock> block_moments_{};        // the same of the touching masses of a block
  std::size_t listed_ = 0;
  std::size_t waiting_ = 0;  // masses in the batch
  Reach reach_;
  Square line_bernstein_{};  // [coefficient][Legendre term]
  std::vector<double> block_low_;
  DenseMap map_;
  double kink_integral_ = 0.0;
  Tally tally_;
  MPI_Datatype tally_type_ = MPI_DATATYPE_NULL;
  MPI_Op tally_op_ = MPI_OP_NULL;
  double polynomial_step_ = 0.0;  // over which `line_` is a polynomial [s]
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
