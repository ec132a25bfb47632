#include "udar/integrators/integrator.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "udar/petsc/error.hpp"

namespace udar {

double time_resolution(double time) {
  constexpr double kInstantUnits = 4.0;  // units in the last place
  return kInstantUnits * std::numeric_limits<double>::epsilon() * std::abs(time);
}

double step_tolerance(TS stepper, const MotionScale& scale) {
  double atol = 0.0;
  double rtol = 0.0;
  PetscBool given = PETSC_FALSE;
  UDAR_CALL(TSGetTolerances(stepper, &atol, nullptr, &rtol, nullptr));
  UDAR_CALL(PetscOptionsHasName(nullptr, nullptr, "-ts_atol", &given));
  return rtol + (given == PETSC_TRUE ? atol / std::max(scale.length, scale.velocity) : 0.0);
}

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
