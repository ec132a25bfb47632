#include "udar/motion/contact_state.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "udar/contact/impact_law.hpp"
#include "udar/petsc/log.hpp"

namespace udar {
namespace {

// Masses within this share of the hop tolerance touch their support.
constexpr double kTouchingShare = 1e-2;
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace

ContactState::ContactState(const MassPoints& points, const Contacts& contacts, ContactParameters parameters)
    : points_{&points},
      contacts_{&contacts},
      parameters_{parameters},
      resting_(points.points(), 0),
      journal_{points, contacts.supports.size()},
      times_{points, contacts.sets} {
  if (!on_line()) {
    sets_ = contacts.sets;
    any_elastic_ = std::ranges::any_of(supports(), &Support::elastic);
  }
  totals_.impulses.assign(contacts.supports.size(), 0.0);
  begin_step();
}

double ContactState::touching_distance(double position, double height) const {
  return std::max(kTouchingShare * parameters_.hop_tolerance,
                  8.0 * kEpsilon * std::max(std::abs(position), std::abs(height)));
}

double ContactState::pull_resolution(double height) const {
  constexpr double kRoundings = 16.0;  // of places, each half a unit in the last place, and of the solve
  return kRoundings * kEpsilon * (length_ + std::abs(height));
}

double ContactState::spring_energy(double time, std::span<const double> position) const {
  double sum = 0.0;
  for (const ContactSet& set : sets_) {
    const double lift = set.elastic() ? set.lift(time).height : 0.0;
    for (std::size_t node = set.first; set.elastic() && node < set.last; ++node) {
      const double gap = std::min(0.0, set.side * (position[node] - set.height(node) - lift));
      sum += 0.5 * set.stiffness * points_->mass()[node] * gap * gap;
    }
  }
  return sum;
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

void ContactState::set_scratch_folder(const std::string& folder) {
  journal_.set_scratch_folder(folder);
  changes_.set_folder(folder);
}

void ContactState::bring_to_rest(std::size_t node, const ContactSet& set, double time, double loss) {
  journal_.record_rest(node, set.support, time);
  journal_.record_loss(time, loss);
  set_resting(node, set.support);
}

void ContactState::release(std::size_t node, const ContactSet& set, double time) {
  journal_.record_release(node, set.support, time);
  set_resting(node, -1);
}

ContactZone ContactState::zone(double since, double until, std::span<const std::uint8_t> resting,
                               std::span<std::uint8_t> touched) {
  times_.note(journal_, until);
  return times_.zone(since, resting, touched);
}

void ContactState::record_gap(double gap, std::size_t node, double time) {
  if (smallest(gap)) {
    totals_.line_gap = {
        .gap = gap, .x = points_->place(node).x, .time = time, .point = static_cast<std::int64_t>(node)};
  }
}

void ContactState::release_pulled(double time, double acceleration, std::span<const double> stretch) {
  for (const ContactSet& set : sets_) {
    const double lift = set.lift(time).acceleration;
    for (std::size_t node = set.first; node < set.last; ++node) {
      if (resting_on(node, set) && set.side * (acceleration * stretch[node] - lift) > 0.0) {
        release(node, set, time);
      }
    }
  }
}

void ContactState::resolve(const ContactInstant& now) {
  for (const ContactSet& set : sets_) {
    const SupportMotion::State lift = set.lift(now.time);
    for (std::size_t node = set.first; node < set.last && !set.elastic(); ++node) {
      const bool due = !now.due.empty() && now.due[node] == set.support + 1;
      if (!resting(node)) {
        meet(now, set, lift, node, due);
      } else if (due && resting_on(node, set)) {
        // Just off: else it would come to rest again by what else happens at this instant.
        now.stretch[node] =
            lift.acceleration / now.acceleration + 2.0 * set.side * pull_resolution(set.height(node) + lift.height);
        release(node, set, now.time);
      }
    }
  }
}

/// A mass that moves and may be on its support. @param due whether it meets it now, wherever it is
void ContactState::meet(const ContactInstant& now, const ContactSet& set, const SupportMotion::State& lift,
                        std::size_t node, bool due) {
  const double height = set.height(node) + lift.height;
  double& position = now.position[node];
  double& velocity = now.velocity[node];
  const double gap = set.side * (position - height);
  if (gap > touching_distance(position, height) && !due) {
    return;
  }
  const double wf = std::sqrt(now.acceleration);
  const double resolution = pull_resolution(height);
  TouchingMass mass{.velocity = set.side * (velocity - lift.velocity),
                    .acceleration = set.side * (now.acceleration * now.stretch[node] - lift.acceleration),
                    .resolution = now.acceleration * resolution,
                    .mass = points_->mass()[node]};
  if (std::abs(mass.velocity) <= wf * resolution) {
    mass.velocity = 0.0;  // it stands there, but for rounding
  }
  ContactOutcome outcome = resolve_contact(mass, set.law, parameters_.hop_tolerance);
  // It is to meet the support now, and would not get off it by the tolerance in 1 / wf: no hop at all.
  if (due && !outcome.impact && outcome.velocity <= wf * parameters_.hop_tolerance) {
    outcome = {.energy_loss = 0.5 * mass.mass * mass.velocity * mass.velocity, .rests = true};
  }
  if (!outcome.impact && !outcome.rests) {
    return;
  }
  const double after = lift.velocity + set.side * outcome.velocity;
  const double impulse = mass.mass * (after - velocity);
  const double rubbed = rub(set, node, impulse, now.velocity);
  if (outcome.impact) {
    journal_.record_impact(node, {.time = now.time,
                                  .support = set.support,
                                  .velocity_before = velocity,
                                  .velocity_after = after,
                                  .impulse = impulse,
                                  .energy_loss = outcome.energy_loss + rubbed});
  } else {
    journal_.record_impulse(set.support, impulse, now.time);
    journal_.record_loss(now.time, rubbed);
  }
  journal_.record_flow({.work = impulse * lift.velocity});
  position = height;
  velocity = after;
  if (outcome.rests) {
    bring_to_rest(node, set, now.time, outcome.impact ? 0.0 : outcome.energy_loss);
  }
}

double ContactState::rub(const ContactSet& set, std::size_t node, double impulse, std::span<double> velocity) const {
  if (set.friction == 0.0) {
    return 0.0;
  }
  const std::array<std::size_t, 2> across = *points_->beside(node);
  const auto speed_of = [&](std::size_t point) { return resting(point) ? 0.0 : velocity[point]; };
  const double speed = std::hypot(speed_of(across[0]), speed_of(across[1]));
  if (speed == 0.0) {
    return 0.0;
  }
  const double mass = points_->mass()[node];
  const double left = std::max(0.0, speed - set.friction * std::abs(impulse) / mass);
  for (const std::size_t point : across) {
    velocity[point] = resting(point) ? velocity[point] : left / speed * velocity[point];
  }
  return 0.5 * mass * (speed - left) * (speed + left);
}

void ContactState::count_resting() {
  local_resting_ = static_cast<std::size_t>(std::ranges::count_if(resting_, [](auto on) { return on != 0; }));
}

void ContactState::begin_step() {
  changes_.clear();
  journal_.clear();
  totals_before_ = totals_;
  all_events_ = {};
}

void ContactState::undo() {
  for (std::size_t i = changes_.size(); i-- > 0;) {
    resting_[changes_[i].node] = changes_[i].before;
  }
  count_resting();
  totals_ = totals_before_;
  begin_step();
}

void ContactState::commit(double time, std::span<double> sums) {
  times_.note(journal_, kInfinity);
  const bool rested = totals_.counts.resting > 0;
  add_up(sums);
  find_contact_times(time, rested);
}

/// Counts, energies and impulses of the step over the ranks. @param[in,out] sums what is added up with them
void ContactState::add_up(std::span<double> sums) {
  const auto releases = std::ranges::count_if(journal_.rests(), &RestRecord::release);
  std::vector<double> all{static_cast<double>(journal_.impacts().size()),
                          static_cast<double>(journal_.rests().size()) - static_cast<double>(releases),
                          static_cast<double>(releases),
                          journal_.lost_before(kInfinity),
                          journal_.flow().work,
                          journal_.flow().damped,
                          journal_.flow().radiated,
                          journal_.flow().yielded};
  std::vector<double>& impulses = totals_.impulses;
  const auto own = static_cast<std::ptrdiff_t>(all.size());
  all.insert(all.end(), sums.begin(), sums.end());
  const auto sums_end = static_cast<std::ptrdiff_t>(all.size());
  all.resize(all.size() + impulses.size(), 0.0);
  journal_.add_impulses(kInfinity, 1.0, std::span{all}.last(impulses.size()));
  const petsc::LogScope reduction{petsc::log_events().reduction};
  MPI_Allreduce(MPI_IN_PLACE, all.data(), static_cast<int>(all.size()), MPI_DOUBLE, MPI_SUM, points_->comm());
  std::copy(all.begin() + own, all.begin() + sums_end, sums.begin());
  std::transform(all.begin() + sums_end, all.end(), impulses.begin(), impulses.begin(), std::plus{});
  ContactCounts& counts = totals_.counts;
  counts.impacts += static_cast<PetscInt>(all[0]);
  counts.rests += static_cast<PetscInt>(all[1]);
  counts.releases += static_cast<PetscInt>(all[2]);
  counts.resting += static_cast<PetscInt>(all[1] - all[2]);
  counts.lost += all[3];
  counts.work += all[4];
  counts.damped += all[5];
  counts.radiated += all[6];
  counts.yielded += all[7];
  all_events_ = {.impacts = static_cast<PetscInt>(all[0]), .rests = static_cast<PetscInt>(all[1] + all[2])};
  counts.event_steps += any_events() ? 1 : 0;
}

/// First and last time of contact. @param rested whether any mass did at the beginning of the step
void ContactState::find_contact_times(double time, bool rested) {
  ContactCounts& counts = totals_.counts;
  std::array<double, 2> extremes{-kInfinity, -kInfinity};  // minus the first, the last
  const auto see = [&](double first, double last) {
    extremes = {std::max(extremes[0], -first), std::max(extremes[1], last)};
  };
  const auto reduce = [&] {
    const petsc::LogScope reduction{petsc::log_events().reduction};
    MPI_Allreduce(MPI_IN_PLACE, extremes.data(), 2, MPI_DOUBLE, MPI_MAX, points_->comm());
  };
  if (any_events()) {
    for (const ImpactRecord& impact : journal_.impacts()) {
      see(impact.time, impact.time);
    }
    for (const RestRecord& rest : journal_.rests()) {
      see(rest.release ? kInfinity : rest.time, rest.time);
    }
    reduce();
    if (counts.first_contact_time < 0.0 && extremes[0] > -kInfinity) {
      counts.first_contact_time = -extremes[0];
    }
    counts.last_contact_time = extremes[1];
  }
  if (rested && counts.resting > 0) {
    counts.last_contact_time = time;
  }
  if (any_elastic_) {
    extremes = {-kInfinity, -kInfinity};
    for (const ContactJournal::Contact& contact : journal_.contacts()) {
      see(contact.time.from, contact.time.until);
    }
    reduce();
    if (extremes[1] > -kInfinity) {
      const double first = counts.first_contact_time;
      counts.first_contact_time = first < 0.0 ? -extremes[0] : std::min(first, -extremes[0]);
      counts.last_contact_time = std::max(counts.last_contact_time, extremes[1]);
    }
  }
  if (const auto& line = journal_.line_contact()) {
    counts.first_contact_time = counts.first_contact_time < 0.0 ? line->from : counts.first_contact_time;
    counts.last_contact_time = line->until;
  }
}

LineGap ContactState::smallest_line_gap() const {
  const LineGap& own = totals_.line_gap;
  struct {
    double gap;
    int rank;
  } smallest{.gap = own.gap, .rank = 0};
  MPI_Comm_rank(points_->comm(), &smallest.rank);
  MPI_Allreduce(MPI_IN_PLACE, &smallest, 1, MPI_DOUBLE_INT, MPI_MINLOC, points_->comm());
  std::array<double, 3> place{own.gap, own.x, own.time};
  MPI_Bcast(place.data(), static_cast<int>(place.size()), MPI_DOUBLE, smallest.rank, points_->comm());
  return {.gap = place[0], .x = place[1], .time = place[2]};
}

void ContactState::restore(std::span<const std::int32_t> resting, ContactTotals totals,
                           std::span<const double> last_contact) {
  resting_.assign(resting.begin(), resting.end());
  count_resting();
  totals_ = std::move(totals);
  times_.restore(last_contact);
  begin_step();
}

}  // namespace udar
