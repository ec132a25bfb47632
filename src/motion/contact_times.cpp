#include "udar/motion/contact_times.hpp"

#include <algorithm>
#include <limits>

namespace udar {

ContactTimes::ContactTimes(const MassPoints& points, std::span<const ContactSet> sets) : points_{&points} {
  for (const ContactSet& set : sets) {
    touchable_.push_back({set.first, set.last});
  }
  std::ranges::sort(touchable_);
  for (std::size_t i = 1; i < touchable_.size(); ++i) {  // supports may share nodes: each belongs to one range
    auto& [first, last] = touchable_[i];
    first = std::max(first, touchable_[i - 1][1]);
    last = std::max(last, first);
  }
  last_.assign(touchable_.empty() ? 0 : points.points(), -std::numeric_limits<double>::infinity());
}

void ContactTimes::note(const ContactJournal& step, double until) {
  const auto note_event = [&](PetscInt global, double time) {
    if (time < until) {
      double& last = last_[static_cast<std::size_t>(global - points_->begin())];
      last = std::max(last, time);
    }
  };
  for (const ContactJournal::Contact& contact : step.contacts()) {
    if (contact.time.from < until) {
      last_[contact.node] = std::max(last_[contact.node], std::min(contact.time.until, until));
    }
  }
  for (const ImpactRecord& impact : step.impacts()) {
    note_event(impact.node, impact.time);
  }
  for (const RestRecord& rest : step.rests()) {
    note_event(rest.node, rest.time);
  }
}

ContactZone ContactTimes::zone(double since, std::span<const std::uint8_t> resting,
                               std::span<std::uint8_t> touched) const {
  ContactZone zone;
  for (const auto& [first, last] : touchable_) {
    for (std::size_t node = first; node < last; ++node) {
      touched[node] = resting[node] != 0 || last_[node] >= since ? 1 : 0;
      if (touched[node] != 0) {
        const double x = points_->place(node).x;
        ++zone.masses;
        zone.x_min = std::min(zone.x_min, x);
        zone.x_max = std::max(zone.x_max, x);
      }
    }
  }
  return zone;
}

void ContactTimes::restore(std::span<const double> last) { std::copy_n(last.begin(), last_.size(), last_.begin()); }

}  // namespace udar
