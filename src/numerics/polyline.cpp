#include "udar/numerics/polyline.hpp"

#include <algorithm>

namespace udar {

double interpolate(std::span<const double> x, std::span<const double> y, double at) {
  if (y.empty()) {
    return 0.0;
  }
  const auto after = std::ranges::lower_bound(x, at);
  if (after == x.begin()) {
    return y.front();
  }
  if (after == x.end()) {
    return y.back();
  }
  const auto right = static_cast<std::size_t>(after - x.begin());
  const double share = (at - x[right - 1]) / (x[right] - x[right - 1]);
  return (1.0 - share) * y[right - 1] + share * y[right];
}

}  // namespace udar
