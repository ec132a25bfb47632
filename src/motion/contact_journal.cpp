#include "udar/motion/contact_journal.hpp"

#include <algorithm>

namespace udar {

void ContactJournal::record_impact(std::size_t node, ImpactRecord impact) {
  impact.node = points_->global(node);
  impact.x = points_->place(node).x;
  impacts_.push_back(impact);
}

void ContactJournal::record_rest(std::size_t node, PetscInt support, double time) {
  rests_.push_back(
      {.time = time, .node = points_->global(node), .x = points_->place(node).x, .support = support, .release = false});
}

void ContactJournal::record_release(std::size_t node, PetscInt support, double time) {
  record_rest(node, support, time);
  rests_.back().release = true;
}

void ContactJournal::record_line_contact(Interval time) {
  const double from = line_contact_ ? std::min(line_contact_->from, time.from) : time.from;
  line_contact_ = {.from = from, .until = time.until};
}

double ContactJournal::lost_before(double time) const {
  double sum = 0.0;
  for (const ImpactRecord& impact : impacts_) {
    sum += impact.time < time ? impact.energy_loss : 0.0;
  }
  for (const Loss& loss : losses_) {
    sum += loss.time < time ? loss.energy : 0.0;
  }
  return sum;
}

void ContactJournal::add_impulses(double time, double passed, std::span<double> sums) const {
  for (const ImpactRecord& impact : impacts_) {
    sums[static_cast<std::size_t>(impact.support)] += impact.time < time ? impact.impulse : 0.0;
  }
  for (std::size_t support = 0; support < even_impulses_.size(); ++support) {
    sums[support] += passed * even_impulses_[support];
  }
  for (const Force& force : forces_) {
    const auto [from, until] = force.time;
    const double share = time >= until ? 1.0 : time > from ? (time - from) / (until - from) : 0.0;
    sums[static_cast<std::size_t>(force.support)] += share * force.impulse;
  }
}

void ContactJournal::clear() {
  release_if_large(impacts_);
  release_if_large(rests_);
  std::ranges::fill(even_impulses_, 0.0);
  forces_.clear();
  contacts_.clear();
  losses_.clear();
  line_contact_.reset();
  flow_ = {};
}

}  // namespace udar
