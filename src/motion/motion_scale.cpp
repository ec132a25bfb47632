#include "udar/motion/motion_scale.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <sstream>
#include <utility>
#include <vector>

#include "udar/petsc/error.hpp"
#include "udar/structure/striker.hpp"
#include "udar/structure/time_table.hpp"

namespace udar {
namespace {

constexpr double kRounding = std::numeric_limits<double>::epsilon();

/// What one cause makes of the motion.
struct Cause {
  double length = 0.0;    // [m]
  double velocity = 0.0;  // [m/s]

  void add(double way, double speed) {
    // What is not a number must not pass for small.
    length = way <= length ? length : std::isnan(way) ? std::numeric_limits<double>::infinity() : way;
    velocity = speed <= velocity ? velocity : std::isnan(speed) ? std::numeric_limits<double>::infinity() : speed;
  }
};

/// Way and speed of supports that move up to `end`; what gives way, or holds the line, moves masses no faster than
/// their springs do.
Cause of_supports(const Equations& equations, std::span<const ContactSet> sets, double end) {
  const bool on_line = equations.filtered() && equations.line_contact() != nullptr;
  const double wf = equations.frequency_bound();
  Cause cause;
  for (const ContactSet& set : sets) {
    if (!set.motion) {
      continue;
    }
    std::vector<double> times{0.0, end};  // rows, and the middles of what is between them
    double before = 0.0;
    for (const double row : set.motion->time()) {
      if (row > 0.0 && row < end) {
        times.insert(times.end(), {0.5 * (before + row), row});
        before = row;
      }
    }
    times.push_back(0.5 * (before + end));
    const double start = set.lift(0.0).height;
    for (const double time : times) {
      const SupportMotion::State lift = set.lift(time);
      const double way = std::abs(lift.height - start);
      const bool springs = set.elastic() && !set.contact_law;  // those of a law have no bound
      const double spring = springs ? std::sqrt(set.stiffness + wf * wf) : wf;
      cause.add(way, on_line || springs ? std::min(std::abs(lift.velocity), spring * way) : std::abs(lift.velocity));
    }
  }
  return cause;
}

/// The part of a force that comes so fast within `span` after a time that the masses take it for a blow [N]: what it
/// changes by, and no more than its mean.
double sudden(const TimeTable& table, double time, double span) {
  const double before = time > 0.0 ? table.at(time - kRounding * span).value : 0.0;
  const double change = std::abs(table.at(time + span).value - before);
  double sum = 0.0;
  double from = time;
  double force = std::abs(table.at(time).value);
  const auto add = [&](double until) {
    const double next = std::abs(table.at(until).value);
    sum += 0.5 * (until - from) * (force + next);
    from = until;
    force = next;
  };
  const auto rows = table.time();
  for (auto row = std::ranges::upper_bound(rows, time); row != rows.end() && *row < time + span; ++row) {
    add(*row);
  }
  add(time + span);
  return std::min(change, sum / span);
}

/// How far the line goes under the loads when they are largest, masses where they are, and how fast the masses get
/// by what of them comes within 1 / wf.
Cause of_loads(Equations& equations, double end) {
  const Loads& loads = equations.loads();
  Cause cause;
  if (loads.kinks().empty()) {
    return cause;
  }
  const double wf = equations.frequency_bound();
  std::vector<double> times{0.0};
  for (const double kink : loads.kinks()) {
    if (kink > 0.0 && kink < end) {
      times.push_back(kink);
    }
  }
  times.push_back(end);
  // Where many follow tables of their own, as nodes under a travelling load do, some of the times tell the size.
  constexpr std::size_t kMostLookups = 10'000'000;
  const std::size_t stride = 1 + times.size() * loads.patterns().size() / kMostLookups;
  for (std::size_t k = 0; k < times.size(); k += stride) {
    times[k / stride] = times[k];
  }
  times.resize((times.size() + stride - 1) / stride);
  const auto value_of = [&](const LoadPattern& load, double time, bool blow) {
    return blow ? sudden(*load.table, time, 1.0 / wf) : load.table->at(time).value;
  };
  const std::size_t count = times.size();
  std::vector<double> shares;  // of each pattern: all that follows its table
  for (const LoadPattern& load : loads.patterns()) {
    if (load.cause == LoadCause::held) {  // no force: the line goes no further, and no faster
      shares.push_back(0.0);
      for (const double time : times) {
        const auto [place, speed] = load.table->at(time);
        cause.add(std::abs(place), std::abs(speed));
      }
      continue;
    }
    shares.push_back(std::accumulate(load.share.begin(), load.share.end(), 0.0,
                                     [](double sum, double share) { return sum + std::abs(share); }));
  }
  MPI_Allreduce(MPI_IN_PLACE, shares.data(), static_cast<int>(shares.size()), MPI_DOUBLE, MPI_SUM,
                equations.points().comm());
  std::vector<double> sizes(2 * count, 0.0);  // of all loads together: forces, then blows
  for (std::size_t k = 0; k < sizes.size(); ++k) {
    for (std::size_t i = 0; i < shares.size(); ++i) {
      sizes[k] += shares[i] * std::abs(value_of(loads.patterns()[i], times[k % count], k >= count));
    }
  }
  std::vector<double> stretch(equations.axis().size());
  const std::vector<double> none(stretch.size(), 0.0);
  for (const bool blow : {false, true}) {
    const auto from = sizes.begin() + static_cast<std::ptrdiff_t>(blow ? count : 0);
    const auto largest = std::max_element(from, from + static_cast<std::ptrdiff_t>(count));
    std::vector<double> force(stretch.size(), 0.0);
    for (const LoadPattern& load : loads.patterns()) {
      const double value = value_of(load, times[static_cast<std::size_t>(largest - from)], blow);
      for (std::size_t i = 0; load.cause != LoadCause::held && i < load.point.size(); ++i) {
        force[load.point[i]] += load.share[i] * value;
      }
    }
    if (!std::isfinite(*largest)) {
      cause.add(*largest, 0.0);
      break;
    }
    equations.line().solve(none, force, stretch, {});
    for (const double away : stretch) {
      cause.add(std::abs(away), blow ? wf * std::abs(away) : 0.0);
    }
  }
  return cause;
}

/// How far the line goes under all masses that travel, if they stood in the middle.
Cause of_riders(Equations& equations) {
  Cause cause;
  const MassPoints& points = equations.points();
  if (points.riders().empty()) {
    return cause;
  }
  std::vector<double> force(points.points(), 0.0);
  if (const PetscInt middle = points.nearest({.x = points.extent().middle()}); points.owns(middle)) {
    for (const Rider& rider : points.riders()) {
      force[static_cast<std::size_t>(middle - points.begin())] += rider.mass * equations.loads().gravity();
    }
  }
  std::vector<double> stretch(force.size());
  const std::vector<double> still(force.size(), 0.0);
  equations.line().solve(still, force, stretch, {});
  for (const double away : stretch) {
    cause.add(std::abs(away), 0.0);
  }
  return cause;
}

/// What no beam and no striker does at the start. @param nodes of the structure, without what strikes them
void refuse_absurd(const MassPoints& points, const MassState& nodes, std::span<const double> axis) {
  constexpr double kLengths = 1000.0;  // offsets of linear theory are small against one
  std::array<double, 2> largest{};     // velocity, offset from the axis
  for (std::size_t i = 0; i < nodes.position.size(); ++i) {
    largest[0] = std::max(largest[0], std::abs(nodes.velocity[i]));
    largest[1] = std::max(largest[1], std::abs(nodes.position[i] - axis[i]));
  }
  MPI_Allreduce(MPI_IN_PLACE, largest.data(), 2, MPI_DOUBLE, MPI_MAX, points.comm());
  const double length = points.largest_extent();
  std::ostringstream message;
  const auto refuse_speed = [&](const char* quantity, double speed) {
    if (!(speed < kSpeedOfLight)) {
      message << quantity << ": a mass starts with " << speed << " m/s, expected less than the speed of light, "
              << kSpeedOfLight << " m/s";
      throw InputError{message.str()};
    }
  };
  refuse_speed("initial velocity, initial angular velocity, initial shape", largest[0]);
  for (const Strike& strike : points.strikes()) {
    refuse_speed("striker velocity", std::abs(strike.velocity));
  }
  if (!(largest[1] <= kLengths * length)) {
    message << "initial shape: an offset of " << largest[1] << " is not allowed, expected at most " << kLengths * length
            << " [m], " << kLengths << " lengths of the beam: its theory is one of small slopes";
    throw InputError{message.str()};
  }
}

}  // namespace

MotionScale motion_scale(Equations& equations, const InitialState& initial, std::span<const ContactSet> sets,
                         double end) {
  const MassPoints& points = equations.points();
  const MassState masses = initial_masses(points, initial);
  // What strikes nodes strains nothing, wherever it is.
  const MassState nodes{.position = node_values(points, masses.position),
                        .velocity = node_values(points, masses.velocity)};
  const std::vector<double> axis = node_values(points, equations.axis());
  refuse_absurd(points, nodes, axis);
  const double wf = equations.frequency_bound();
  enum Input : std::size_t { height, shape, speed, supports, weight, motion, load, gap, strikes, inputs };
  std::array<Cause, inputs> causes{};
  double drop = 0.0;  // largest distance from a support [m]
  for (std::size_t i = 0; i < nodes.position.size(); ++i) {
    const double offset = std::abs(nodes.position[i] - axis[i]);
    const double velocity = std::abs(nodes.velocity[i]);
    causes[height].add(std::abs(axis[i]), 0.0);
    causes[shape].add(offset, wf * offset);
    causes[speed].add(velocity / wf, velocity);
  }
  for (const Strike& strike : points.strikes()) {
    causes[gap].add(strike.start, 0.0);
    causes[strikes].add(std::abs(strike.velocity) / wf, std::abs(strike.velocity));
  }
  for (const ContactSet& set : sets) {
    const double lift = set.lift(0.0).height;
    for (std::size_t node = set.first; node < set.last; ++node) {
      causes[supports].add(std::abs(set.height(node)), 0.0);
      drop = std::max(drop, std::abs(masses.position[node] - set.height(node) - lift));
    }
  }
  causes[motion] = of_supports(equations, sets, end);
  causes[load] = of_loads(equations, end);
  const double gravity = std::abs(equations.loads().gravity());
  causes[weight] = of_riders(equations);
  causes[weight].add(gravity / (wf * wf), gravity / wf);
  std::array<double, 2 * inputs + 1> largest{};
  for (std::size_t i = 0; i < inputs; ++i) {
    largest[2 * i] = causes[i].length;
    largest[2 * i + 1] = causes[i].velocity;
  }
  largest.back() = drop;
  MPI_Allreduce(MPI_IN_PLACE, largest.data(), static_cast<int>(largest.size()), MPI_DOUBLE, MPI_MAX, points.comm());

  // Positions are single numbers from y = 0: beyond this the last digit of one hides the shape of the beam.
  constexpr double kShape = 1e-6;  // of its length
  const double furthest = kShape / kRounding * points.largest_extent();
  const auto patterns = equations.loads().patterns();
  const bool base_alone = !patterns.empty() && std::ranges::all_of(patterns, [](const LoadPattern& load) {
    return load.cause != LoadCause::load;
  });
  const std::array<const char*, inputs> causing{"initial height",
                                                "initial shape",
                                                "initial velocity",
                                                "support height",
                                                "gravity",
                                                "support motion",
                                                base_alone ? "base motion" : "load table, load law",
                                                "striker gap, pair gap",
                                                "striker velocity"};
  MotionScale scale{.length = largest.back(), .velocity = std::sqrt(2.0 * gravity * largest.back())};
  for (std::size_t i = 0; i < inputs; ++i) {
    if (!(largest[2 * i] <= furthest)) {
      std::ostringstream message;
      message << causing[i] << ": it takes " << (i == gap || i == strikes ? "what strikes " : "the beam ")
              << largest[2 * i] << " m away, expected at most " << furthest
              << " [m]: further away double precision does not resolve a millionth of the beam's length";
      throw InputError{message.str()};
    }
    const bool place = i == height || i == supports;  // where something is, not how far it moves
    scale.length = std::max(scale.length, place ? 0.0 : largest[2 * i]);
    scale.velocity = std::max(scale.velocity, largest[2 * i + 1]);
  }
  scale.velocity = scale.velocity > 0.0 ? scale.velocity : 1.0;  // nothing moves
  scale.length = std::max(scale.length, scale.velocity / wf);
  return scale;
}

}  // namespace udar
