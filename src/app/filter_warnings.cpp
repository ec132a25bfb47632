#include "udar/app/filter_warnings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>

#include "udar/petsc/error.hpp"
#include "udar/petsc/warnings.hpp"

namespace udar::app {
namespace {

// More distortion or sag than this is worth a warning.
constexpr double kWarningShare = 0.1;
// Springs of supports that are so much faster than the filter springs make an explicit integrator slow.
constexpr double kStiff = 3.0;

}  // namespace

SupportSprings support_springs(const FilteredStructure& line, const Case& input) {
  const MassPoints& points = line.points();
  if (!line.parameters().filtered() || input.contact.surface == ContactSurface::line) {
    return {};  // nothing gives way
  }
  const double wf2 = line.filter_frequency() * line.filter_frequency();
  const MassState masses = initial_masses(points, input.initial);
  double stiffness = 0.0;
  double drop = std::numeric_limits<double>::infinity();
  const Contacts contacts = find_contacts(points, input.supports);
  for (const ContactSet& set : contacts.sets) {
    const Support& support = contacts.supports[static_cast<std::size_t>(set.support)];
    const bool below = set.side > 0.0 && support.normal.y == 1.0 && support.strike < 0;
    for (std::size_t node = set.first; node < set.last && below; ++node) {
      stiffness += wf2 * line.mass()[node];
      drop = std::min(drop, masses.position[node] - set.height(node) - set.lift(0.0).height);
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, &stiffness, 1, MPI_DOUBLE, MPI_SUM, points.comm());
  MPI_Allreduce(MPI_IN_PLACE, &drop, 1, MPI_DOUBLE, MPI_MIN, points.comm());
  SupportSprings springs;
  if (stiffness > 0.0) {
    const double gravity = std::max(input.gravity, 0.0);
    const double speed2 = input.initial.velocity * input.initial.velocity + 2.0 * gravity * drop;
    const double resting = points.total_mass() * gravity / stiffness;
    springs = {.stiffness = stiffness,
               .drop = drop,
               .predicted_sag = resting + std::sqrt(resting * resting + speed2 * points.total_mass() / stiffness)};
  }
  return springs;
}

void print_warnings(const Case& input, const FilteredStructure& line, const std::vector<Mode>& modes,
                    const SupportSprings& springs) {
  const MPI_Comm comm = line.points().comm();
  if (line.parameters().filtered() && !modes.empty() && !modes.front().corrected &&
      modes.front().distortion() < -kWarningShare) {
    petsc::warn(comm,
                "the filter lowers the first bending frequency from %.4g to %.4g rad/s (%.0f %%); "
                "the curves are qualitative. -filter_frequency auto would keep it to 1 %%, with %.3g rad/s, and "
                "-filter_correct_modes 1 would not lower it",
                modes.front().frequency, modes.front().filtered, 100.0 * modes.front().distortion(),
                filter_frequency_for(modes.front().frequency, 0.01));
  }
  if (springs.predicted_sag > kWarningShare * springs.drop && springs.stiffness > 0.0) {
    petsc::warn(comm,
                "the line is predicted to sink %.3g m through its supports (drop %.3g m, "
                "support stiffness %.3g N/m)%s",
                springs.predicted_sag, springs.drop, springs.stiffness,
                std::ranges::any_of(input.supports, [](const Support& s) { return s.width == 0.0; })
                    ? "; under point supports this grows without limit on finer meshes: give -support_width, or "
                      "-contact_surface line"
                    : "");
  }
  const double angle = 2.0 / line.filter_frequency() * (modes.empty() ? 0.0 : modes.front().frequency);
  if (!line.parameters().filtered() && !input.modal && angle > 1.0) {
    petsc::warn(comm,
                "the time step of %g s is %.3g times 1 / w1 of the beam's first bending frequency w1 = %.4g rad/s: it "
                "does not resolve even its slowest vibration; lower -ts_dt",
                2.0 / line.filter_frequency(), angle, modes.front().frequency);
  }
  double fastest = 0.0;  // of a mass on a support's spring [1/s^2]; runs know it whatever rank they are on
  const Contacts contacts = find_contacts(line.points(), input.supports);
  for (const ContactSet& set : contacts.sets) {
    fastest = input.contact.surface == ContactSurface::mass ? std::max(fastest, set.stiffness) : 0.0;
  }
  MPI_Allreduce(MPI_IN_PLACE, &fastest, 1, MPI_DOUBLE, MPI_MAX, comm);
  const double ratio = std::sqrt(fastest) / line.filter_frequency();
  std::array<char, 32> type{};
  UDAR_CALL(PetscOptionsGetString(nullptr, nullptr, "-ts_type", type.data(), type.size(), nullptr));
  if (ratio > kStiff && std::string_view{type.data()} == TSRK) {
    petsc::warn(comm,
                "masses on the springs of their supports are %.3g times as fast as the filter "
                "frequency: -ts_type rk takes steps as short as that while they touch; -ts_type impact does "
                "not",
                ratio);
  }
}

}  // namespace udar::app
