#include "udar/integrators/touching_masses.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "udar/contact/impact_law.hpp"
#include "udar/local/step_maps.hpp"
#include "udar/numerics/power_series.hpp"

namespace udar {

TouchingMasses::TouchingMasses(Sweep& sweep, ContactState& contact, const BeamChain& beam)
    : sweep_{&sweep}, contact_{&contact}, beam_{&beam}, line_bernstein_{legendre_bernstein(sweep.terms)} {
  free_.fill(1.0);
  kink_share_.assign(contact.runs().empty() ? 0 : sweep.count, 0.0F);
  for (std::size_t from = 0; from < sweep.count; from += kBlock) {
    first_run_.push_back(block_runs_.size());
    for (std::size_t index = 0; index < contact.runs().size(); ++index) {
      const ContactSet& run = contact.runs()[index];
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
  lifts_.resize(contact.runs().size());
}

void TouchingMasses::begin(Tally& tally) {
  tally_ = &tally;
  if (sweep_->begin != lifted_at_ || sweep_->step != lifted_over_) {
    lifted_at_ = sweep_->begin;
    lifted_over_ = sweep_->step;
    for (std::size_t index = 0; index < lifts_.size(); ++index) {
      const ContactSet& run = contact_->runs()[index];
      lifts_[index] = run.motion ? run.motion->cubic(sweep_->begin, sweep_->step) : std::array<double, 4>{};
    }
  }
  touching_.clear();
  pressed_.clear();
  waiting_ = 0;
}

const double* TouchingMasses::take_out(std::size_t from, std::size_t to, Largest& largest) {
  const auto runs = runs_at(from);
  first_touching_ = touching_.size();
  first_pressed_ = pressed_.size();
  listed_ = 0;
  if (!runs.empty()) {
    bound_masses(
        sweep_->terms, sweep_->predict, sweep_->rows(from), to - from, sweep_->reach, sweep_->step,
        {.low = low_.data(), .high = high_.data(), .line_low = line_low_.data(), .line_high = line_high_.data()});
    find_touching(from, to, runs, largest);
  }
  return free_.data();
}

void TouchingMasses::move(std::size_t from, Largest& largest) {
  for (std::size_t k = first_pressed_; k < pressed_.size(); ++k) {
    hold(pressed_[k]);
    free_[pressed_[k].node - from] = 1.0;
  }
  for (std::size_t k = first_touching_; k < touching_.size(); ++k) {
    free_[touching_[k].node - from] = 1.0;
    move_touching(k, block_moments_[k - first_touching_], largest);
  }
}

void TouchingMasses::finish(Largest& largest) { finish_batch(largest); }

void TouchingMasses::at(double tau, std::span<double> position, std::span<double> velocity,
                        std::span<std::uint8_t> resting) const {
  for (const auto& [run, node] : pressed_) {
    position[node] = run->height(node);
    velocity[node] = 0.0;
    resting[node] = 1;
  }
  for (const Touching& mass : touching_) {
    local::Problem problem = meeting_of(mass).problem;
    problem.until = tau;
    const local::Outcome outcome = local::advance(problem);
    position[mass.node] = sweep_->start[mass.node] + outcome.displacement;
    velocity[mass.node] = outcome.velocity / sweep_->step;
    resting[mass.node] = outcome.resting >= 0 ? 1 : 0;
  }
}

TouchingMasses::Meeting TouchingMasses::meeting_of(const Touching& mass) const {
  const std::size_t node = mass.node;
  Meeting meeting;
  meeting.problem = {.angle = sweep_->angle(), .terms = sweep_->terms, .powers = sweep_->powers()};
  local::Problem& problem = meeting.problem;
  problem.drag = sweep_->scale().drag;
  problem.line = sweep_->drive_powers(node);
  problem.turn = sweep_->turn_powers(node);
  problem.velocity = sweep_->start[sweep_->count + node] * sweep_->step;
  problem.hop_tolerance = contact_->parameters().hop_tolerance;
  for (const std::size_t of_block : runs_at(node)) {
    const ContactSet& run = contact_->runs()[of_block];
    if (node < run.first || node >= run.last) {
      continue;
    }
    const std::size_t index = run.side > 0.0 ? 0 : 1;
    local::Stop& stop = problem.stops[index];
    const std::array<double, 4>& lift = lifts_[of_block];
    const double at = run.height(node) + lift[0] - sweep_->start[node];
    const bool rests = mass.resting == run.support + 1;
    const bool held = problem.resting == static_cast<int>(index);
    if (rests || (!held && (!stop.present || run.side * at > run.side * stop.at))) {
      stop = {.at = at,
              .restitution = run.restitution,
              .yield_speed = run.yield_speed * sweep_->step,
              .present = true,
              .moves = run.motion != nullptr,
              .path = {lift[1], lift[2], lift[3]},
              .stiffness = run.stiffness * sweep_->step * sweep_->step,
              .damping = run.damping * sweep_->step};
      meeting.runs[index] = &run;
    }
    if (rests) {
      problem.resting = static_cast<int>(index);
    }
    problem.together = std::max(problem.together, contact_->together(sweep_->start[node], run.height(node)));
    problem.pull_resolution = std::max(problem.pull_resolution, contact_->pull_resolution(run.height(node) + lift[0]));
  }
  return meeting;
}

double TouchingMasses::kink_share(std::size_t node) const {
  const BeamChain& beam = *beam_;
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
  const double bed = beam.mass(global) * sweep_->frequency * sweep_->frequency / length;
  const double decay = std::sqrt(std::sqrt(4.0 / (compliance * bed)));
  return std::min(1.0, (end ? 2.0 : 0.5) * length / decay);
}

void TouchingMasses::find_touching(std::size_t from, std::size_t to, std::span<const std::size_t> runs,
                                   Largest& largest) {
  for (const std::size_t index : runs) {
    const ContactSet& run = contact_->runs()[index];
    const std::span<const double> bound = run.side > 0.0 ? low_ : high_;
    const std::span<const double> line = run.side > 0.0 ? line_high_ : line_low_;
    const std::size_t first = std::max(from, run.first);
    const std::size_t last = std::min(to, run.last);
    const auto [lowest, highest] = reach_of_lift(index);
    mark_near({.side = run.side,
               .height = run.level + (run.side > 0.0 ? highest : lowest),
               .heights = run.profile.empty() ? nullptr : run.profile.data() + (first - run.first),
               .together = contact_->together(0.0, run.level)},
              last - first, sweep_->start + first, bound.data() + (first - from),
              contact_->resting_supports().data() + first, near_.data());
    for (std::size_t near = next_near(0, last - first); near < last - first; near = next_near(near + 1, last - first)) {
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
        if (run.plain() && run.side * (sweep_->start[node] + line[i] - run.height(node)) < 0.0) {
          free_[i] = 0.0;
          pressed_.push_back({.run = &run, .node = node});
          for (std::size_t j = 0; j < sweep_->unknowns() && !sweep_->predict; ++j) {
            largest.change = std::max(largest.change, std::abs(sweep_->moment(j, node)));
          }
          continue;
        }
      }
      free_[i] = 0.0;
      touching_.push_back({.node = static_cast<std::uint32_t>(node), .resting = contact_->resting_supports()[node]});
      Moments& before = block_moments_[listed_++];
      for (std::size_t j = 0; j < sweep_->unknowns(); ++j) {
        before[j] = sweep_->moment(j, node);
      }
    }
  }
}

std::size_t TouchingMasses::next_near(std::size_t i, std::size_t count) const {
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

void TouchingMasses::hold(const Pressed& mass) {
  for (std::size_t j = 0; j < sweep_->unknowns(); ++j) {
    sweep_->set_moment(j, mass.node, 0.0);
  }
  sweep_->end[mass.node] = mass.run->height(mass.node);
  sweep_->end[sweep_->count + mass.node] = 0.0;
}

std::span<const std::size_t> TouchingMasses::runs_at(std::size_t node) const {
  const std::size_t block = node / kBlock;
  return std::span{block_runs_}.subspan(first_run_[block], first_run_[block + 1] - first_run_[block]);
}

void TouchingMasses::move_touching(std::size_t index, const Moments& before, Largest& largest) {
  Touching& mass = touching_[index];
  const std::size_t node = mass.node;
  double sum = 0.0;
  for (std::size_t j = 0; j < sweep_->terms; ++j) {
    sum += sweep_->drive(j)[node];
  }
  largest.finite = largest.finite && std::isfinite(sum);  // a mass at rest would not show it
  const ContactSet* only = nullptr;
  bool simple = mass.resting == 0;
  for (const std::size_t at : runs_at(node)) {
    const ContactSet& run = contact_->runs()[at];
    if (node >= run.first && node < run.last) {
      simple = simple && run.plain() && !sweep_->damped() && only == nullptr &&
               run.side * (sweep_->start[node] - run.height(node)) >
                   contact_->together(sweep_->start[node], run.height(node));
      only = &run;
      mass.run = static_cast<std::int32_t>(at);
    }
  }
  if (!simple || only == nullptr) {
    return move_alone(mass, before, largest);
  }
  for (std::size_t j = 0; j < sweep_->terms; ++j) {
    batch_.line[j][waiting_] = sweep_->drive(j)[node];
  }
  batch_.velocity[waiting_] = sweep_->start[sweep_->count + node] * sweep_->step;
  batch_.at[waiting_] = only->height(node) - sweep_->start[node];
  batch_.side[waiting_] = only->side;
  batch_.restitution[waiting_] = only->restitution;
  batch_.yield_speed[waiting_] = only->yield_speed * sweep_->step;
  batch_mass_[waiting_] = index;
  batch_before_[waiting_] = before;
  if (++waiting_ == local::kLanes) {
    finish_batch(largest);
  }
}

void TouchingMasses::finish_batch(Largest& largest) {
  if (waiting_ == 0) {
    return;
  }
  local::advance(batch_, sweep_->angle(), sweep_->terms, sweep_->powers(), contact_->parameters().hop_tolerance);
  for (std::size_t lane = 0; lane < waiting_; ++lane) {
    Touching& mass = touching_[batch_mass_[lane]];
    if (batch_.simple[lane] == 0.0) {
      move_alone(mass, batch_before_[lane], largest);
      continue;
    }
    local::Outcome outcome;
    for (std::size_t j = 0; j < sweep_->terms; ++j) {
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
    const ContactSet* rests = mass.known ? nullptr : &run_of(mass);
    take(mass, batch_before_[lane], outcome, rests, largest);
  }
  waiting_ = 0;
}

void TouchingMasses::move_alone(const Touching& mass, const Moments& before, Largest& largest) {
  const Meeting meeting = meeting_of(mass);
  const local::Outcome outcome = local::advance(meeting.problem);
  const auto stop = static_cast<std::size_t>(outcome.resting);
  take(mass, before, outcome, outcome.resting < 0 ? nullptr : meeting.runs[stop], largest);
}

const ContactSet& TouchingMasses::run_of(const Touching& mass) const {
  return contact_->runs()[static_cast<std::size_t>(mass.run)];
}

void TouchingMasses::take(const Touching& mass, const Moments& before, const local::Outcome& outcome,
                          const ContactSet* rests, Largest& largest) {
  const std::size_t node = mass.node;
  const std::size_t terms = sweep_->terms;
  const std::size_t unknowns = sweep_->unknowns();
  Moments found{};
  std::ranges::copy(outcome.moments, found.begin());
  found[terms] = outcome.displacement;
  Moments residual{};
  for (std::size_t j = 0; j < unknowns; ++j) {
    residual[j] = found[j] - before[j];
    largest.change = std::max(largest.change, std::abs(residual[j]));
  }
  for (std::size_t j = 0; j < terms && unknowns > terms; ++j) {
    largest.rate = std::max(largest.rate, std::abs(rate_term(j, residual, residual[terms])));
  }
  for (std::size_t j = 0; j < unknowns; ++j) {
    double next = sweep_->predict ? found[j] : before[j];
    for (std::size_t k = 0; k < unknowns && !sweep_->predict; ++k) {
      next += sweep_->map.gain[j][k] * residual[k];
    }
    sweep_->set_moment(j, node, next);
  }
  const bool still = rests != nullptr && rests->plain();
  sweep_->end[node] = still ? rests->height(node) : sweep_->start[node] + outcome.displacement;
  sweep_->end[sweep_->count + node] = still ? 0.0 : outcome.velocity / sweep_->step;
  largest.finite =
      largest.finite && std::isfinite(sweep_->end[node]) && std::isfinite(sweep_->end[sweep_->count + node]);
  if (outcome.impacts > 0) {
    const auto bin = std::min(static_cast<std::size_t>(outcome.first_impact * kBins), kBins - 1);
    tally_->most[Tally::kink] =
        std::max(tally_->most[Tally::kink], static_cast<double>(kink_share_[node]) * outcome.kick);
    tally_->kick[bin] += sweep_->mass[node] * outcome.kick;
    tally_->first[bin] = std::min(tally_->first[bin], outcome.first_impact);
  }
}

/// Tells contact what happens to one mass of the step.
class TouchingMasses::Teller final : public local::Journal {
 public:
  Teller(const TouchingMasses& all, const Meeting& meeting, std::size_t node)
      : all_{&all}, meeting_{&meeting}, node_{node} {}

  void impact(int stop, double tau, double before, double after) override {
    all_->tell_impact(run(stop), node_, tau, before, after, ground(stop, tau));
  }
  void rest(int stop, double tau, double speed) override {
    const double step = all_->sweep_->step;
    const double push = -run(stop).side * speed;
    all_->contact_->rest(run(stop), node_, at(tau), all_->energy(node_, speed / step));
    if (speed != 0.0) {  // the support also took what is left of the rebound
      const double change = push / step;
      all_->contact_->press(run(stop).support, mass() * change, at(tau), at(tau));
      all_->contact_->flow({.work = mass() * change * ground(stop, tau) / step});
    }
  }
  void release(int stop, double tau) override { all_->contact_->release(run(stop), node_, at(tau)); }
  void pressed(int stop, double push, double work) override { all_->press(run(stop), node_, push, work); }
  void damped(double loss) override {
    const double step = all_->sweep_->step;
    all_->contact_->flow({.damped = mass() * loss / (step * step)});
  }
  void touched(double from, double until) override { all_->contact_->touch(node_, at(from), at(until)); }

 private:
  [[nodiscard]] const ContactSet& run(int stop) const { return *meeting_->runs[static_cast<std::size_t>(stop)]; }
  [[nodiscard]] double at(double tau) const { return all_->sweep_->begin + tau * all_->sweep_->step; }
  [[nodiscard]] double mass() const { return all_->sweep_->mass[node_]; }
  [[nodiscard]] double ground(int stop, double tau) const {
    return meeting_->problem.stops[static_cast<std::size_t>(stop)].speed(tau);
  }

  const TouchingMasses* all_;
  const Meeting* meeting_;
  std::size_t node_;
};

void TouchingMasses::write_journal() {
  for (const auto& [run, node] : pressed_) {
    const double stretch = sweep_->drive(0)[node] + sweep_->start[node] - run->height(node);  // its mean
    press(*run, node, -sweep_->angle() * sweep_->angle() * stretch, 0.0);
  }
  contact_->expect(touching_.size());
  for (const Touching& mass : touching_) {
    if (mass.known) {
      if (mass.impact <= 1.0) {
        const ContactSet& run = run_of(mass);
        const double share =
            falling_restitution(run.restitution, run.yield_speed * sweep_->step, std::abs(mass.before));
        tell_impact(run, mass.node, mass.impact, mass.before, -share * mass.before, 0.0);
      }
      continue;
    }
    const Meeting meeting = meeting_of(mass);
    Teller teller{*this, meeting, mass.node};
    static_cast<void>(local::advance(meeting.problem, &teller));
  }
}

namespace {

/// Adds up what flows to one mass besides impacts, over the mass [m^2 per step^2].
class FlowOfMass final : public local::Journal {
 public:
  explicit FlowOfMass(const local::Problem& problem) : problem_{&problem} {}

  void impact(int stop, double tau, double before, double after) override {
    sum_.work += (after - before) * ground(stop, tau);
  }
  void rest(int stop, double tau, double speed) override {
    sum_.work += (stop == 0 ? -speed : speed) * ground(stop, tau);
  }
  void pressed(int /*stop*/, double /*push*/, double work) override { sum_.work += work; }
  void damped(double loss) override { sum_.damped += loss; }
  [[nodiscard]] const EnergyFlow& sum() const { return sum_; }

 private:
  [[nodiscard]] double ground(int stop, double tau) const {
    return problem_->stops[static_cast<std::size_t>(stop)].speed(tau);
  }

  const local::Problem* problem_;
  EnergyFlow sum_;
};

}  // namespace

EnergyFlow TouchingMasses::flow(double tau) const {
  EnergyFlow all;
  for (const Touching& mass : touching_) {
    if (!mass.known) {
      local::Problem problem = meeting_of(mass).problem;
      problem.until = tau;
      FlowOfMass counter{problem};
      static_cast<void>(local::advance(problem, &counter));
      const EnergyFlow& one = counter.sum();
      const double scale = sweep_->mass[mass.node] / (sweep_->step * sweep_->step);
      all.work += scale * one.work;
      all.damped += scale * one.damped;
    }
  }
  return all;
}

double TouchingMasses::energy(std::size_t node, double speed) const { return 0.5 * sweep_->mass[node] * speed * speed; }

void TouchingMasses::tell_impact(const ContactSet& run, std::size_t node, double tau, double before, double after,
                                 double ground) const {
  const double v0 = before / sweep_->step;
  const double v1 = after / sweep_->step;
  const double v = ground / sweep_->step;
  contact_->hit(run, node, sweep_->begin + tau * sweep_->step, v0, v1, energy(node, v0 - v) - energy(node, v1 - v));
  contact_->flow({.work = sweep_->mass[node] * (v1 - v0) * v});
}

void TouchingMasses::press(const ContactSet& run, std::size_t node, double push, double work) const {
  contact_->press(run.support, sweep_->mass[node] * push / sweep_->step);
  contact_->flow({.work = sweep_->mass[node] * work / (sweep_->step * sweep_->step)});
}

std::array<double, 2> TouchingMasses::reach_of_lift(std::size_t run) const {
  if (!contact_->runs()[run].motion) {
    return {0.0, 0.0};
  }
  const auto& c = lifts_[run];
  const std::array<double, 4> bernstein{c[0], c[0] + c[1] / 3.0, c[0] + (2.0 * c[1] + c[2]) / 3.0,
                                        c[0] + c[1] + c[2] + c[3]};
  return {std::ranges::min(bernstein), std::ranges::max(bernstein)};
}

void TouchingMasses::track_line() {
  for (std::size_t index = 0; index < contact_->runs().size(); ++index) {
    const ContactSet& run = contact_->runs()[index];
    const auto [lowest_lift, highest_lift] = reach_of_lift(index);
    const double level = run.level + (run.side > 0.0 ? highest_lift : lowest_lift);
    block_low_.clear();
    for (std::size_t first = run.first; first < run.last; first += kBlock) {
      const std::size_t count = std::min(kBlock, run.last - first);
      const double* heights = run.profile.empty() ? nullptr : run.profile.data() + (first - run.first);
      Rows rows = sweep_->rows(first);
      std::vector<double> line;
      if (!sweep_->corrected.empty()) {
        line.resize(sweep_->terms * kBlock);
        for (std::size_t j = 0; j < sweep_->terms; ++j) {
          rows.line[j] = line.data() + j * kBlock;
          for (std::size_t i = 0; i < count; ++i) {
            rows.line[j][i] = sweep_->line(j, first + i);
          }
        }
      }
      block_low_.push_back(lowest_line(sweep_->terms, rows, count, run.side, heights, line_bernstein_) -
                           run.side * level);
    }
    // The lowest blocks first: after one or two no other can be lower.
    for (;;) {
      const auto lowest = std::ranges::min_element(block_low_);
      if (!contact_->smallest(*lowest)) {
        break;
      }
      *lowest = std::numeric_limits<double>::infinity();
      const std::size_t first = run.first + kBlock * static_cast<std::size_t>(lowest - block_low_.begin());
      track_nodes(index, first, std::min(first + kBlock, run.last));
    }
  }
}

void TouchingMasses::track_nodes(std::size_t index, std::size_t first, std::size_t last) {
  const ContactSet& run = contact_->runs()[index];
  for (std::size_t node = first; node < last; ++node) {
    const auto powers = sweep_->powers([&](std::size_t j) { return sweep_->line(j, node); });
    for (int k = 1; k <= 8; ++k) {
      const double tau = 0.125 * k;
      const double line = sweep_->start[node] + power_series::value(powers.data(), sweep_->terms, tau);
      const double lift = power_series::value(lifts_[index].data(), 4, tau);
      contact_->line_at(run.side * (line - run.height(node) - lift), node, sweep_->begin + tau * sweep_->step);
    }
  }
}

}  // namespace udar
