#include "udar/app/rebound.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "udar/petsc/error.hpp"

namespace udar::app {

double ReboundSearch::speed(const Row& row) const {
  const double away = impact_->velocity > 0.0 ? -1.0 : 1.0;
  const double squared = row.velocity * row.velocity + 2.0 * gravity_ * (row.height - impact_->height);
  return away * row.velocity > 0.0 && squared > 0.0 ? std::sqrt(squared) : 0.0;
}

void ReboundSearch::begin(double first_contact) {
  const double fall = first_contact - before_->time;
  impact_ = Row{.time = first_contact,
                .height = before_->height + before_->velocity * fall - 0.5 * gravity_ * fall * fall,
                .velocity = before_->velocity - gravity_ * fall};
}

void ReboundSearch::add(const Row& row, std::optional<double> first_contact) {
  // A beam that turns down again before it has a tenth of its impact speed is still in the same contact.
  constexpr double kTurned = 0.1;
  // In flight the speed is the same to the error of the integration, which is below this.
  constexpr double kSame = 1e-6;
  if (!first_contact || row.time <= *first_contact) {
    before_ = row;
    return;
  }
  if (over_ || !before_) {
    return;
  }
  if (!impact_) {
    begin(*first_contact);
  }
  const double away = impact_->velocity > 0.0 ? -1.0 : 1.0;
  if (turned_ && away * row.velocity <= 0.0) {
    over_ = true;
    return;
  }
  turned_ = turned_ || away * row.velocity > kTurned * std::abs(impact_->velocity);
  const double now = speed(row);
  best_ = std::max(best_, now);
  const double limit = (1.0 - kSame) * best_;
  while (!fast_.empty() && fast_.front().speed < limit) {
    fast_.pop_front();
  }
  // Of those that are fast enough the first counts, and after it only what may outlast it.
  if (now > 0.0 && now >= limit && (fast_.empty() || now > fast_.back().speed)) {
    fast_.push_back({.time = row.time, .speed = now});
  }
}

Rebound ReboundSearch::found() const {
  if (!impact_ || impact_->velocity == 0.0) {
    return {};
  }
  if (best_ == 0.0) {
    return {.impact = impact_->velocity, .velocity = {}, .contact_time = {}};
  }
  return {.impact = impact_->velocity,
          .velocity = (impact_->velocity > 0.0 ? -1.0 : 1.0) * best_,
          .contact_time = fast_.front().time - impact_->time};
}

std::vector<double> ReboundSearch::saved() const {
  std::vector<double> all;
  for (const auto& row : {before_, impact_}) {
    const Row values = row.value_or(Row{});
    all.insert(all.end(), {row ? 1.0 : 0.0, values.time, values.height, values.velocity});
  }
  all.insert(all.end(), {turned_ ? 1.0 : 0.0, over_ ? 1.0 : 0.0, best_});
  for (const Fast& one : fast_) {
    all.insert(all.end(), {one.time, one.speed});
  }
  return all;
}

void ReboundSearch::restore(const std::vector<double>& saved) {
  constexpr std::size_t kRow = 4;
  constexpr std::size_t kHead = 2 * kRow + 3;
  if (saved.size() < kHead || (saved.size() - kHead) % 2 != 0) {
    throw InputError{"restart file: the search for the rebound has " + std::to_string(saved.size()) + " numbers"};
  }
  const auto row = [&saved](std::size_t at) {
    return saved[at] != 0.0
               ? std::optional{Row{.time = saved[at + 1], .height = saved[at + 2], .velocity = saved[at + 3]}}
               : std::nullopt;
  };
  before_ = row(0);
  impact_ = row(kRow);
  turned_ = saved[kHead - 3] != 0.0;
  over_ = saved[kHead - 2] != 0.0;
  best_ = saved[kHead - 1];
  fast_.clear();
  for (std::size_t i = kHead; i < saved.size(); i += 2) {
    fast_.push_back({.time = saved[i], .speed = saved[i + 1]});
  }
  if (best_ > 0.0 && fast_.empty()) {
    throw InputError{"restart file: the search for the rebound has a speed and no row of it"};
  }
}

}  // namespace udar::app
