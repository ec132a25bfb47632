#include "udar/motion/equations.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <utility>

#include "udar/petsc/error.hpp"

namespace udar {
namespace {

// A balance is judged by what is added up in it: forces times heights from y = 0, and times the way they would move the
// line if nothing held it. A run may round these by a thousand units in the last place, which must stay below a
// thousandth of the scale, where the balance begins to say something.
constexpr double kLeastShare = 1e6 * std::numeric_limits<double>::epsilon();
// Squares of numbers whose digits end at the smallest double have digits no more.
constexpr double kLeastEnergy = std::numeric_limits<double>::min() / std::numeric_limits<double>::epsilon();

}  // namespace

Equations::Equations(FilteredStructure& line, const Loads& loads, const InitialState& initial, const Damping& damping,
                     std::unique_ptr<LineContact> contact, std::vector<double> damping_ratio, bool yields,
                     std::vector<HeldMove> held)
    : line_{&line},
      loads_{&loads},
      damping_{damping},
      damping_ratio_{std::move(damping_ratio)},
      line_contact_{std::move(contact)},
      hinges_{yields ? std::make_unique<HingedLine>(line, line_contact_.get()) : nullptr},
      held_{line, std::move(held)} {
  const auto require = [](const char* quantity, double value, const char* unit) {
    if (!(value >= 0.0) || !std::isfinite(value)) {
      throw InputError{std::string{quantity} + ": " + std::to_string(value) +
                       " is not allowed, expected a number >= 0 [" + unit + "]"};
    }
  };
  require("damping mass", damping.mass, "1/s");
  require("damping stiffness", damping.stiffness, "s");
  for (const double ratio : damping_ratio_) {
    if (!(ratio >= 0.0 && ratio < 1.0)) {
      throw InputError{"damping ratio: " + std::to_string(ratio) +
                       " is not allowed, expected numbers from 0 to below 1"};
    }
  }
  if (line_contact_ && damping.stiffness > 0.0) {
    throw InputError{
        "damping stiffness: not allowed with `contact surface` line or `filter frequency` none, expected 0 [s]: "
        "it is the damping of the free line, and no integrator solves for it and for contact forces in one iteration"};
  }
  refuse_with_riders();
  if (!line.points().riders().empty()) {
    carried_ = std::make_unique<CarriedMasses>(line, initial, loads.gravity());
  }
  axis_ = reference_axis(line.points(), initial);
  displacement_.resize(axis_.size());
}

/// What would have to know that the line's answer to the masses changes as some of them travel.
void Equations::refuse_with_riders() const {
  const auto refuse = [](bool whether, const char* with) {
    if (whether) {
      throw InputError{std::string{"load axles: masses are not allowed with "} + with + ", expected forces alone"};
    }
  };
  if (!line_->points().riders().empty()) {
    refuse(damping_.any() || !damping_ratio_.empty(),
           "damping of the structure (`damping mass`, `damping stiffness`, `damping ratio`)");
    refuse(line_contact_ != nullptr, "contact on the line (`contact surface` line)");
    refuse(!line_->corrected_modes().empty(), "corrected modes (`filter correct modes`)");
    refuse(!line_->moved().empty(), "a place that holds the structure rigidly and moves (`base motion place`)");
    refuse(hinges_ != nullptr, "a beam that yields (`beam yield moment`)");
  }
}

void Equations::evaluate(const Instant& at, std::span<const double> mass_position, LineState& state, bool with_moment,
                         std::span<const double> rotations) {
  const double* kink = nullptr;
  if (hinges_) {
    const std::span<const double> turned = rotations.empty() ? hinges_->rotations() : rotations;
    state.rotation.assign(turned.begin(), turned.end());
    kink = hinges_->kink(state.rotation);
  }
  state.time = at.time;
  state.begin = at.begin;
  state.stretch.resize(axis_.size());
  state.moment.resize(with_moment ? line_->filter_operator().internal_numbers() * axis_.size() : 0);
  for (std::size_t i = 0; i < axis_.size(); ++i) {
    displacement_[i] = mass_position[i] - axis_[i];
  }
  if (!filtered()) {
    std::ranges::fill(state.stretch, 0.0);
    if (with_moment) {
      line_->internal_of({.displacement = displacement_.data(), .kink = kink, .internal = state.moment.data()});
    }
    return;
  }
  const std::span<const double> force = loads_->force(at, work_);
  const FilterColumn column{.displacement = displacement_.data(),
                            .force = force.empty() ? nullptr : force.data(),
                            .kink = kink,
                            .stretch = state.stretch.data(),
                            .internal = with_moment ? state.moment.data() : nullptr};
  line_->solve({&column, 1});
  const auto amplitude = line_->amplitudes();
  state.amplitude.assign(amplitude.begin(), amplitude.end());
  if (line_contact_) {
    state.in_contact = line_contact_->apply(at.time, mass_position, state.stretch, state.amplitude, state.moment);
    state.contact_force.assign(line_contact_->forces().begin(), line_contact_->forces().end());
  }
  if (carried_) {
    carried_->apply(at, mass_position, state.stretch, state.moment, state.carried);
  }
}

double Equations::frequency_bound() const {
  return line_contact_ ? line_contact_->frequency_bound() : line_->frequency_bound();
}

void Equations::evaluate_rate(std::span<const double> mass_velocity, std::span<double> stretch_rate) {
  line_->solve(mass_velocity, {}, stretch_rate, {});
}

void Equations::add_carried_rate(const Instant& at, std::span<const double> mass_position,
                                 std::span<const double> mass_velocity, std::span<double> stretch_rate) {
  if (carried_) {
    LineState now;
    evaluate(at, mass_position, now);
    carried_->add_rate(at, mass_velocity, now.carried, load_rate(at.begin).stretch, stretch_rate);
  }
}

std::vector<PlaceState> Equations::places(const Instant& at, std::span<const double> mass_position,
                                          std::span<const double> line_position) const {
  return held_.empty() ? std::vector<PlaceState>{} : held_.states(at, *loads_, mass_position, line_position, axis_);
}

std::vector<RiderState> Equations::riders(const LineState& state, std::span<const double> mass_position,
                                          std::span<const double> mass_velocity) const {
  std::vector<RiderState> states;
  if (!carried_) {
    return states;
  }
  std::vector<double> foot(mass_position.begin(), mass_position.end());
  std::ranges::transform(foot, state.stretch, foot.begin(), std::plus{});
  const std::vector<double> below = carried_->heights_below(foot, state.carried);
  for (std::size_t i = 0; const Rider& rider : points().riders()) {
    RiderState& now = states.emplace_back();
    now.x = rider.passage.x(state.time);
    now.below = below[i];
    now.force = state.carried.force[i++];
    if (points().owns(rider.point)) {
      const auto point = static_cast<std::size_t>(rider.point - points().begin());
      now.height = mass_position[point];
      now.velocity = mass_velocity[point];
    }
  }
  return states;
}

const LoadRate& Equations::load_rate(double time) {
  if (!loads_->time_dependent()) {
    return load_rate_;
  }
  const std::size_t interval = loads_->interval(time);
  if (load_rate_.stretch.empty() || interval != load_interval_) {
    load_interval_ = interval;
    std::ranges::fill(displacement_, 0.0);
    load_rate_.stretch.resize(axis_.size());
    line_->solve(displacement_, loads_->rate({time, time}, work_), load_rate_.stretch, {});
    load_rate_.amplitude.assign(line_->amplitudes().begin(), line_->amplitudes().end());
  }
  return load_rate_;
}

std::vector<double> Equations::line_stretch(const LineState& state) const {
  std::vector<double> stretch = state.stretch;
  line_->line_stretch(state.amplitude, stretch);
  return stretch;
}

std::vector<double> Equations::line_position(const LineState& state, std::span<const double> mass_position) const {
  std::vector<double> position = line_stretch(state);
  std::ranges::transform(position, mass_position, position.begin(), std::plus{});
  return position;
}

EnergyLedger Equations::energy(const LineState& state, std::span<const double> mass_position,
                               std::span<const double> mass_velocity) {
  const double wf2 = line_->filter_frequency() * line_->filter_frequency();
  const std::span<const double> mass = line_->mass();
  const std::span<const double> force = loads_->force({state.time, state.begin}, work_);
  const std::vector<double> stretch = line_stretch(state);
  std::array<double, 8> sums{};
  for (std::size_t i = 0; i < axis_.size(); ++i) {
    sums[0] += 0.5 * mass[i] * mass_velocity[i] * mass_velocity[i];
    sums[2] += 0.5 * wf2 * mass[i] * stretch[i] * stretch[i];
    if (!force.empty() && loads_->is_force(i)) {
      const double line = mass_position[i] + stretch[i];
      sums[3] -= force[i] * line;
      sums[5] += std::abs(force[i]) * (std::abs(line) + std::abs(force[i]) / (wf2 * mass[i]));
    }
    displacement_[i] = mass_position[i] - axis_[i] + stretch[i];
  }
  for (const LoadPattern& pattern : loads_->patterns()) {
    const bool apart = pattern.cause == LoadCause::base || pattern.cause == LoadCause::spring;
    const double value = apart ? pattern.table->at({state.time, state.begin}).value : 0.0;
    for (std::size_t i = 0; value != 0.0 && i < pattern.point.size(); ++i) {
      const std::size_t point = pattern.point[i];
      sums[pattern.cause == LoadCause::base ? 6 : 7] -=
          value * pattern.share[i] * (mass_position[point] + stretch[point]);
    }
  }
  sums[1] = held_.stored({state.time, state.begin}, displacement_) +
            line_->filter_operator().strain_energy(displacement_, state.moment) +
            (hinges_ && points().begin() == 0 ? hinges_->stored(state.rotation) : 0.0);
  sums[4] = line_contact_ && filtered() ? line_contact_->spring_energy(state.contact_force) : 0.0;
  sums[4] += carried_ && points().begin() == 0 ? carried_->spring_energy(state.carried) : 0.0;
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM, points().comm());
  EnergyLedger ledger;
  ledger.kinetic = sums[0];
  ledger.line_strain = sums[1];
  ledger.fictitious_springs = sums[2];
  ledger.load_potential = sums[3] - sums[6] - sums[7];
  ledger.base_potential = sums[6];
  ledger.support_springs = sums[4];
  ledger.scale = kLeastShare * sums[5] + kLeastEnergy;
  return ledger;
}

}  // namespace udar
