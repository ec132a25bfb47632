#include "udar/motion/contact_state.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <ranges>

#include "udar/contact/impact_law.hpp"
#include "udar/petsc/log.hpp"

namespace udar {
namespace {

// Masses within this share of the hop tolerance touch together.
constexpr double kTogether = 1e-2;
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

}  // namespace

ContactState::ContactState(const MassPoints& points, const Contacts& contacts, ContactParameters parameters)
    : points_{&points},
      contacts_{&contacts},
      parameters_{parameters},
      resting_(points.points(), 0),
      impulse_(contacts.supports.size(), 0.0),
      pressed_(contacts.supports.size(), 0.0) {
  if (parameters.surface == ContactSurface::mass) {
    runs_ = contacts.sets;
  }
  for (const ContactSet& set : contacts.sets) {
    touchable_.push_back({set.first, set.last});
  }
  std::ranges::sort(touchable_);
  for (std::size_t i = 1; i < touchable_.size(); ++i) {  // supports may share nodes: each belongs to one range
    auto& [first, last] = touchable_[i];
    first = std::max(first, touchable_[i - 1][1]);
    last = std::max(last, first);
  }
  last_contact_.assign(touchable_.empty() ? 0 : points.points(), -std::numeric_limits<double>::infinity());
  line_gap_.gap = std::numeric_limits<double>::infinity();
  gives_way_ = !runs_on_line() && std::ranges::any_of(supports(), &Support::elastic);
  begin_step();
}

double ContactState::spring_energy(double time, std::span<const double> position) const {
  double sum = 0.0;
  for (const ContactSet& run : runs_) {
    const double lift = run.elastic() ? run.lift(time).height : 0.0;
    for (std::size_t node = run.first; run.elastic() && node < run.last; ++node) {
      const double gap = std::min(0.0, run.side * (position[node] - run.height(node) - lift));
      sum += 0.5 * run.stiffness * points_->mass()[node] * gap * gap;
    }
  }
  return sum;
}

double ContactState::together(double position, double height) const {
  return std::max(kTogether * parameters_.hop_tolerance,
                  8.0 * kEpsilon * std::max(std::abs(position), std::abs(height)));
}

double ContactState::pull_resolution(double height) const {
  constexpr double kRoundings = 16.0;  // of places, each half a unit in the last place, and of the solve
  return kRoundings * kEpsilon * (length_ + std::abs(height));
}

void ContactState::set_resting(std::size_t node, PetscInt support) {
  changes_.push_back({.node = node, .before = resting_[node]});
  resting_[node] = support + 1;
  if (support >= 0) {
    ++local_resting_;
  } else {
    --local_resting_;
  }
}

void ContactState::hit(const ContactSet& run, std::size_t node, double time, double before, double after, double loss) {
  strike(run.support, node, time, before, after, points_->mass()[node] * (after - before), loss);
}

void ContactState::strike(PetscInt support, std::size_t node, double time, double before, double after, double impulse,
                          double loss) {
  const PetscInt global = points_->global(node);
  impacts_.push_back({.time = time,
                      .node = global,
                      .x = points_->place(node).x,
                      .support = support,
                      .velocity_before = before,
                      .velocity_after = after,
                      .impulse = impulse,
                      .energy_loss = loss});
}

void ContactState::push(PetscInt support, std::size_t node, double time, double impulse, double loss) {
  losses_.push_back({.time = time, .energy = loss});
  press(support, impulse, time, time);
  touch(node, time, time);
}

void ContactState::rest(const ContactSet& run, std::size_t node, double time, double loss) {
  const PetscInt global = points_->global(node);
  rests_.push_back(
      {.time = time, .node = global, .x = points_->place(node).x, .support = run.support, .release = false});
  set_resting(node, run.support);
  losses_.push_back({.time = time, .energy = loss});
}

void ContactState::release(const ContactSet& run, std::size_t node, double time) {
  const PetscInt global = points_->global(node);
  rests_.push_back(
      {.time = time, .node = global, .x = points_->place(node).x, .support = run.support, .release = true});
  set_resting(node, -1);
}

double ContactState::lost_before(double time) const {
  double sum = 0.0;
  for (const ImpactRecord& impact : impacts_) {
    sum += impact.time < time ? impact.energy_loss : 0.0;
  }
  for (const Loss& loss : losses_) {
    sum += loss.time < time ? loss.energy : 0.0;
  }
  return sum;
}

void ContactState::add_impulses(double time, double passed, std::span<double> sums) const {
  for (const ImpactRecord& impact : impacts_) {
    sums[static_cast<std::size_t>(impact.support)] += impact.time < time ? impact.impulse : 0.0;
  }
  for (std::size_t support = 0; support < pressed_.size(); ++support) {
    sums[support] += passed * pressed_[support];
  }
  for (const Part& part : parts_) {
    const double share = time >= part.to ? 1.0 : time > part.from ? (time - part.from) / (part.to - part.from) : 0.0;
    sums[static_cast<std::size_t>(part.support)] += share * part.impulse;
  }
}

void ContactState::note_contacts(double until) {
  const auto note = [&](PetscInt node, double time) {
    if (time < until) {
      double& last = last_contact_[static_cast<std::size_t>(node - points_->begin())];
      last = std::max(last, time);
    }
  };
  for (const Touch& touch : touches_) {
    if (touch.from < until) {
      last_contact_[touch.node] = std::max(last_contact_[touch.node], std::min(touch.until, until));
    }
  }
  for (const ImpactRecord& impact : impacts_) {
    note(impact.node, impact.time);
  }
  for (const RestRecord& rest : rests_) {
    note(rest.node, rest.time);
  }
}

ContactZone ContactState::zone(double since, double until, std::span<const std::uint8_t> resting) {
  note_contacts(until);
  ContactZone zone;
  for (const auto& [first, last] : touchable_) {
    for (std::size_t node = first; node < last; ++node) {
      if (resting[node] != 0 || last_contact_[node] >= since) {
        const double x = points_->place(node).x;
        ++zone.masses;
        zone.x_min = std::min(zone.x_min, x);
        zone.x_max = std::max(zone.x_max, x);
      }
    }
  }
  return zone;
}

void ContactState::line_at(double gap, std::size_t node, double time) {
  if (smallest(gap)) {
    line_gap_ = {.gap = gap, .x = points_->place(node).x, .time = time};
  }
}

void ContactState::release_pulled(double time, double acceleration, std::span<const double> stretch) {
  for (const ContactSet& run : runs_) {
    const double lift = run.lift(time).acceleration;
    for (std::size_t node = run.first; node < run.last; ++node) {
      if (resting_on(node, run) && run.side * (acceleration * stretch[node] - lift) > 0.0) {
        release(run, node, time);
      }
    }
  }
}

void ContactState::resolve(double time, std::span<const std::int32_t> due, double acceleration,
                           std::span<double> position, std::span<double> velocity, std::span<double> stretch) {
  for (const ContactSet& run : runs_) {
    const SupportMotion::State lift = run.lift(time);
    for (std::size_t node = run.first; node < run.last && !run.elastic(); ++node) {
      const double height = run.height(node) + lift.height;
      const bool is_due = !due.empty() && due[node] == run.support + 1;
      if (resting(node)) {
        if (is_due && resting_on(node, run)) {
          // Just off: else it would be held again by what else happens at this instant.
          stretch[node] = lift.acceleration / acceleration + 2.0 * run.side * pull_resolution(height);
          release(run, node, time);
        }
        continue;
      }
      const double gap = run.side * (position[node] - height);
      if (gap > together(position[node], height) && !is_due) {
        continue;
      }
      const double wf = std::sqrt(acceleration);
      const double resolution = pull_resolution(height);
      TouchingMass mass{.velocity = run.side * (velocity[node] - lift.velocity),
                        .acceleration = run.side * (acceleration * stretch[node] - lift.acceleration),
                        .resolution = acceleration * resolution,
                        .mass = points_->mass()[node]};
      if (std::abs(mass.velocity) <= wf * resolution) {
        mass.velocity = 0.0;  // it stands there, but for rounding
      }
      ContactOutcome outcome = resolve_contact(mass, run.law, parameters_.hop_tolerance);
      // It is to meet the support now, and would not get off it by the tolerance in 1 / wf: no hop at all.
      if (is_due && !outcome.impact && outcome.velocity <= wf * parameters_.hop_tolerance) {
        outcome = {.energy_loss = 0.5 * mass.mass * mass.velocity * mass.velocity, .rests = true};
      }
      if (!outcome.impact && !outcome.rests) {
        continue;
      }
      const double after = lift.velocity + run.side * outcome.velocity;
      if (outcome.impact) {
        hit(run, node, time, velocity[node], after, outcome.energy_loss);
      } else {
        press(run.support, points_->mass()[node] * (after - velocity[node]), time, time);
      }
      flow({.work = points_->mass()[node] * (after - velocity[node]) * lift.velocity});
      position[node] = height;
      velocity[node] = after;
      if (outcome.rests) {
        rest(run, node, time, outcome.impact ? 0.0 : outcome.energy_loss);
      }
    }
  }
}

void ContactState::count_resting() {
  local_resting_ = static_cast<std::size_t>(std::ranges::count_if(resting_, [](auto on) { return on != 0; }));
}

void ContactState::begin_step() {
  changes_.clear();
  release_if_large(impacts_);
  release_if_large(rests_);
  losses_.clear();
  std::ranges::fill(pressed_, 0.0);
  parts_.clear();
  touches_.clear();
  line_gap_before_ = line_gap_;
  counts_before_ = counts_;
  impulse_before_ = impulse_;
  all_events_ = {};
  held_from_ = -1.0;
  flow_ = {};
}

void ContactState::hold(double from, double until) {
  held_from_ = held_from_ < 0.0 ? from : std::min(held_from_, from);
  held_until_ = until;
}

void ContactState::undo() {
  for (const Change& change : changes_ | std::views::reverse) {
    resting_[change.node] = change.before;
  }
  count_resting();
  line_gap_ = line_gap_before_;
  counts_ = counts_before_;
  impulse_ = impulse_before_;
  begin_step();
}

void ContactState::commit(double time, std::span<double> sums) {
  const auto releases = std::ranges::count_if(rests_, &RestRecord::release);
  std::vector<double> all{static_cast<double>(impacts_.size()),
                          static_cast<double>(rests_.size()) - static_cast<double>(releases),
                          static_cast<double>(releases),
                          lost_before(std::numeric_limits<double>::infinity()),
                          flow_.work,
                          flow_.damped};
  const auto own = static_cast<std::ptrdiff_t>(all.size());
  all.insert(all.end(), sums.begin(), sums.end());
  const auto sums_end = static_cast<std::ptrdiff_t>(all.size());
  all.resize(all.size() + impulse_.size(), 0.0);
  constexpr double kAll = std::numeric_limits<double>::infinity();
  add_impulses(kAll, 1.0, std::span{all}.last(impulse_.size()));
  note_contacts(kAll);
  const petsc::LogScope reduction{petsc::log_events().reduction};
  MPI_Allreduce(MPI_IN_PLACE, all.data(), static_cast<int>(all.size()), MPI_DOUBLE, MPI_SUM, points_->comm());
  std::copy(all.begin() + own, all.begin() + sums_end, sums.begin());
  std::transform(all.begin() + sums_end, all.end(), impulse_.begin(), impulse_.begin(), std::plus{});
  counts_.impacts += static_cast<PetscInt>(all[0]);
  counts_.rests += static_cast<PetscInt>(all[1]);
  counts_.releases += static_cast<PetscInt>(all[2]);
  const bool rested = counts_.resting > 0;
  counts_.resting += static_cast<PetscInt>(all[1] - all[2]);
  counts_.lost += all[3];
  counts_.work += all[4];
  counts_.damped += all[5];
  all_events_ = {.impacts = static_cast<PetscInt>(all[0]), .rests = static_cast<PetscInt>(all[1] + all[2])};
  counts_.event_steps += any_events() ? 1 : 0;
  if (any_events()) {
    double first = std::numeric_limits<double>::infinity();
    double last = -first;
    for (const ImpactRecord& impact : impacts_) {
      first = std::min(first, impact.time);
      last = std::max(last, impact.time);
    }
    for (const RestRecord& rest : rests_) {
      first = rest.release ? first : std::min(first, rest.time);
      last = std::max(last, rest.time);
    }
    std::array<double, 2> extremes{-first, last};
    MPI_Allreduce(MPI_IN_PLACE, extremes.data(), 2, MPI_DOUBLE, MPI_MAX, points_->comm());
    if (counts_.first_contact_time < 0.0 && all[0] + all[1] > 0.0) {
      counts_.first_contact_time = -extremes[0];
    }
    counts_.last_contact_time = extremes[1];
  }
  if (rested && counts_.resting > 0) {
    counts_.last_contact_time = time;
  }
  if (gives_way_) {
    std::array<double, 2> extremes{-kAll, -kAll};
    for (const Touch& touch : touches_) {
      extremes = {std::max(extremes[0], -touch.from), std::max(extremes[1], touch.until)};
    }
    MPI_Allreduce(MPI_IN_PLACE, extremes.data(), 2, MPI_DOUBLE, MPI_MAX, points_->comm());
    if (extremes[1] > -kAll) {
      const double first = counts_.first_contact_time;
      counts_.first_contact_time = first < 0.0 ? -extremes[0] : std::min(first, -extremes[0]);
      counts_.last_contact_time = std::max(counts_.last_contact_time, extremes[1]);
    }
  }
  if (held_from_ >= 0.0) {
    counts_.first_contact_time = counts_.first_contact_time < 0.0 ? held_from_ : counts_.first_contact_time;
    counts_.last_contact_time = held_until_;
  }
}

LineGap ContactState::smallest_line_gap() const {
  struct {
    double gap;
    int rank;
  } smallest{.gap = line_gap_.gap, .rank = 0};
  MPI_Comm_rank(points_->comm(), &smallest.rank);
  MPI_Allreduce(MPI_IN_PLACE, &smallest, 1, MPI_DOUBLE_INT, MPI_MINLOC, points_->comm());
  std::array<double, 3> place{line_gap_.gap, line_gap_.x, line_gap_.time};
  MPI_Bcast(place.data(), static_cast<int>(place.size()), MPI_DOUBLE, smallest.rank, points_->comm());
  return {.gap = place[0], .x = place[1], .time = place[2]};
}

void ContactState::restore(std::span<const std::int32_t> resting, const ContactCounts& counts, const LineGap& gap,
                           std::span<const double> impulses, std::span<const double> last_contact) {
  resting_.assign(resting.begin(), resting.end());
  count_resting();
  counts_ = counts;
  line_gap_ = gap;
  impulse_.assign(impulses.begin(), impulses.end());
  std::copy_n(last_contact.begin(), last_contact_.size(), last_contact_.begin());
  begin_step();
}

}  // namespace udar
