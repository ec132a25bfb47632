#include "udar/integrators/touching_masses.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "udar/contact/impact_law.hpp"
#include "udar/filter/own_share.hpp"
#include "udar/local/step_maps.hpp"
#include "udar/numerics/power_series.hpp"

namespace udar {

TouchingMasses::TouchingMasses(Sweep& sweep, ContactState& contact, FilteredStructure& structure)
    : sweep_{&sweep},
      contact_{&contact},
      history_{contact},
      supports_{sweep, contact, history_},
      line_distance_{sweep, contact, supports_} {
  free_.fill(1.0);
  kink_share_.assign(contact.sets().empty() ? 0 : sweep.count, 0.0F);
  std::vector<std::size_t> nodes;
  for (const ContactSet& set : contact.sets()) {
    for (std::size_t node = set.first; node < set.last; ++node) {
      nodes.push_back(node);
    }
  }
  std::ranges::sort(nodes);
  nodes.erase(std::ranges::unique(nodes).begin(), nodes.end());
  const std::vector<float> shares = own_shares(structure, nodes);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    kink_share_[nodes[i]] = shares[i];
  }
}

void TouchingMasses::begin(Tally& tally) {
  tally_ = &tally;
  supports_.begin();
  touching_.clear();
  resting_.clear();
  waiting_.count = 0;
}

const double* TouchingMasses::take_out(std::size_t from, std::size_t to, SweepMaxima& largest) {
  const auto sets = supports_.sets_at(from);
  first_touching_ = touching_.size();
  first_resting_ = resting_.size();
  listed_ = 0;
  if (!sets.empty()) {
    bound_masses(sweep_->terms, sweep_->predict, sweep_->rows(from), to - from, sweep_->reach, sweep_->step,
                 {.low = bounds_.low.data(),
                  .high = bounds_.high.data(),
                  .line_low = bounds_.line_low.data(),
                  .line_high = bounds_.line_high.data()});
    find_touching(from, to, sets, largest);
  }
  return free_.data();
}

void TouchingMasses::move(std::size_t from, SweepMaxima& largest) {
  for (std::size_t k = first_resting_; k < resting_.size(); ++k) {
    keep_at_rest(resting_[k]);
    free_[resting_[k].node - from] = 1.0;
  }
  for (std::size_t k = first_touching_; k < touching_.size(); ++k) {
    free_[touching_[k].node - from] = 1.0;
    move_touching(k, block_moments_[k - first_touching_], largest);
  }
}

void TouchingMasses::finish(SweepMaxima& largest) { finish_batch(largest); }

void TouchingMasses::at(double tau, std::span<double> position, std::span<double> velocity,
                        std::span<std::uint8_t> resting) const {
  for (const auto& [set, node] : resting_) {
    position[node] = set->height(node);
    velocity[node] = 0.0;
    resting[node] = 1;
  }
  for (const MovingMass& mass : touching_) {
    local::Problem problem = supports_.problem(mass.node, mass.resting).problem;
    problem.until = tau;
    problem.moments = false;
    const local::Outcome outcome = local::advance(problem);
    position[mass.node] = sweep_->start[mass.node] + outcome.displacement;
    velocity[mass.node] = outcome.velocity / sweep_->step;
    resting[mass.node] = outcome.resting >= 0 ? 1 : 0;
  }
}

void TouchingMasses::integrals(double tau, std::span<double> sums) const {
  const auto integral = [&](std::size_t node, std::int32_t resting) {
    local::Problem problem = supports_.problem(static_cast<std::uint32_t>(node), resting).problem;
    problem.until = tau;
    return sweep_->step * (tau * sweep_->start[node] + local::advance(problem).moments[0]);
  };
  for (std::size_t node = 0; node < sums.size(); ++node) {
    sums[node] = integral(node, 0);
  }
  for (const auto& [set, node] : resting_) {
    sums[node] = sweep_->step * tau * set->height(node);
  }
  for (const MovingMass& mass : touching_) {
    sums[mass.node] = integral(mass.node, mass.resting);
  }
}

void TouchingMasses::find_touching(std::size_t from, std::size_t to, std::span<const std::size_t> sets,
                                   SweepMaxima& largest) {
  for (const std::size_t index : sets) {
    const ContactSet& set = contact_->sets()[index];
    const std::span<const double> bound = set.side > 0.0 ? bounds_.low : bounds_.high;
    const std::span<const double> line = set.side > 0.0 ? bounds_.line_high : bounds_.line_low;
    const std::size_t first = std::max(from, set.first);
    const std::size_t last = std::min(to, set.last);
    const auto [lowest, highest] = supports_.bounds_of_lift(index);
    mark_near({.side = set.side,
               .height = set.level + (set.side > 0.0 ? highest : lowest),
               .heights = set.profile.empty() ? nullptr : set.profile.data() + (first - set.first),
               .together = contact_->touching_distance(0.0, set.level)},
              last - first, sweep_->start + first, bound.data() + (first - from),
              contact_->resting_supports().data() + first, bounds_.near.data());
    for (std::size_t near = next_near(0, last - first); near < last - first; near = next_near(near + 1, last - first)) {
      const std::size_t node = first + near;
      const std::size_t i = node - from;
      if (free_[i] == 0.0) {
        continue;
      }
      if (contact_->resting(node)) {
        if (!contact_->resting_on(node, set)) {
          continue;
        }
        // Most resting masses are pressed down all along the step: nothing to compute.
        if (set.plain() && set.side * (sweep_->start[node] + line[i] - set.height(node)) < 0.0) {
          free_[i] = 0.0;
          resting_.push_back({.set = &set, .node = node});
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
  while (i < count && i % sizeof eight != 0 && bounds_.near[i] == 0) {
    ++i;
  }
  while (i % sizeof eight == 0 && i + sizeof eight <= count) {
    std::memcpy(&eight, bounds_.near.data() + i, sizeof eight);
    if (eight != 0) {
      break;
    }
    i += sizeof eight;
  }
  while (i < count && bounds_.near[i] == 0) {
    ++i;
  }
  return i;
}

void TouchingMasses::keep_at_rest(const RestingMass& mass) {
  for (std::size_t j = 0; j < sweep_->unknowns(); ++j) {
    sweep_->set_moment(j, mass.node, 0.0);
  }
  sweep_->end[mass.node] = mass.set->height(mass.node);
  sweep_->end[sweep_->count + mass.node] = 0.0;
}

void TouchingMasses::move_touching(std::size_t index, const Moments& before, SweepMaxima& largest) {
  MovingMass& mass = touching_[index];
  const std::size_t node = mass.node;
  double sum = 0.0;
  for (std::size_t j = 0; j < sweep_->terms; ++j) {
    sum += sweep_->drive(j)[node];
  }
  largest.finite = largest.finite && std::isfinite(sum);  // a mass at rest would not show it
  const ContactSet* only = nullptr;
  bool simple = mass.resting == 0;
  for (const std::size_t at : supports_.sets_at(node)) {
    const ContactSet& set = contact_->sets()[at];
    if (node >= set.first && node < set.last) {
      simple = simple && set.plain() && !sweep_->damped() && only == nullptr &&
               set.side * (sweep_->start[node] - set.height(node)) >
                   contact_->touching_distance(sweep_->start[node], set.height(node));
      only = &set;
      mass.set = static_cast<std::int32_t>(at);
    }
  }
  if (!simple || only == nullptr) {
    return move_alone(mass, before, largest);
  }
  for (std::size_t j = 0; j < sweep_->terms; ++j) {
    waiting_.batch.line[j][waiting_.count] = sweep_->drive(j)[node];
  }
  waiting_.batch.velocity[waiting_.count] = sweep_->start[sweep_->count + node] * sweep_->step;
  waiting_.batch.at[waiting_.count] = only->height(node) - sweep_->start[node];
  waiting_.batch.side[waiting_.count] = only->side;
  waiting_.batch.restitution[waiting_.count] = only->law.restitution;
  waiting_.batch.yield_speed[waiting_.count] = only->law.yield_speed * sweep_->step;
  waiting_.mass[waiting_.count] = index;
  waiting_.before[waiting_.count] = before;
  if (++waiting_.count == local::kLanes) {
    finish_batch(largest);
  }
}

void TouchingMasses::finish_batch(SweepMaxima& largest) {
  if (waiting_.count == 0) {
    return;
  }
  local::advance(waiting_.batch, sweep_->angle(), sweep_->terms, sweep_->powers(),
                 contact_->parameters().hop_tolerance);
  for (std::size_t lane = 0; lane < waiting_.count; ++lane) {
    MovingMass& mass = touching_[waiting_.mass[lane]];
    if (waiting_.batch.simple[lane] == 0.0) {
      move_alone(mass, waiting_.before[lane], largest);
      continue;
    }
    local::Outcome outcome;
    for (std::size_t j = 0; j < sweep_->terms; ++j) {
      outcome.moments[j] = waiting_.batch.moments[j][lane];
    }
    outcome.displacement = waiting_.batch.displacement[lane];
    outcome.velocity = waiting_.batch.end_velocity[lane];
    mass.known = waiting_.batch.rests[lane] == 0.0;  // a rest is told by going through it
    if (waiting_.batch.impact[lane] <= 1.0) {
      outcome.impacts = 1;
      outcome.first_impact = waiting_.batch.impact[lane];
      outcome.kick = std::abs(waiting_.batch.after[lane] - waiting_.batch.before[lane]);
      mass.before = waiting_.batch.before[lane];
    }
    mass.impact = outcome.first_impact;
    const ContactSet* rests = mass.known ? nullptr : &set_of(mass);
    take(mass, waiting_.before[lane], outcome, rests, largest);
  }
  waiting_.count = 0;
}

void TouchingMasses::move_alone(const MovingMass& mass, const Moments& before, SweepMaxima& largest) {
  const StopProblem stops = supports_.problem(mass.node, mass.resting);
  const local::Outcome outcome = local::advance(stops.problem);
  const auto stop = static_cast<std::size_t>(outcome.resting);
  take(mass, before, outcome, outcome.resting < 0 ? nullptr : stops.sets[stop], largest);
}

const ContactSet& TouchingMasses::set_of(const MovingMass& mass) const {
  return contact_->sets()[static_cast<std::size_t>(mass.set)];
}

void TouchingMasses::take(const MovingMass& mass, const Moments& before, const local::Outcome& outcome,
                          const ContactSet* rests, SweepMaxima& largest) {
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

/// Writes what happens to one mass of the step into the journal of contact.
class TouchingMasses::Recorder final : public local::Journal {
 public:
  Recorder(const TouchingMasses& all, const StopProblem& stops, std::size_t node)
      : all_{&all}, stops_{&stops}, node_{node} {}

  void impact(int stop, double tau, double before, double after) override {
    all_->record_impact(set(stop), node_, tau, before, after, ground(stop, tau));
  }
  void rest(int stop, double tau, double speed) override {
    const double step = all_->sweep_->step;
    const double push = -set(stop).side * speed;
    all_->contact_->bring_to_rest(node_, set(stop), at(tau), all_->energy(node_, speed / step));
    if (speed != 0.0) {  // the support also took what is left of the rebound
      const double change = push / step;
      journal().record_impulse(set(stop).support, mass() * change, at(tau));
      journal().record_flow({.work = mass() * change * ground(stop, tau) / step});
    }
  }
  void release(int stop, double tau) override { all_->contact_->release(node_, set(stop), at(tau)); }
  void pressed(int stop, double push, double work) override { all_->record_force(set(stop), node_, push, work); }
  void damped(double loss) override {
    const double step = all_->sweep_->step;
    journal().record_flow({.damped = mass() * loss / (step * step)});
  }
  void touched(double from, double until) override { journal().record_contact_time(node_, {at(from), at(until)}); }

 private:
  [[nodiscard]] ContactJournal& journal() const { return all_->contact_->journal(); }
  [[nodiscard]] const ContactSet& set(int stop) const { return *stops_->sets[static_cast<std::size_t>(stop)]; }
  [[nodiscard]] double at(double tau) const { return all_->sweep_->begin + tau * all_->sweep_->step; }
  [[nodiscard]] double mass() const { return all_->sweep_->mass[node_]; }
  [[nodiscard]] double ground(int stop, double tau) const {
    return stops_->problem.stops[static_cast<std::size_t>(stop)].speed(tau);
  }

  const TouchingMasses* all_;
  const StopProblem* stops_;
  std::size_t node_;
};

void TouchingMasses::write_journal() {
  for (const auto& [set, node] : resting_) {
    const double stretch = sweep_->drive(0)[node] + sweep_->start[node] - set->height(node);  // its mean
    record_force(*set, node, -sweep_->angle() * sweep_->angle() * stretch, 0.0);
  }
  for (const MovingMass& mass : touching_) {
    if (mass.known) {
      if (mass.impact <= 1.0) {
        const ContactSet& set = set_of(mass);
        const double after = set.side * set.law.per_step(sweep_->step).after(set.side * mass.before);
        record_impact(set, mass.node, mass.impact, mass.before, after, 0.0);
      }
      continue;
    }
    StopProblem stops = supports_.problem(mass.node, mass.resting);
    stops.problem.moments = false;
    Recorder recorder{*this, stops, mass.node};
    const local::Outcome outcome = local::advance(stops.problem, &recorder);
    for (std::size_t stop = 0; stop < stops.sets.size(); ++stop) {
      if (stops.sets[stop] != nullptr) {
        history_.note(*stops.sets[stop], mass.node, outcome.largest[stop]);
      }
    }
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
  for (const MovingMass& mass : touching_) {
    if (!mass.known) {
      StopProblem stops = supports_.problem(mass.node, mass.resting);
      local::Problem& problem = stops.problem;
      problem.until = tau;
      problem.moments = false;
      FlowOfMass counter{problem};
      const local::Outcome outcome = local::advance(problem, &counter);
      for (std::size_t stop = 0; stop < stops.sets.size(); ++stop) {
        if (const ContactSet* set = stops.sets[stop]; set != nullptr && set->contact_law) {
          const double gap = set->side * (outcome.displacement - problem.stops[stop].place(tau));
          all.stored += sweep_->mass[mass.node] / set->carried * set->contact_law->stored(-gap, outcome.largest[stop]);
        }
      }
      const EnergyFlow& one = counter.sum();
      const double scale = sweep_->mass[mass.node] / (sweep_->step * sweep_->step);
      all.work += scale * one.work;
      all.damped += scale * one.damped;
    }
  }
  return all;
}

double TouchingMasses::stored(double time, std::span<const double> position) const {
  double sum = 0.0;
  for (const ContactSet& set : contact_->sets()) {
    const double lift = set.contact_law ? set.lift(time).height : 0.0;
    for (std::size_t node = set.first; node < set.last && set.contact_law; ++node) {
      const double gap = set.side * (position[node] - set.height(node) - lift);
      sum += sweep_->mass[node] / set.carried * set.contact_law->stored(-gap, history_.largest(set, node));
    }
  }
  return sum;
}

double TouchingMasses::energy(std::size_t node, double speed) const { return 0.5 * sweep_->mass[node] * speed * speed; }

void TouchingMasses::record_impact(const ContactSet& set, std::size_t node, double tau, double before, double after,
                                   double ground) const {
  const double v0 = before / sweep_->step;
  const double v1 = after / sweep_->step;
  const double v = ground / sweep_->step;
  const double impulse = sweep_->mass[node] * (v1 - v0);
  contact_->journal().record_impact(node, {.time = sweep_->begin + tau * sweep_->step,
                                           .support = set.support,
                                           .velocity_before = v0,
                                           .velocity_after = v1,
                                           .impulse = impulse,
                                           .energy_loss = energy(node, v0 - v) - energy(node, v1 - v)});
  contact_->journal().record_flow({.work = impulse * v});
}

void TouchingMasses::record_force(const ContactSet& set, std::size_t node, double push, double work) const {
  contact_->journal().record_force(set.support, sweep_->mass[node] * push / sweep_->step);
  contact_->journal().record_flow({.work = sweep_->mass[node] * work / (sweep_->step * sweep_->step)});
}

}  // namespace udar
