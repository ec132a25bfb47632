#include "udar/integrators/integrator.hpp"

namespace udar {

void save_line(const LineState& line, MotionState& state) {
  state.fields["stretch"] = line.stretch;
  if (!line.amplitude.empty()) {
    state.tables["amplitude"] = line.amplitude;
  }
  if (!line.contact_force.empty()) {
    state.tables["contact_force"] = line.contact_force;
  }
}

LineState saved_line(const MotionState& state, std::size_t size) {
  const auto table = [&state](const char* name) {
    const auto found = state.tables.find(name);
    return found != state.tables.end() ? found->second : std::vector<double>{};
  };
  return {.time = state.scalar("time"),
          .begin = state.scalar("time"),
          .stretch = state.field("stretch", size),
          .amplitude = table("amplitude"),
          .moment = {},
          .contact_force = table("contact_force")};
}

}  // namespace udar
