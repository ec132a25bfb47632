#include "udar/integrators/line_distance.hpp"

#include <algorithm>
#include <limits>

#include "udar/numerics/power_series.hpp"

namespace udar {

LineDistance::LineDistance(Sweep& sweep, ContactState& contact, const StepSupports& supports)
    : sweep_{&sweep}, contact_{&contact}, supports_{&supports}, line_bernstein_{legendre_bernstein(sweep.terms)} {}

void LineDistance::track() {
  for (std::size_t index = 0; index < contact_->runs().size(); ++index) {
    const ContactSet& run = contact_->runs()[index];
    const auto [lowest_lift, highest_lift] = supports_->bounds_of_lift(index);
    const double level = run.level + (run.side > 0.0 ? highest_lift : lowest_lift);
    block_low_.clear();
    for (std::size_t first = run.first; first < run.last; first += kBlock) {
      block_low_.push_back(lowest_of_block(run, first, std::min(kBlock, run.last - first)) - run.side * level);
    }
    // The lowest blocks first: after one or two no other can be lower.
    for (;;) {
      const auto lowest = std::ranges::min_element(block_low_);
      if (!contact_->smallest(*lowest)) {
        break;
      }
      *lowest = std::numeric_limits<double>::infinity();
      const std::size_t first = run.first + kBlock * static_cast<std::size_t>(lowest - block_low_.begin());
      track_nodes(index, first, std::min(first + kBlock, run.last));
    }
  }
}

/// A bound from below of `run.side` times the line's height [m].
double LineDistance::lowest_of_block(const ContactSet& run, std::size_t first, std::size_t count) const {
  const double* heights = run.profile.empty() ? nullptr : run.profile.data() + (first - run.first);
  BlockRows rows = sweep_->rows(first);
  std::vector<double> line;
  if (!sweep_->corrected.empty()) {
    line.resize(sweep_->terms * kBlock);
    for (std::size_t j = 0; j < sweep_->terms; ++j) {
      rows.line[j] = line.data() + j * kBlock;
      for (std::size_t i = 0; i < count; ++i) {
        rows.line[j][i] = sweep_->line(j, first + i);
      }
    }
  }
  return lowest_line(sweep_->terms, rows, count, run.side, heights, line_bernstein_);
}

void LineDistance::track_nodes(std::size_t index, std::size_t first, std::size_t last) {
  const ContactSet& run = contact_->runs()[index];
  for (std::size_t node = first; node < last; ++node) {
    const auto powers = sweep_->powers([&](std::size_t j) { return sweep_->line(j, node); });
    for (int k = 1; k <= 8; ++k) {
      const double tau = 0.125 * k;
      const double line = sweep_->start[node] + power_series::value(powers.data(), sweep_->terms, tau);
      const double lift = power_series::value(supports_->lift(index).data(), 4, tau);
      contact_->line_at(run.side * (line - run.height(node) - lift), node, sweep_->begin + tau * sweep_->step);
    }
  }
}

}  // namespace udar
