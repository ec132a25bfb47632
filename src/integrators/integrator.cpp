#include "udar/integrators/integrator.hpp"

#include <string>

#include "udar/petsc/error.hpp"

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

LineState saved_line(const MotionState& state, const Equations& equations, std::size_t size) {
  const auto table = [&state](const char* name, std::size_t expected) {
    const auto found = state.tables.find(name);
    std::vector<double> values = found != state.tables.end() ? found->second : std::vector<double>{};
    if (!values.empty() && values.size() != expected) {
      throw InputError{std::string{"restart file: the table '"} + name + "' has " + std::to_string(values.size()) +
                       " numbers, expected " + std::to_string(expected)};
    }
    return values;
  };
  const LineContact* const contact = equations.line_contact();
  const std::size_t forces = contact != nullptr ? contact->points().size() : 0;
  return {.time = state.scalar("time"),
          .begin = state.scalar("time"),
          .stretch = state.field("stretch", size),
          .amplitude = table("amplitude", equations.line().corrected_modes().size()),
          .moment = {},
          .contact_force = table("contact_force", forces)};
}

}  // namespace udar
