#include "udar/integrators/line_distance.hpp"

#include <algorithm>
#include <limits>

#include "udar/numerics/power_series.hpp"

namespace udar {

LineDistance::LineDistance(Sweep& sweep, ContactState& contact, const StepSupports& supports)
    : sweep_{&sweep}, contact_{&contact}, supports_{&supports}, line_bernstein_{legendre_bernstein(sweep.terms)} {}

void LineDistance::track() {
  for (std::size_t index = 0; index < contact_->sets().size(); ++index) {
    const ContactSet& set = contact_->sets()[index];
    const auto [lowest_lift, highest_lift] = supports_->bounds_of_lift(index);
    const double level = set.level + (set.side > 0.0 ? highest_lift : lowest_lift);
    block_low_.clear();
    for (std::size_t first = set.first; first < set.last; first += kBlock) {
      block_low_.push_back(lowest_of_block(set, first, std::min(kBlock, set.last - first)) - set.side * level);
    }
    // The lowest blocks first: after one or two no other can be lower.
    for (;;) {
      const auto lowest = std::ranges::min_element(block_low_);
      if (!contact_->smallest(*lowest)) {
        break;
      }
      *lowest = std::numeric_limits<double>::infinity();
      const std::size_t first = set.first + kBlock * static_cast<std::size_t>(lowest - block_low_.begin());
      track_nodes(index, first, std::min(first + kBlock, set.last));
    }
  }
}

/// A bound from below of `set.side` times the line's height [m].
double LineDistance::lowest_of_block(const ContactSet& set, std::size_t first, std::size_t count) const {
  const double* heights = set.profile.empty() ? nullptr : set.profile.data() + (first - set.first);
  BlockRows rows = sweep_->rows(first);
  std::vector<double> line;
  if (!sweep_->series.corrected.empty()) {
    line.resize(sweep_->terms * kBlock);
    for (std::size_t j = 0; j < sweep_->terms; ++j) {
      rows.line[j] = line.data() + j * kBlock;
      for (std::size_t i = 0; i < count; ++i) {
        rows.line[j][i] = sweep_->line(j, first + i);
      }
    }
  }
  return lowest_line(sweep_->terms, rows, count, set.side, heights, line_bernstein_);
}

void LineDistance::track_nodes(std::size_t index, std::size_t first, std::size_t last) {
  const ContactSet& set = contact_->sets()[index];
  for (std::size_t node = first; node < last; ++node) {
    const auto powers = sweep_->powers([&](std::size_t j) { return sweep_->line(j, node); });
    for (int k = 1; k <= 8; ++k) {
      const double tau = 0.125 * k;
      const double line = sweep_->start[node] + power_series::value(powers.data(), sweep_->terms, tau);
      const double lift = power_series::value(supports_->lift(index).data(), 4, tau);
      contact_->record_gap(set.side * (line - set.height(node) - lift), node, sweep_->begin + tau * sweep_->step);
    }
  }
}

}  // namespace udar
