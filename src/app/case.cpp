#include "udar/app/case.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numbers>
#include <sstream>
#include <utility>

#include "app/input/readers.hpp"
#include "udar/app/filter_choice.hpp"
#include "udar/integrators/features.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/session.hpp"

namespace udar::app {
namespace {

/// The longest step, at most `wished`, that divides the interval between rows and the end of the run, if such a one
/// exists without many steps for every row, else the end alone.
double even_step(double wished, double interval, double end) {
  constexpr double kWhole = 1e-9;  // far from an integer by less: decimal fractions that rounding has touched
  constexpr int kMany = 20;
  double whole = end;
  for (int parts = kMany; parts > 0; --parts) {
    const double rows = end / interval * parts;
    whole = std::abs(rows - std::round(rows)) < kWhole * rows ? interval / parts : whole;
  }
  return whole / std::ceil(whole / wished * (1.0 - kWhole));
}

FilterParameters settled_filter(MPI_Comm comm, const CaseInput& input, const ModelParameters& model) {
  FilterParameters filter = input.filter.parameters;
  if (input.filter.modal) {
    constexpr double kSample = 1e-4;  // [s], of forces and rows alone: nothing is integrated in steps
    filter.step = kSample;
    return filter;
  }
  if (!filter.filtered() && input.time.step > 0.0) {
    filter.step = even_step(input.time.step, input.output.output.interval, input.time.end);
  }
  if (petsc::Session::help_requested()) {
    constexpr double kAny = 100.0;
    filter.filter_frequency = filter.filtered() && filter.filter_frequency > 0.0 ? filter.filter_frequency : kAny;
    return filter;
  }
  return input.filter.automatic ? choose_filter(comm, model, input.filter) : filter;
}

/// Impacts come as often as the fastest springs swing: over less than half a period of these a mean says nothing.
/// Contact on the line has forces of its own, and the unfiltered beam one in every step.
double settled_force_window(double asked, const Case& settled) {
  const double resolved = std::numbers::pi / settled.filter.shift();
  if (settled.contact.surface == ContactSurface::mass && asked > 0.0 && asked < resolved) {
    std::ostringstream message;
    message << "option -output_force_window: " << asked
            << " is not allowed, expected a number >= pi / -filter_frequency = " << resolved
            << " [s], the shortest time over which impacts make a force";
    throw InputError{message.str()};
  }
  return asked > 0.0 ? asked : resolved;
}

/// What can be known of gauges before the structure is built.
void check_gauges(const CaseInput& input) {
  for (const Place& gauge : input.output.gauges) {
    if (input.structure.beam()) {
      require_on("gauge position", gauge.x, {.from = 0.0, .to = input.beam.beam.length()});
    }
  }
}

/// What is of beams alone.
void check_weighting(const CaseInput& input) {
  if (!input.structure.beam() && input.contact.tributary) {
    throw InputError{
        "option -support_weighting: tributary is not allowed but with a beam, expected inclusive, or none: masses of "
        "other structures are what their nodes have"};
  }
}

/// What goes without filter.
void check_unfiltered(const CaseInput& input) {
  if (input.filter.modal && input.structure.imported) {
    throw InputError{
        "option -ts_type: modal is not allowed with imported matrices, whose forces it cannot tell from displacements, "
        "expected a beam or a network; others need -filter_frequency [rad/s]"};
  }
  if (!input.filter.modal && !input.filter.parameters.filtered() && input.structure.network) {
    throw InputError{
        "option -filter_frequency: none is not allowed with a network, expected a number > 0 [rad/s], or -ts_type "
        "modal"};
  }
}

/// What needs a beam to run along.
void check_axles(const CaseInput& input) {
  const auto gap = [](const BeamSegment& segment) { return segment.is_gap(); };
  if (!input.start.travelling_loads.empty() &&
      (!input.structure.beam() || std::ranges::any_of(input.beam.beam.segments, gap))) {
    throw InputError{"option -load_axles is not allowed but with a beam without gaps"};
  }
}

/// What knows nothing of a beam that yields.
void check_yielding(const CaseInput& input) {
  if (!input.structure.beam() || !input.beam.beam.yields()) {
    return;
  }
  if (input.filter.exact.any()) {
    throw InputError{
        "option -beam_yield_moment is not allowed with -filter_correct_modes and -filter_correct_mode: modes of a beam "
        "that stays elastic are none of one that yields"};
  }
  const std::vector<HingePlace>& places = input.beam.beam.plasticity.places;
  if (input.filter.parameters.filtered() && !input.filter.modal && (places.empty() || places.size() > kFewPoints)) {
    throw InputError{"option -beam_hinge_position: with a filter a beam yields at few places, expected up to " +
                     std::to_string(kFewPoints) + " [m]; with -filter_frequency none it may yield at every node"};
  }
}

/// An end that may not turn does not turn at the start. Displacements of what is held are checked by the structure.
void check_pivot(const CaseInput& input) {
  if (!input.start.initial.pivot) {
    return;
  }
  const auto [x, y, z] = input.start.initial.spin;
  const std::array turning{x, y, z + input.start.initial.angular_velocity};
  const auto turned = [&](const Junction& junction) {
    return (junction.held[3] && turning[0] != 0.0) || (junction.held[4] && turning[1] != 0.0) ||
           (junction.held[5] && turning[2] != 0.0);
  };
  const BeamParameters& beam = input.beam.beam;
  const bool clamped = std::isinf(beam.left.rotational_stiffness) || std::isinf(beam.right.rotational_stiffness);
  if ((input.structure.beam() && clamped) ||
      (input.structure.network && std::ranges::any_of(input.structure.network->junctions, turned))) {
    throw InputError{
        "option -initial_pivot is not allowed with an end or a junction that is held against that rotation, expected "
        "pinned ones"};
  }
}

/// Loads of one law share its table; one is no larger than all together may be.
void make_law_tables(std::vector<NodalLoad>& loads, double end) {
  constexpr std::size_t kMostRows = 10'000'000;
  std::size_t rows = 0;
  for (std::size_t i = 0; i < loads.size(); ++i) {
    if (loads[i].law) {
      const auto same = std::ranges::find(loads, loads[i].law, &NodalLoad::law);
      const auto first = static_cast<std::size_t>(same - loads.begin());
      loads[i].table = first < i ? loads[first].table : law_table(*loads[i].law, end);
      rows += first < i ? 0 : loads[i].table->time().size();
    }
    if (rows > kMostRows) {
      throw InputError{"option -load_law: the tables of the first " + std::to_string(i + 1) + " loads have " +
                       std::to_string(rows) + " rows, expected at most " + std::to_string(kMostRows) +
                       ": earlier -load_until or a larger -load_accuracy"};
    }
  }
}

/// What knows nothing of strikers, nor of pairs of nodes.
void check_strikes(const CaseInput& input) {
  if (input.contact.strikers.empty() && input.contact.pairs.empty()) {
    return;
  }
  const std::string given = input.contact.strikers.empty() ? "-pair_*" : "-striker_position";
  if (input.filter.modal || !input.filter.parameters.filtered()) {
    throw InputError{"option " + given +
                     " is not allowed with -ts_type modal, nor with -filter_frequency none: strikers and nodes hit "
                     "masses on filter springs"};
  }
  if (input.contact.contact.surface == ContactSurface::line) {
    throw InputError{"option -contact_surface: line is not allowed with " + given + ", expected mass"};
  }
  if (input.filter.exact.any()) {
    throw InputError{"options -filter_correct_modes and -filter_correct_mode are not allowed with " + given};
  }
  if (!input.contact.strikers.empty() && input.start.initial.spins()) {
    throw InputError{"option -initial_spin is not allowed with -striker_position"};
  }
}

/// What needs masses that move along x and z, too.
void check_space(const CaseInput& input) {
  if (input.structure.network) {
    return;
  }
  if (std::ranges::any_of(input.contact.supports, [](const Support& support) { return support.field != nullptr; })) {
    throw InputError{
        "option -support_height_field is not allowed without -structure_type network, expected -ground_profile: masses "
        "of others move along one axis"};
  }
  if (input.contact.faces_in_space) {
    throw InputError{
        "options -support_normal, -support_friction, -support_y_* and -support_z_* are not allowed without "
        "-structure_type network"};
  }
  const auto across = [](const BaseMotion& motion) {
    return motion.direction().x != 0.0 || motion.direction().z != 0.0;
  };
  if (input.structure.beam() && (std::ranges::any_of(input.start.base_motion, across) ||
                                 std::ranges::any_of(input.start.held_motion, across, &HeldMotion::motion))) {
    throw InputError{"option -base_motion_direction: not allowed with a beam, whose masses move along y alone"};
  }
  if (input.start.in_space) {
    throw InputError{
        "options -initial_velocity_x, -initial_velocity_z, -initial_part and -initial_spin are not allowed without "
        "-structure_type network"};
  }
}

/// The planes that nodes face, if some have a normal along no axis.
std::vector<FacedPlane> faced_planes(const std::vector<Support>& supports) {
  const auto oblique = [](const Support& support) {
    return support.field || std::max({support.normal.x, support.normal.y, support.normal.z}) != 1.0;
  };
  std::vector<FacedPlane> planes;
  for (const Support& support : supports) {
    if (support.strike >= 0) {
      continue;
    }
    if (support.width == 0.0 && std::ranges::any_of(supports, oblique)) {
      throw InputError{
          "option -support_width: 0 is not allowed where a -support_normal is oblique or a -support_height_field is "
          "given, expected a width that holds the nodes, or inf [m]"};
    }
    planes.push_back({.region = support.region(), .facing = support.facing()});
  }
  return std::ranges::any_of(supports, oblique) ? planes : std::vector<FacedPlane>{};
}

}  // namespace

std::optional<std::size_t> Case::striker_of(const Support& support) const {
  const auto strike = static_cast<std::size_t>(support.strike);
  return support.strike >= 0 && strike < strikers.size() ? std::optional{strike} : std::nullopt;
}

std::optional<std::size_t> Case::pair_of(const Support& support) const {
  const auto strike = static_cast<std::size_t>(support.strike);
  return support.strike >= 0 && strike >= strikers.size() ? std::optional{strike - strikers.size()} : std::nullopt;
}

CaseInput read_case(MPI_Comm comm) {
  CaseInput input;
  input.structure = read_structure(comm);
  if (input.structure.beam() || petsc::Session::help_requested()) {
    input.beam = read_beam(comm);
  }
  input.filter = read_filter(comm, input.beam.formulation);
  if (!petsc::Session::help_requested()) {
    check_unfiltered(input);
  }
  input.start = read_start(comm);
  input.start.loads = read_loads(comm, input.structure.network);
  input.start.travelling_loads = read_travelling_loads(comm);
  auto [base, held] = read_base_motion(comm, input.structure.network);
  input.start.base_motion = std::move(base);
  input.start.held_motion = std::move(held);
  input.contact = read_contact(comm, input.structure.network);
  auto [strikers, faces] = read_strikers(comm, input.structure);
  input.contact.strikers = std::move(strikers);
  std::ranges::move(faces, std::back_inserter(input.contact.supports));
  auto [pairs, faces_of_pairs] = read_pairs(comm, input.structure, input.contact.strikers.size());
  input.contact.pairs = std::move(pairs);
  std::ranges::move(faces_of_pairs, std::back_inserter(input.contact.supports));
  input.output = read_output(comm, input.structure);
  check_gauges(input);
  check_weighting(input);
  check_space(input);
  check_axles(input);
  check_pivot(input);
  check_strikes(input);
  check_yielding(input);
  input.time = read_time(comm, !input.filter.parameters.filtered() && !input.filter.modal);
  return input;
}

Case resolve(MPI_Comm comm, const CaseInput& input) {
  Case settled;
  settled.beam = input.beam.beam;
  settled.beam.mass_patches = input.contact.mass_patches;
  settled.imported = input.structure.imported;
  settled.network = input.structure.network;
  if (settled.network) {
    settled.network->planes = faced_planes(input.contact.supports);
  }
  settled.write = input.structure.write;
  settled.filter = settled_filter(comm, input, settled);
  settled.gravity = input.start.gravity;
  settled.loads = input.start.loads;
  settled.travelling_loads = input.start.travelling_loads;
  settled.base_motion = input.start.base_motion;
  settled.held_motion = input.start.held_motion;
  settled.damping = input.start.damping;
  settled.damping_ratio = input.start.damping_ratio;
  settled.initial = input.start.initial;
  settled.supports = input.contact.supports;
  settled.strikers = input.contact.strikers;
  settled.pairs = input.contact.pairs;
  settled.field_tolerance = input.contact.field_tolerance;
  settled.contact = input.contact.contact;
  if (!settled.filter.filtered()) {  // masses and line are one
    settled.contact.surface = ContactSurface::line;
  }
  settled.exact = input.filter.exact;
  settled.modal = input.filter.modal;
  settled.modal_estimate = input.filter.modal_estimate;
  settled.gauges = input.output.gauges;
  settled.output = input.output.output;
  settled.output.force_window = settled_force_window(input.output.output.force_window, settled);
  settled.restart = input.output.restart;
  settled.wall_limit = input.output.wall_limit;
  settled.end_time = input.time.end;
  make_law_tables(settled.loads, settled.end_time);
  settled.guard = input.output.guard;
  settled.view = input.output.view;
  return settled;
}

}  // namespace udar::app
