#include "udar/contact/support.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "udar/petsc/error.hpp"

namespace udar {
namespace {

void require(bool condition, const char* quantity, double value, const std::string& expected) {
  if (!condition) {
    std::ostringstream message;
    message << quantity << ": " << value << " is not allowed, expected " << expected;
    throw InputError{message.str()};
  }
}

}  // namespace

BeamChain::NodeRange touched_nodes(const BeamChain& beam, const Support& support) {
  if (std::isinf(support.width)) {
    return {.first = 0, .last = beam.elements()};
  }
  if (support.width == 0.0) {
    const PetscInt node = beam.nearest_node(support.position);
    return {.first = node, .last = node};
  }
  return beam.nodes_within(support.from(), support.to());
}

std::vector<ContactSet> find_contact_sets(const BeamChain& beam, const std::vector<Support>& supports) {
  std::vector<ContactSet> runs;
  for (std::size_t index = 0; index < supports.size(); ++index) {
    const Support& support = supports[index];
    require_on("support position", support.position, beam.points().extent());
    require(support.width >= 0.0, "support width", support.width, "a number >= 0 [m]");
    require(std::isfinite(support.height), "support height", support.height, "a finite number [m]");
    require(support.restitution >= 0.0 && support.restitution <= 1.0, "contact restitution", support.restitution,
            "a number from 0 to 1");
    require(support.yield_speed > 0.0, "support yield speed", support.yield_speed, "a number > 0 or inf [m/s]");
    const BeamChain::NodeRange touched = touched_nodes(beam, support);
    const auto [first, last] = touched;
    require(first <= last, "support width", support.width,
            "0 (the nearest node) or wide enough to hold a node; no node lies within this support [m]");
    require(support.stiffness > 0.0, "support stiffness", support.stiffness, "a number > 0 or inf [N/m]");
    require(support.damping >= 0.0 && std::isfinite(support.damping), "support damping", support.damping,
            "a number >= 0 [N s/m]");
    for (std::size_t other = 0; other < index; ++other) {
      const bool plain = !support.motion && !support.elastic() && !supports[other].motion && !supports[other].elastic();
      const auto nodes = touched_nodes(beam, supports[other]);
      require(plain || support.side != supports[other].side || nodes.last < first || last < nodes.first,
              "support position", support.position,
              "no other support on its side at its nodes, as one of them moves or gives way; floor and ground count");
    }
    const double carried = support.elastic() ? beam.mass_of(touched) : 1.0;
    const auto add = [&](PetscInt from, PetscInt to) {  // global nodes, `to` not included
      if (from < to) {
        ContactSet& run =
            runs.emplace_back(ContactSet{.first = static_cast<std::size_t>(from - beam.begin()),
                                         .last = static_cast<std::size_t>(to - beam.begin()),
                                         .support = static_cast<PetscInt>(index),
                                         .side = static_cast<double>(support.side),
                                         .level = support.height,
                                         .restitution = support.restitution,
                                         .yield_speed = support.yield_speed,
                                         .profile = {},
                                         .motion = support.motion,
                                         .stiffness = support.elastic() ? support.stiffness / carried : 0.0,
                                         .damping = support.elastic() ? support.damping / carried : 0.0});
        for (PetscInt node = from; node < to && !support.profile.x.empty(); ++node) {
          run.profile.push_back(support.height_at(beam.position(node)));
        }
      }
    };
    PetscInt from = std::max(first, beam.begin());
    const PetscInt end = std::min(last + 1, beam.end());
    for (PetscInt node = from; node < end; ++node) {
      if (beam.fixed(node)) {  // its mass never moves
        add(from, node);
        from = node + 1;
      }
    }
    add(from, end);
  }
  return runs;
}

}  // namespace udar
