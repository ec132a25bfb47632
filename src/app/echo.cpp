#include "udar/app/echo.hpp"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <limits>
#include <numbers>
#include <sstream>
#include <string>

#include "udar/app/network_size.hpp"
#include "udar/app/output_size.hpp"
#include "udar/app/places.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/warnings.hpp"
#include "udar/structure/initial_state.hpp"

namespace udar::app {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// A fall from here ends at 140 m/s, faster than anything is dropped on supports.
constexpr double kHighFall = 1000.0;

bool moves_as_rigid(const Case& input, const Structure& structure) {
  const auto gap = [](const BeamSegment& segment) { return segment.is_gap(); };
  return !structure.grounded() && input.loads.empty() && input.travelling_loads.empty() && input.base_motion.empty() &&
         input.initial.shape.x.empty() && input.initial.parts.empty() && std::ranges::none_of(input.beam.segments, gap);
}

/// First zero of gap + speed t - pull t^2 / 2 after the start, for a gap > 0.
double meeting_time(double gap, double speed, double pull) {
  if (pull == 0.0) {
    return speed < 0.0 ? gap / -speed : kInfinity;
  }
  const double square = speed * speed + 2.0 * pull * gap;
  if (square < 0.0) {
    return kInfinity;
  }
  // The form without cancellation: 2 gap / (sqrt(...) - speed); negative where the gap only closes in the past.
  const double time = 2.0 * gap / (std::sqrt(square) - speed);
  return time > 0.0 ? time : kInfinity;
}

const char* name_of(const Structure& structure) {
  return structure.chain() != nullptr ? "beam" : structure.network() != nullptr ? "network" : "structure";
}

std::string sides(std::vector<Support> supports, const Structure& structure) {
  const std::string name = name_of(structure);
  std::erase_if(supports, [](const Support& support) { return support.strike >= 0; });
  const auto above = std::ranges::count(supports, SupportSide::above, &Support::side);
  const auto below = static_cast<std::ptrdiff_t>(supports.size()) - above;
  std::ostringstream text;
  if (supports.empty()) {
    return "none";
  }
  if (structure.network() != nullptr) {  // which has them on all sides
    text << supports.size();
  } else {
    if (below > 0) {
      text << below << " below the " << name;
    }
    if (above > 0) {
      text << (below > 0 ? ", " : "") << above << " above it";
    }
  }
  constexpr std::size_t kListed = 4;
  if (supports.size() <= kListed) {
    const char* before = ", at x = ";
    for (const Support& support : supports) {
      text << before;
      if (support.boxed()) {
        text << "a box";
      } else if (std::isinf(support.width)) {
        text << "all of the " << name;
      } else {
        text << support.position << " m";
      }
      before = ", ";
    }
  }
  return text.str();
}

/// How far springs are pressed at the start, the most of all [m].
double pressed_at_start(const Case& input, const MassPoints& points) {
  double most = 0.0;
  const MassState masses = initial_masses(points, input.initial);
  const Contacts contacts = find_contacts(points, input.supports);
  for (const ContactSet& set : contacts.sets) {
    const double lift = set.lift(0.0).height;
    for (std::size_t node = set.first; set.elastic() && node < set.last; ++node) {
      most = std::max(most, set.side * (set.height(node) + lift - masses.position[node]));
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_DOUBLE, MPI_MAX, points.comm());
  return most;
}

std::string contact_text(const Case& input) {
  if (std::ranges::all_of(input.supports, [](const Support& support) { return support.strike >= 0; })) {
    return "";
  }
  return input.contact.surface == ContactSurface::line ? ", held off the line by forces" : ", hit by the masses";
}

}  // namespace

std::optional<double> expected_contact(const Case& input, const Structure& structure) {
  if (!moves_as_rigid(input, structure) || input.supports.empty()) {
    return std::nullopt;
  }
  const MassPoints& points = structure.points();
  const MassState masses = initial_masses(points, input.initial);
  double first = kInfinity;
  const Contacts contacts = find_contacts(points, input.supports);
  for (const ContactSet& set : contacts.sets) {
    const double lift = set.lift(0.0).height;
    for (std::size_t node = set.first; node < set.last; ++node) {
      const double pull = input.gravity * points.axis(node).y;
      const double gap = set.side * (masses.position[node] - set.height(node) - lift);
      first = std::min(first, gap > 0.0 ? meeting_time(gap, set.side * masses.velocity[node], set.side * pull) : 0.0);
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_DOUBLE, MPI_MIN, points.comm());
  return first < kInfinity ? std::optional{first} : std::nullopt;
}

void print_echo(const Case& input, const FilteredStructure& line, const std::vector<Mode>& modes) {
  const Structure& structure = line.structure();
  const MassPoints& points = structure.elastic().points();  // without what strikes it
  std::ostringstream text;
  text.precision(4);
  if (const BeamChain* beam = structure.chain(); beam != nullptr) {
    text << "beam      " << beam->total_mass() << " kg, " << beam->length() << " m, " << beam->elements()
         << " elements, ";
  } else if (const Network* network = structure.network(); network != nullptr) {
    const NetworkSize size = size_of(*network);
    text << "network   " << points.total_mass() << " kg, " << size.junctions << " junctions, " << size.members
         << " members, " << size.elements << " elements, " << network->total_nodes() << " nodes, "
         << network->connected_parts() << (network->connected_parts() > 1 ? " parts\n" : " part\n") << "extent    "
         << size.extent << ", ";
  } else {
    text << "structure " << points.total_mass() << " kg, x from " << points.extent().from << " to "
         << points.extent().to << " m, " << points.total() << " masses, ";
  }
  text << (structure.grounded() ? "held" : "free") << '\n';
  if (const Network* network = structure.network(); network != nullptr) {
    for (const std::string& note : network->notes()) {
      text << "note      " << note << '\n';
    }
  }
  text << "modes    ";
  for (const Mode& mode : modes) {
    text << ' ' << mode.frequency << (&mode == &modes.back() ? " rad/s" : ",");
  }
  text << (modes.empty() ? " none" : ", without the filter") << '\n';
  if (input.modal) {
    text << "filter    none, modes alone\n";
  } else if (!input.filter.filtered()) {
    text << "filter    none, time step " << 2.0 / line.filter_frequency() << " s\n";
  } else {
    text << "filter    wf = " << line.filter_frequency() << " rad/s";
    if (!modes.empty() && modes.front().corrected) {
      text << ", leaves the first mode as it is";
    } else if (!modes.empty()) {
      text << ", lowers the first mode to " << modes.front().filtered << " rad/s, by "
           << -100.0 * modes.front().distortion() << " %";
    }
    text << '\n';
  }
  for (const BaseMotion& motion : input.base_motion) {
    const auto& [x, y, z] = motion.direction();
    const auto times = motion.acceleration()->time();
    text << "base      moves along (" << x << ", " << y << ", " << z << ") from t = " << times.front() << " to "
         << times.back() << " s with at most " << motion.peak() << " m/s^2, and all is told in its frame\n";
  }
  for (const auto& [place, motion, accuracy] : input.held_motion) {
    const auto& [x, y, z] = motion.direction();
    const auto times = motion.acceleration()->time();
    text << std::left << std::setw(9) << place_name(place, input.network ? &*input.network : nullptr) << std::right
         << " moves along (" << x << ", " << y << ", " << z << ") from t = " << times.front() << " to " << times.back()
         << " s with at most " << motion.peak() << " m/s^2\n";
  }
  text << "supports  " << sides(input.supports, structure) << contact_text(input) << '\n';
  for (const Striker& striker : input.strikers) {
    text << "striker   " << striker.mass << " kg " << (striker.below ? "below" : "above") << ' '
         << words_of(striker.place);
    if (input.restart.file.empty()) {
      text << ", " << striker.gap << " m away, at " << striker.velocity << " m/s";
    }
    text << '\n';
  }
  for (const NodePair& pair : input.pairs) {
    const auto& [x, y, z] = pair.normal;
    text << "pair      " << words_of(pair.from, true) << " and " << words_of(pair.to, true) << " touch along (" << x
         << ", " << y << ", " << z << "), " << pair.gap << " m apart\n";
  }
  if (const double depth = pressed_at_start(input, structure.points()); depth > 0.0) {
    text << "contact   from the start: " << name_of(structure) << " and springs of supports overlap by " << depth
         << " m\n";
  } else if (const auto first = expected_contact(input, structure)) {
    text << "contact   expected at t = " << *first << " s, from the flight of a rigid "
         << (structure.chain() != nullptr ? "beam" : "body") << '\n';
  }
  const OutputSize size = output_size(input);
  text << "output    " << input.output.directory << ": " << static_cast<long long>(size.rows) << " rows, "
       << static_cast<long long>(size.field_rows) << " of fields, at most " << std::ceil(size.bytes / 1e6)
       << " MB without events, up to t = " << input.end_time << " s\n";
  UDAR_CALL(PetscPrintf(points.comm(), "%s", text.str().c_str()));
}

namespace {

/// At nodes the way of a mass that travels has a kink; where it swings between two of them, each is a jolt.
void warn_of_jolts(const Case& input, MPI_Comm comm) {
  double longest = 0.0;
  for (const BeamSegment& segment : input.beam.segments) {
    longest = std::max(longest, segment.length / static_cast<double>(segment.elements));
  }
  for (const TravellingLoad& load : input.travelling_loads) {
    const double swing = 2.0 * std::numbers::pi * std::abs(load.speed) / input.filter.filter_frequency;
    if (std::ranges::any_of(load.mass, [](double mass) { return mass > 0.0; }) && longest > swing) {
      petsc::warn(comm,
                  "elements of %.3g m are longer than the %.3g m that a mass of -load_axles goes in a period of "
                  "-filter_frequency: its force has a jolt at each node; take more -beam_elements or a lower frequency",
                  longest, swing);
    }
  }
}

}  // namespace

void warn_of_implausible(const Case& input, const Structure& structure) {
  const MassPoints& points = structure.points();
  const MPI_Comm comm = points.comm();
  if (input.gravity < 0.0) {
    petsc::warn(comm,
                "-gravity %g m/s^2 pulls upwards; it is the magnitude of a pull downwards, give it without the minus "
                "if that is meant",
                input.gravity);
  }
  if (input.supports.empty() && !structure.grounded()) {
    petsc::warn(comm, "nothing holds the %s and there is no support to hit; give -support_position or -floor",
                name_of(structure));
  }
  if (const Network* network = structure.network(); network != nullptr) {
    for (const std::string& warning : network->warnings()) {
      petsc::warn(comm, "%s", warning.c_str());
    }
  }
  double highest = 0.0;
  const MassState masses = initial_masses(points, input.initial);
  const Contacts contacts = find_contacts(points, input.supports);
  for (const ContactSet& set : contacts.sets) {
    for (std::size_t node = set.first; node < set.last; ++node) {
      highest = std::max(highest, std::abs(masses.position[node] - set.height(node)));
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, &highest, 1, MPI_DOUBLE, MPI_MAX, comm);
  if (highest > kHighFall) {
    petsc::warn(comm, "the %s starts %g m from a support; lengths are in metres, not millimetres", name_of(structure),
                highest);
  }
  for (const auto& [place, motion, accuracy] : input.held_motion) {
    if (const double start = motion.at(0.0).displacement; start != 0.0 && input.initial.shape.x.empty()) {
      petsc::warn(comm,
                  "%s starts %g m from where it is unstressed, so that the %s is bent from the start; give "
                  "-initial_shape, or a -base_motion that is 0 at t = 0",
                  place_name(place, input.network ? &*input.network : nullptr).c_str(), start, name_of(structure));
    }
  }
  warn_of_jolts(input, comm);
  if (const auto first = expected_contact(input, structure); first && *first > input.end_time) {
    petsc::warn(comm,
                "the first contact is expected at t = %.4g s, after the end of the run at %g s; raise -ts_max_time",
                *first, input.end_time);
  }
}

void warn_of_no_contact(const Case& input, const Structure& structure) {
  const auto first = expected_contact(input, structure);
  if (!input.supports.empty() && !(first && *first > input.end_time)) {
    petsc::warn(structure.points().comm(),
                "nothing touched a support up to t = %g s; see -udar_view for where they are", input.end_time);
  }
}

}  // namespace udar::app
