#include "udar/motion/kinks.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

namespace udar {

double time_resolution(double time) {
  constexpr double kInstantUnits = 4.0;  // units in the last place
  return kInstantUnits * std::numeric_limits<double>::epsilon() * std::abs(time);
}

Kinks::Kinks(const Loads& loads, const std::vector<Support>& supports) : times_{loads.kinks()} {
  for (const Support& support : supports) {
    if (support.motion) {
      times_.insert(times_.end(), support.motion->time().begin(), support.motion->time().end());
    }
  }
  std::ranges::sort(times_);
  times_.erase(std::ranges::unique(times_).begin(), times_.end());
}

double Kinks::after(double time) const {
  const auto kink = std::ranges::upper_bound(times_, time + time_resolution(time));
  return kink != times_.end() ? *kink : std::numeric_limits<double>::infinity();
}

double Kinks::piece_begin(double step_begin, double time) const {
  const auto kink = std::ranges::lower_bound(times_, time - time_resolution(time));
  return kink == times_.begin() ? step_begin : std::max(step_begin, *std::prev(kink));
}

}  // namespace udar
