#include "udar/integrators/touching_points.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "udar/petsc/error.hpp"

namespace udar {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

// Gaps that differ by less of the motion's length are one (measured: mirror images differ by up to 1e-13).
constexpr double kZeroShare = 1e-12;

}  // namespace

TouchingPoints::TouchingPoints(Equations& equations, ContactState& contact, const MotionScale& scale)
    : equations_{&equations},
      contact_{&contact},
      velocity_{scale.velocity},
      held_{*equations.line_contact()},
      constant_(held_.points()),
      steady_(held_.points()),
      load_rate_(held_.points()),
      zero_at_(held_.points(), kNever),
      gap_(held_.points()) {
  const LineContact& line = held_.contact();
  const auto points = line.points();
  line.gather(
      1, [&](std::size_t i, std::size_t /*field*/) { return points[i].side * line.response(i)[line.local(i)]; }, give_);
  std::vector<double> force(points.size(), 0.0);
  std::vector<double> amplitude(equations.line().corrected_modes().size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::ranges::fill(force, 0.0);
    std::ranges::fill(amplitude, 0.0);
    force[i] = 1.0;
    line.add_amplitudes(force, 0, 1, amplitude);
    give_[i] += points[i].compliance - line.nearer(i, amplitude);
    resolution_.push_back(kZeroShare * (scale.length + std::abs(points[i].height)));
  }
  for (Status* status : {&now_, &next_}) {
    status->touches.assign(points.size(), 0);
    status->due.assign(points.size(), 0);
  }
}

/// Distances of the line from the faces of supports that give way.
void TouchingPoints::gather_gaps(const LineState& line, std::span<const double> position) {
  const LineContact& contact = held_.contact();
  const auto points = contact.points();
  contact.gather(
      1,
      [&](std::size_t i, std::size_t /*field*/) {
        const std::size_t node = contact.local(i);
        return points[i].side * (position[node] + line.stretch[node] - points[i].height);
      },
      gap_);
  for (std::size_t i = 0; i < points.size(); ++i) {
    gap_[i] += points[i].compliance * line.contact_force[i] - contact.nearer(i, line.amplitude);
  }
}

/// Of the free line, where its stretch and the amplitudes of it have these rates and the masses this velocity.
std::vector<double> TouchingPoints::gap_rates_of(std::span<const double> velocity, std::span<const double> stretch,
                                                 std::span<const double> amplitude) const {
  const LineContact& contact = held_.contact();
  std::vector<double> rates;
  contact.gather(
      1,
      [&](std::size_t i, std::size_t /*field*/) {
        const std::size_t node = contact.local(i);
        return contact.points()[i].side * ((velocity.empty() ? 0.0 : velocity[node]) + stretch[node]);
      },
      rates);
  for (std::size_t i = 0; i < rates.size(); ++i) {
    rates[i] -= contact.nearer(i, amplitude);
  }
  return rates;
}

bool TouchingPoints::is_zero(std::size_t point, double value) const {
  return (now_.touches[point] != 0 ? give_[point] * value : value) <= resolution_[point];
}

void TouchingPoints::start(const LineState& line, std::span<const double> position, std::span<const double> velocity) {
  gather_gaps(line, position);
  bool any_due = false;
  for (std::size_t i = 0; i < gap_.size(); ++i) {
    const bool pressed = give_[i] * line.contact_force[i] > resolution_[i];
    next_.touches[i] = pressed ? 1 : 0;
    next_.due[i] = !pressed && gap_[i] <= resolution_[i] ? 1 : 0;
    any_due = any_due || next_.due[i] != 0;
  }
  if (!any_due) {
    return;
  }
  // How the free line goes on: by the masses' velocities, or where nothing moves by their accelerations.
  const double wf2 = equations_->line().filter_frequency() * equations_->line().filter_frequency();
  std::vector<double> acceleration(line.stretch);
  std::ranges::transform(acceleration, acceleration.begin(), [wf2](double stretch) { return wf2 * stretch; });
  std::vector<double> stretch(line.stretch.size());
  const auto rates_of = [&](std::span<const double> moved) {
    equations_->line().solve(moved, {}, stretch, {});
    return gap_rates_of(moved, stretch, equations_->line().amplitudes());
  };
  std::vector<double> rates = rates_of(velocity);
  const LoadRate& loads = equations_->load_rate(line.time);
  if (!loads.stretch.empty()) {
    const std::vector<double> by_loads = gap_rates_of({}, loads.stretch, loads.amplitude);
    std::ranges::transform(rates, by_loads, rates.begin(), std::plus{});
  }
  follow(rates, rates_of(acceleration));
}

/// Who of the points that are due touches next.
void TouchingPoints::follow(std::span<const double> rates, std::span<const double> accelerations) {
  std::vector<std::size_t> due;
  for (std::size_t i = 0; i < next_.due.size(); ++i) {
    if (next_.due[i] != 0) {
      due.push_back(i);
    }
  }
  // Where nothing moves on, accelerations decide.
  const bool still =
      std::ranges::all_of(due, [&](std::size_t i) { return std::abs(rates[i]) <= kZeroShare * velocity_; });
  next_.touches = held_.contact().problem().follow(next_.touches, due, still ? accelerations : rates);
}

void TouchingPoints::begin_step(const LineState& line, std::span<const double> position, LoadRate& rate) {
  begin_ = line.time;
  now_ = next_;
  held_.assume(now_.touches);
  gather_gaps(line, position);
  for (std::size_t i = 0; i < gap_.size(); ++i) {
    constant_[i] = now_.due[i] != 0 ? 0.0 : now_.touches[i] != 0 ? line.contact_force[i] : gap_[i];
  }
  std::ranges::fill(zero_at_, kNever);
  if (rate.stretch.empty()) {
    return;
  }
  load_rate_ = gap_rates_of({}, rate.stretch, rate.amplitude);
  const std::vector<double> none(rate.stretch.size(), 0.0);
  const FilterColumn column{.displacement = none.data(), .force = nullptr, .stretch = rate.stretch.data()};
  held_.hold({&column, 1}, rate.amplitude, steady_);
}

/// A row that begins at zero does not fall there but by rounding.
Kinematics TouchingPoints::row(const FreeMotion& motion, std::size_t point, const SeriesSample& at) const {
  Kinematics row{.position = constant_[point] + steady_[point] * at.time + motion.row(at.weights[0], point),
                 .velocity = steady_[point] + motion.row(at.weights[1], point),
                 .acceleration = motion.row(at.weights[2], point)};
  if (at.time == 0.0 && now_.due[point] != 0) {
    row.velocity = std::max(row.velocity, 0.0);
  }
  return row;
}

double TouchingPoints::guess(const FreeMotion& motion) const {
  const SeriesSample start = sample(motion, 0.0);
  double first = kNever;
  for (std::size_t i = 0; i < constant_.size(); ++i) {
    first = std::min(first, guessed_closing(row(motion, i, start)));
  }
  return first;
}

double TouchingPoints::search(const FreeMotion& motion, double from, double to) {
  SeriesGrid grid{motion, from, to, equations_->frequency_bound()};
  const double resolution = time_resolution(begin_ + to);
  for (std::size_t i = 0; i < constant_.size(); ++i) {
    const auto value = [&](const SeriesSample& at) { return row(motion, i, at); };
    const auto time = grid.first(value, comes_near, [&](const SeriesSample& start, const SeriesSample& end) {
      return first_closing(motion, start, end, resolution, value);
    });
    zero_at_[i] = time.value_or(kNever);
  }
  return std::ranges::min(zero_at_);
}

void TouchingPoints::end_step(const FreeMotion& motion, double length) {
  std::ranges::fill(next_.due, std::uint8_t{0});
  if (std::ranges::min(zero_at_) > length) {
    return;
  }
  const double at_once = length + 2.0 * time_resolution(begin_ + length);
  const SeriesSample end = sample(motion, length);
  std::vector<double> slope(constant_.size());
  std::vector<double> bend(constant_.size());
  for (std::size_t i = 0; i < slope.size(); ++i) {
    const Kinematics value = row(motion, i, end);
    slope[i] = value.velocity;
    bend[i] = value.acceleration;
    next_.due[i] = zero_at_[i] <= at_once || is_zero(i, value.position) ? 1 : 0;
  }
  std::vector<double> rates(slope.size());
  std::vector<double> accelerations(slope.size());
  held_.free_rates(slope, rates);
  held_.free_rates(bend, accelerations);
  const LoadRate& loads = equations_->load_rate(begin_ + length);
  if (!loads.stretch.empty()) {  // they may have a kink there
    const std::vector<double> after = gap_rates_of({}, loads.stretch, loads.amplitude);
    for (std::size_t i = 0; i < rates.size(); ++i) {
      rates[i] += after[i] - load_rate_[i];
    }
  }
  follow(rates, accelerations);
}

void TouchingPoints::take_back() { next_ = now_; }

void TouchingPoints::add_impulses(const FreeMotion& motion, double time, std::span<double> sums) const {
  const FreeMotion::Weights sum = motion.weights(-1, time);
  for (const std::size_t i : held_.contact().mine()) {
    if (now_.touches[i] != 0) {
      const LinePoint& point = held_.contact().points()[i];
      sums[static_cast<std::size_t>(point.support)] +=
          point.side * (time * (constant_[i] + 0.5 * time * steady_[i]) + motion.row(sum, i));
    }
  }
}

void TouchingPoints::write_journal(const FreeMotion& motion, double length) {
  const ContactJournal::Interval step{.from = begin_, .until = begin_ + length};
  ContactJournal& journal = contact_->journal();
  const LineContact& line = held_.contact();
  std::vector<double> impulses(contact_->supports().size(), 0.0);
  add_impulses(motion, length, impulses);
  for (std::size_t support = 0; support < impulses.size(); ++support) {
    journal.record_force(static_cast<PetscInt>(support), impulses[support]);
  }
  for (const std::size_t i : line.mine()) {
    if (now_.touches[i] != 0) {
      journal.record_contact_time(line.local(i), step);
    }
  }
  if (any()) {
    journal.record_line_contact(step);
  }
  track_gaps(motion, length);
}

/// A point that touches is below its face by what its force presses the spring.
void TouchingPoints::track_gaps(const FreeMotion& motion, double length) {
  const LineContact& line = held_.contact();
  std::vector<SeriesSample> samples;
  for (const std::size_t i : line.mine()) {
    const bool touches = now_.touches[i] != 0;
    const double compliance = line.points()[i].compliance;
    if (!contact_->smallest(0.0) && (!touches || compliance == 0.0)) {
      continue;  // no smaller than what has been
    }
    if (samples.empty()) {
      samples = samples_between(motion, 0.0, length,
                                parts_of(motion, length, kFine / kCoarse * equations_->frequency_bound()));
    }
    for (const SeriesSample& at : samples) {
      const double value = std::max(0.0, row(motion, i, at).position);
      contact_->record_gap(touches ? 0.0 - compliance * value : value, line.local(i), begin_ + at.time);
    }
  }
}

void TouchingPoints::save(MotionState& state) const {
  state.tables["line_touches"].assign(next_.touches.begin(), next_.touches.end());
  state.tables["line_due"].assign(next_.due.begin(), next_.due.end());
}

void TouchingPoints::restore(const MotionState& state) {
  const auto table = [&](const char* name, std::vector<std::uint8_t>& values) {
    const auto found = state.tables.find(name);
    if (found == state.tables.end() || found->second.size() != values.size()) {
      throw InputError{"restart file: it was written by another integrator or with another number of contact points"};
    }
    std::ranges::transform(found->second, values.begin(), [](double value) { return value != 0.0 ? 1 : 0; });
  };
  table("line_touches", next_.touches);
  table("line_due", next_.due);
}

}  // namespace udar
