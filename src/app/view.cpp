#include "udar/app/view.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>
#include <string_view>

#include "udar/app/places.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/warnings.hpp"

namespace udar::app {
namespace {

// More distortion or sag than this is worth a warning.
constexpr double kWarningShare = 0.1;
// Springs of supports that are so much faster than the filter springs make an explicit integrator slow.
constexpr double kStiff = 3.0;

const char* describe(const BeamEnd& end) {
  if (end.fixed()) {
    return end.moment_free() ? "pinned" : "clamped";
  }
  return end.translational_stiffness == 0.0 && end.moment_free() ? "free" : "spring";
}

/// Whether somebody watches standard output. A launcher such as mpirun gives its ranks terminals of their own, none of
/// which controls them, even when its output goes to a file: there the launcher's own output counts, that of the parent
/// process of rank 0 on the same machine.
bool output_is_watched() {
  if (isatty(STDOUT_FILENO) == 0) {
    return false;
  }
  if (tcgetpgrp(STDOUT_FILENO) != -1) {
    return true;
  }
  const int parent = open(("/proc/" + std::to_string(getppid()) + "/fd/1").c_str(), O_WRONLY | O_NOCTTY | O_CLOEXEC);
  const bool watched = parent >= 0 && isatty(parent) != 0;
  if (parent >= 0) {
    close(parent);
  }
  return watched;
}

}  // namespace

SupportSprings support_springs(const FilteredStructure& line, const Case& input) {
  const BeamChain& beam = line.beam();
  if (line.parameters().unfiltered || input.contact.surface == ContactSurface::line) {
    return {};  // nothing gives way
  }
  const double wf2 = line.filter_frequency() * line.filter_frequency();
  const MassState masses = initial_masses(beam.points(), input.initial);
  double stiffness = 0.0;
  double drop = std::numeric_limits<double>::infinity();
  const Contacts contacts = find_contacts(beam.points(), input.supports);
  for (const ContactSet& run : contacts.sets) {
    for (std::size_t node = run.first; node < run.last && run.side > 0.0; ++node) {
      stiffness += wf2 * line.mass()[node];
      drop = std::min(drop, masses.position[node] - run.height(node) - run.lift(0.0).height);
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, &stiffness, 1, MPI_DOUBLE, MPI_SUM, beam.comm());
  MPI_Allreduce(MPI_IN_PLACE, &drop, 1, MPI_DOUBLE, MPI_MIN, beam.comm());
  SupportSprings springs;
  if (stiffness > 0.0) {
    const double gravity = std::max(input.gravity, 0.0);
    const double speed2 = input.initial.velocity * input.initial.velocity + 2.0 * gravity * drop;
    const double resting = beam.total_mass() * gravity / stiffness;
    springs = {.stiffness = stiffness,
               .drop = drop,
               .predicted_sag = resting + std::sqrt(resting * resting + speed2 * beam.total_mass() / stiffness)};
  }
  return springs;
}

void print_view(const Case& input, const FilteredStructure& line, const std::vector<Mode>& modes,
                const SupportSprings& springs) {
  const BeamChain& beam = line.beam();
  const MPI_Comm comm = beam.comm();
  int size = 1;
  MPI_Comm_size(comm, &size);
  const auto elements = static_cast<long long>(beam.elements());
  UDAR_CALL(PetscPrintf(
      comm, "beam: length %g m, %lld elements, mass %g kg, ends %s / %s, %s form, %d rank%s\n", beam.length(), elements,
      beam.total_mass(), describe(beam.parameters().left), describe(beam.parameters().right),
      line.parameters().formulation == Formulation::mixed ? "mixed" : "hermite", size, size > 1 ? "s" : ""));
  std::size_t number = 0;
  for (const BeamSegment& segment : beam.parameters().segments) {
    if (segment.is_gap()) {
      UDAR_CALL(PetscPrintf(comm, "  gap: %g m\n", segment.length));
      continue;
    }
    UDAR_CALL(PetscPrintf(
        comm, "  segment %zu: %g m, %lld elements, EI %g N m^2, rhoA %g kg/m, kGA %g N, foundation %g N/m^2\n",
        number++, segment.length, static_cast<long long>(segment.elements), segment.bending_stiffness,
        segment.mass_per_length, segment.shear_stiffness, segment.foundation_stiffness));
    if (segment.section_modulus > 0.0) {
      UDAR_CALL(PetscPrintf(comm, "    section modulus %g m^3", segment.section_modulus));
      UDAR_CALL(segment.yield_stress > 0.0 ? PetscPrintf(comm, ", yields at %g Pa: at %g N m\n", segment.yield_stress,
                                                         segment.yield_stress * segment.section_modulus)
                                           : PetscPrintf(comm, "\n"));
    } else {
      UDAR_CALL(PetscPrintf(comm, "    section modulus not known: no bending stress (-beam_outer_fibre)\n"));
    }
  }
  for (const LineSupport& support : beam.parameters().line_supports) {
    UDAR_CALL(PetscPrintf(comm, "  line support: %g m, %g N/m\n", support.position, support.stiffness));
  }
  UDAR_CALL(PetscPrintf(comm,
                        "start: axis at %g m, slope %g, velocity %g m/s, angular velocity %g rad/s, gravity %g m/s^2\n",
                        input.initial.height, input.initial.slope, input.initial.velocity,
                        input.initial.angular_velocity, input.gravity));
  if (line.parameters().unfiltered) {
    UDAR_CALL(PetscPrintf(comm, "filter: none, time step %g s\n", 2.0 / line.filter_frequency()));
  } else {
    UDAR_CALL(PetscPrintf(comm,
                          "filter: wf %g rad/s, decay length %g m = %g elements, residual of the first solves %.1e\n",
                          line.filter_frequency(), decay_length(beam, line.filter_frequency()),
                          decay_length(beam, line.filter_frequency()) / beam.length() * static_cast<double>(elements),
                          line.worst_residual()));
  }
  if (line.chain() != nullptr) {
    UDAR_CALL(PetscPrintf(comm, "line solver: chain recursion (details: -filter_ksp_view)\n"));
  } else {
    const std::string reason = line.filter_operator().block_form_reason();
    UDAR_CALL(PetscPrintf(
        comm, "line solver: assembled block form%s (details: -filter_ksp_view)\n",
        reason.empty() ? ", as asked for" : (", because the chain recursion cannot carry it: " + reason).c_str()));
  }
  UDAR_CALL(PetscPrintf(comm, "  mode   w [rad/s]   filtered [rad/s]   error\n"));
  for (std::size_t i = 0; i < modes.size(); ++i) {
    UDAR_CALL(PetscPrintf(comm, "  %4zu %11.5g %18.5g %6.1f %%%s\n", i + 1, modes[i].frequency, modes[i].filtered,
                          100.0 * modes[i].distortion(), modes[i].corrected ? ", corrected to 0" : ""));
  }
  for (std::size_t i = 0; i < input.supports.size(); ++i) {
    const Support& support = input.supports[i];
    const auto [first, last] = touched_nodes(beam, support);
    double mass = 0.0;
    for (PetscInt node = std::max(first, beam.begin()); node <= std::min(last, beam.end() - 1); ++node) {
      mass += line.mass()[static_cast<std::size_t>(node - beam.begin())];
    }
    MPI_Allreduce(MPI_IN_PLACE, &mass, 1, MPI_DOUBLE, MPI_SUM, comm);
    const double wf = line.filter_frequency();
    UDAR_CALL(PetscPrintf(
        comm,
        "support %zu: x %g m, width %g m, height %g m, %s, e %g, nodes %lld to %lld, filter spring stiffness %g N/m\n",
        i, support.position, support.width, support.height, support.side == SupportSide::below ? "below" : "above",
        support.restitution, static_cast<long long>(first), static_cast<long long>(last), wf * wf * mass));
  }
  if (input.damping.any()) {
    UDAR_CALL(PetscPrintf(comm, "damping: %g 1/s of the masses, %g s of the line's springs\n", input.damping.mass,
                          input.damping.stiffness));
  }
  for (std::size_t i = 0; i < input.supports.size(); ++i) {
    const Support& support = input.supports[i];
    if (support.motion) {
      const auto [lowest, highest] = std::ranges::minmax(support.motion->height());
      UDAR_CALL(PetscPrintf(comm, "support %zu moves: %zu rows from %g to %g s, by %g to %g m\n", i,
                            support.motion->time().size(), support.motion->time().front(),
                            support.motion->time().back(), lowest, highest));
    }
    if (support.elastic()) {
      UDAR_CALL(PetscPrintf(comm, "support %zu gives way: spring %g N/m, damper %g N s/m\n", i, support.stiffness,
                            support.damping));
    }
  }
  if (springs.stiffness > 0.0) {
    UDAR_CALL(PetscPrintf(comm,
                          "supports below: stiffness %g N/m, drop %g m, predicted sag of the line through them %g m\n",
                          springs.stiffness, springs.drop, springs.predicted_sag));
  }
  for (const auto& [name, asked, used] : placed_at_nodes(input, beam)) {
    UDAR_CALL(PetscPrintf(comm, "%s: asked x %g m, node %lld at x %g m\n", name.c_str(), asked,
                          static_cast<long long>(beam.nearest_node(asked)), used));
  }
  for (const NodalLoad& load : input.loads) {
    const auto [near, far] = beam.lever(load.position);
    UDAR_CALL(PetscPrintf(comm, "load: x %g m, by node %lld at x %g m (share %g)", load.position,
                          static_cast<long long>(near.node), beam.position(near.node), near.share));
    UDAR_CALL(far.share > 0.0 ? PetscPrintf(comm, " and node %lld at x %g m (share %g)\n",
                                            static_cast<long long>(far.node), beam.position(far.node), far.share)
                              : PetscPrintf(comm, "\n"));
  }
  UDAR_CALL(PetscPrintf(comm, "output: %s, every %g s, fields every %g s\n", input.output.directory.c_str(),
                        input.output.interval, input.output.field_interval));
}

void print_warnings(const Case& input, const FilteredStructure& line, const std::vector<Mode>& modes,
                    const SupportSprings& springs) {
  const MPI_Comm comm = line.beam().comm();
  if (!line.parameters().unfiltered && !modes.empty() && !modes.front().corrected &&
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
  if (line.parameters().unfiltered && angle > 1.0) {
    petsc::warn(comm,
                "the time step of %g s is %.3g times 1 / w1 of the beam's first bending frequency w1 = %.4g rad/s: it "
                "does not resolve even its slowest vibration; lower -ts_dt",
                2.0 / line.filter_frequency(), angle, modes.front().frequency);
  }
  double fastest = 0.0;  // of a mass on a support's spring [1/s^2]; runs know it whatever rank they are on
  const Contacts contacts = find_contacts(line.points(), input.supports);
  for (const ContactSet& run : contacts.sets) {
    fastest = input.contact.surface == ContactSurface::mass ? std::max(fastest, run.stiffness) : 0.0;
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

ProgressLine::ProgressLine(MPI_Comm comm) : begin_{Clock::now()}, last_{begin_} {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  visible_ = rank == 0 && PETSC_STDOUT == stdout && output_is_watched();
}

void ProgressLine::step(const Progress& progress) {
  if (!visible_) {
    return;
  }
  using namespace std::chrono_literals;
  const Clock::time_point now = Clock::now();
  if (first_time_ < 0.0) {
    first_time_ = progress.time;
    begin_ = now;
  }
  if (now - last_ < 200ms) {
    return;
  }
  last_ = now;
  printed_ = true;
  const double done = progress.time - first_time_;
  const double elapsed = std::chrono::duration<double>(now - begin_).count();
  const double left = done > 0.0 ? elapsed * (progress.end_time - progress.time) / done : 0.0;
  std::printf("\r t %.5g / %.5g s  step %lld  impacts %lld  resting %lld  energy drift %+.1e  left %.0f s \033[K",
              progress.time, progress.end_time, static_cast<long long>(progress.steps),
              static_cast<long long>(progress.impacts), static_cast<long long>(progress.resting), progress.energy_drift,
              left);
  std::fflush(stdout);
}

void ProgressLine::finish() {
  if (printed_) {
    std::printf("\n");
    std::fflush(stdout);
    printed_ = false;
  }
}

}  // namespace udar::app
