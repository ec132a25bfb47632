#include "udar/dynamics/initial_state.hpp"

#include <algorithm>

namespace udar {
namespace {

double interpolate(const std::vector<double>& x, const std::vector<double>& y, double at) {
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

}  // namespace

MassState initial_masses(const BeamChain& beam, const InitialState& initial) {
  MassState masses;
  for (PetscInt node = beam.begin(); node < beam.end(); ++node) {
    const double x = beam.position(node);
    const bool held = beam.held(node);
    masses.position.push_back(initial.axis(x, beam.length()) +
                              (held ? 0.0 : interpolate(initial.shape.x, initial.shape.offset, x)));
    masses.velocity.push_back(held ? 0.0
                                   : initial.velocity + initial.angular_velocity * (x - 0.5 * beam.length()) +
                                         interpolate(initial.shape.x, initial.shape.velocity, x));
  }
  return masses;
}

}  // namespace udar
