#include "udar/contact/impact_law.hpp"

#include <algorithm>

namespace udar {

ContactOutcome resolve_contact(const TouchingMass& mass, const ImpactLaw& law, double hop_tolerance) {
  ContactOutcome outcome{.velocity = std::max(mass.velocity, 0.0), .impact = mass.velocity < 0.0};
  if (outcome.impact) {
    outcome.velocity = law.after(mass.velocity);
  }
  const double hop = outcome.velocity * outcome.velocity;  // times 1 / (2 |a|)
  if (mass.acceleration <= mass.resolution && hop <= std::max(0.0, -2.0 * mass.acceleration * hop_tolerance)) {
    outcome.rests = true;
    outcome.velocity = 0.0;
  }
  outcome.energy_loss = 0.5 * mass.mass * (mass.velocity * mass.velocity - outcome.velocity * outcome.velocity);
  return outcome;
}

}  // namespace udar
