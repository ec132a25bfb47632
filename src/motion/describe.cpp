#include "udar/motion/describe.hpp"

namespace udar {

void describe(Description& all, const Damping& damping) {
  const auto& [mass, stiffness] = damping;
  all.add("damping of masses [1/s]", mass);
  all.add("damping of stiffness [s]", stiffness);
}

void describe(Description& all, const ContactParameters& contact) {
  const auto& [hop_tolerance, surface, line_dense_max] = contact;
  static_cast<void>(hop_tolerance);  // numerical, as those of the integrator, which may differ too
  const bool line = surface == ContactSurface::line;
  all.add("contact surface", line ? "line" : "mass");
  all.add("contact nodes solved as few, at most", line ? static_cast<double>(line_dense_max) : 0.0);
}

}  // namespace udar
