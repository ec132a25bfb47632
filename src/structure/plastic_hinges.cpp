#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "udar/petsc/error.hpp"
#include "udar/structure/beam_chain.hpp"

namespace udar {
namespace {

void refuse_hinge(double position, const char* why) {
  std::ostringstream message;
  message << "beam hinge position: " << position << " m is not allowed, " << why;
  throw InputError{message.str()};
}

}  // namespace

/// Hardening of every node is that of the element halves beside it: their curvature grows by 1 / EI_t - 1 / EI.
std::vector<PlasticHinge> BeamChain::plastic_hinges() const {
  constexpr double kElastic = std::numeric_limits<double>::infinity();
  const BeamPlasticity& plasticity = parameters_.plasticity;
  const auto hinge_at = [&](PetscInt node) {
    PlasticHinge hinge{.node = node, .moment = kElastic};
    double compliance = 0.0;
    for (const PetscInt beside : {node - 1, node}) {
      if (beside >= 0 && beside < elements()) {
        const BeamSegment& segment = parameters_.segments[segment_of_element(beside)];
        hinge.moment = std::min(hinge.moment, segment.is_gap() ? kElastic : segment.yield_moment);
        const BeamElement& half = element(beside);
        compliance += 0.5 * half.length * half.flexural_compliance;
      }
    }
    hinge.hardening = plasticity.tangent_ratio / (1.0 - plasticity.tangent_ratio) / compliance;
    const BeamEnd* end = end_at(node);
    if (end != nullptr && end->moment_free()) {
      hinge.moment = kElastic;
    }
    return hinge;
  };
  std::vector<PlasticHinge> hinges;
  for (const HingePlace& place : plasticity.places) {
    if (place.position > length()) {
      refuse_hinge(place.position, "expected a place on the beam");
    }
    PlasticHinge hinge = hinge_at(nearest_node(place.position));
    hinge.hardening = place.hardening;
    if (std::isinf(hinge.moment)) {
      refuse_hinge(place.position, "expected a place with a yield moment, not a free or pinned end");
    }
    hinges.push_back(hinge);
  }
  for (PetscInt node = 0; node < nodes() && plasticity.places.empty(); ++node) {
    if (const PlasticHinge hinge = hinge_at(node); std::isfinite(hinge.moment)) {
      hinges.push_back(hinge);
    }
  }
  std::ranges::sort(hinges, {}, &PlasticHinge::node);
  const auto twice = std::ranges::adjacent_find(hinges, {}, &PlasticHinge::node);
  if (twice != hinges.end()) {
    refuse_hinge(position(twice->node), "expected one hinge at a node, and two are nearest to this one");
  }
  return hinges;
}

}  // namespace udar
