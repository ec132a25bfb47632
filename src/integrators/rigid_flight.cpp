#include "udar/integrators/rigid_flight.hpp"

#include <algorithm>
#include <limits>

#include "udar/numerics/power_series.hpp"
#include "udar/numerics/roots.hpp"
#include "udar/petsc/log.hpp"

namespace udar {

RigidFlight::RigidFlight(Equations& equations, ContactState& contact, const Contacts* contacts)
    : equations_{&equations},
      contact_{&contact},
      contacts_{contacts},
      wf2_{equations.line().filter_frequency() * equations.line().filter_frequency()} {}

bool RigidFlight::begin(double time, std::span<const double> state, double shortest, double longest,
                        double negligible) {
  const std::size_t count = state.size() / 2;
  begin_ = time;
  position_ = state.first(count);
  velocity_ = state.last(count);
  equations_->evaluate(time, position_, line_);
  line_stretch_ = equations_->line_stretch(line_);
  const auto over_mass = [this](double stretch) { return wf2_ * stretch; };
  acceleration_.resize(count);
  std::ranges::transform(line_.stretch, acceleration_.begin(), over_mass);
  rate_ = equations_->load_rate(time);
  line_rate_ = rate_.stretch;
  equations_->line().line_stretch(rate_.amplitude, line_rate_);
  jerk_ = rate_.stretch;
  std::ranges::transform(jerk_, jerk_.begin(), over_mass);

  const double touch = line_.in_contact ? 0.0 : first_touch(longest);
  if (!(touch > shortest)) {
    end();
    return false;
  }
  motion_.emplace(equations_->line());
  motion_->start({.velocity = velocity_, .acceleration = acceleration_, .jerk = jerk_, .resting = {}});
  motion_->answer();
  FreeMotion::Sizes sizes = motion_->first_sizes();
  {
    const petsc::LogScope reduction{petsc::log_events().reduction};
    MPI_Allreduce(MPI_IN_PLACE, sizes.data(), static_cast<int>(sizes.size()), MPI_DOUBLE, MPI_MAX,
                  equations_->points().comm());
  }
  length_ = std::min(touch, longest);
  motion_->end_if_rigid(sizes, length_, negligible);
  if (!motion_->rigid()) {
    end();
    return false;
  }
  touches_ = touch < longest;
  return true;
}

void RigidFlight::end() {
  motion_.reset();
  line_ = LineState{};
  rate_ = LoadRate{};
  for (std::vector<double>* values : {&line_stretch_, &line_rate_, &acceleration_, &jerk_}) {
    *values = std::vector<double>{};
  }
}

/// Of a mass or of the line from a support, over a time from the beginning on.
RigidFlight::Powers RigidFlight::distance(const ContactSet& set, std::size_t node, double length, bool of_line) const {
  const double rate = of_line && !line_rate_.empty() ? line_rate_[node] : 0.0;
  const double place = position_[node] + (of_line ? line_stretch_[node] : 0.0);
  Powers powers{place - set.height(node), length * (velocity_[node] + rate),
                0.5 * length * length * acceleration_[node], length * length * length / 6.0 * jerk(node)};
  const Powers lift = set.motion ? set.motion->cubic(begin_, length) : Powers{};
  for (std::size_t k = 0; k < powers.size(); ++k) {
    powers[k] = set.side * (powers[k] - lift[k]);
  }
  return powers;
}

/// Time until a mass, or the line, touches a support, infinite where none does before `longest`. What touches now may
/// do so for long. @note Collective.
double RigidFlight::first_touch(double longest) const {
  const bool on_line = contact_->on_line();
  double first = std::numeric_limits<double>::infinity();
  for (const ContactSet& set : contacts_->sets) {
    for (std::size_t node = set.first; node < set.last; ++node) {
      const Powers powers = distance(set, node, longest, on_line);
      const double share = powers[0] > 0.0 ? first_zero(powers.data(), powers.size(), 1.0) : 0.0;
      first = share >= 0.0 ? std::min(first, share * longest) : first;
    }
  }
  const petsc::LogScope reduction{petsc::log_events().reduction};
  MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_DOUBLE, MPI_MIN, equations_->points().comm());
  return first;
}

void RigidFlight::at(double elapsed, std::span<double> position, std::span<double> velocity) const {
  motion_->at(motion_->weights(0, elapsed), position);
  motion_->at(motion_->weights(1, elapsed), velocity);
  for (std::size_t i = 0; i < position.size(); ++i) {
    position[i] += position_[i];
  }
}

double RigidFlight::acceleration(double elapsed, std::size_t node) const {
  return acceleration_[node] + elapsed * jerk(node);
}

void RigidFlight::line_integrals(double elapsed, std::span<const std::size_t> nodes,
                                 std::span<double> integrals) const {
  const FreeMotion::Weights sum = motion_->weights(-1, elapsed);
  std::ranges::transform(nodes, integrals.begin(), [&](std::size_t node) {
    const double stretched = line_.stretch[node] + 0.5 * elapsed * jerk(node) / wf2_;
    return elapsed * (position_[node] + stretched) + motion_->at(sum, node);
  });
}

void RigidFlight::mass_integrals(double elapsed, std::span<double> integrals) const {
  motion_->integrals(position_, elapsed, integrals);
}

std::vector<double> RigidFlight::amplitude_integrals(double elapsed) const {
  std::vector<double> integrals(line_.amplitude);
  for (std::size_t mode = 0; mode < integrals.size(); ++mode) {
    const double steady = rate_.amplitude.empty() ? 0.0 : rate_.amplitude[mode];
    integrals[mode] = elapsed * (integrals[mode] + 0.5 * elapsed * steady);
  }
  return integrals;
}

/// At the end or at equal times before it.
void RigidFlight::track_line() const {
  constexpr int kSamples = 16;
  for (const ContactSet& set : contacts_->sets) {
    for (std::size_t node = set.first; node < set.last; ++node) {
      const Powers powers = distance(set, node, length_, true);
      for (int k = 1; k <= kSamples; ++k) {
        const double share = static_cast<double>(k) / kSamples;
        const double gap = power_series::value(powers.data(), powers.size(), share);
        contact_->record_gap(gap, node, begin_ + share * length_);
      }
    }
  }
}

}  // namespace udar
