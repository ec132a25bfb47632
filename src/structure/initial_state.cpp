#include "udar/structure/initial_state.hpp"

#include "udar/numerics/polyline.hpp"

namespace udar {
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
