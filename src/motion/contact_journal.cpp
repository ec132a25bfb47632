#include "udar/motion/contact_journal.hpp"

#include <algorithm>
#include <functional>

namespace udar {

void ContactJournal::set_scratch_folder(const std::string& folder) {
  impacts_.set_folder(folder);
  rests_.set_folder(folder);
  forces_.set_folder(folder);
  contacts_.set_folder(folder);
  losses_.set_folder(folder);
}

void ContactJournal::record_impact(std::size_t node, ImpactRecord impact) {
  impact.node = points_->global(node);
  impact.x = points_->place(node).x;
  impacts_.push_back(impact);
  before_.time = std::numeric_limits<double>::quiet_NaN();
}

void ContactJournal::record_rest(std::size_t node, PetscInt support, double time) {
  rests_.push_back(
      {.time = time, .node = points_->global(node), .x = points_->place(node).x, .support = support, .release = false});
}

void ContactJournal::record_release(std::size_t node, PetscInt support, double time) {
  rests_.push_back(
      {.time = time, .node = points_->global(node), .x = points_->place(node).x, .support = support, .release = true});
}

void ContactJournal::record_line_contact(Interval time) {
  const double from = line_contact_ ? std::min(line_contact_->from, time.from) : time.from;
  line_contact_ = {.from = from, .until = time.until};
}

const ContactJournal::Sums& ContactJournal::impacts_before(double time) const {
  if (before_.time != time) {
    before_.time = time;
    before_.lost = 0.0;
    before_.impulses.assign(even_impulses_.size(), 0.0);
    for (const ImpactRecord& impact : impacts_) {
      const bool before = impact.time < time;
      before_.lost += before ? impact.energy_loss : 0.0;
      before_.impulses[static_cast<std::size_t>(impact.support)] += before ? impact.impulse : 0.0;
    }
  }
  return before_;
}

double ContactJournal::lost_before(double time) const {
  double sum = impacts_before(time).lost;
  for (const Loss& loss : losses_) {
    sum += loss.time < time ? loss.energy : 0.0;
  }
  return sum;
}

void ContactJournal::add_impulses(double time, double passed, std::span<double> sums) const {
  std::ranges::transform(sums, impacts_before(time).impulses, sums.begin(), std::plus{});
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
  impacts_.clear();
  before_.time = std::numeric_limits<double>::quiet_NaN();
  rests_.clear();
  std::ranges::fill(even_impulses_, 0.0);
  forces_.clear();
  contacts_.clear();
  losses_.clear();
  line_contact_.reset();
  flow_ = {};
}

}  // namespace udar
