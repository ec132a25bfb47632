#include "udar/app/places.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <sstream>

#include "udar/contact/support.hpp"
#include "udar/petsc/warnings.hpp"

namespace udar::app {
namespace {

constexpr double kShareOfBeam = 0.02;
constexpr double kShareOfWay = 0.1;
constexpr std::size_t kMostShown = 3;  // of warnings that say the same

/// One line for the first of them and how many there are.
void warn(MPI_Comm comm, const std::vector<std::string>& all, const char* advice) {
  if (all.empty()) {
    return;
  }
  std::string text;
  for (std::size_t i = 0; i < std::min(all.size(), kMostShown); ++i) {
    text += (i > 0 ? ", " : "") + all[i];
  }
  if (all.size() > kMostShown) {
    text += " and " + std::to_string(all.size() - kMostShown) + " more";
  }
  petsc::warn(comm, "%s; %s", text.c_str(), advice);
}

/// From a place to the nearest support elsewhere [m].
double way_to_support(const Case& input, double x) {
  double way = std::numeric_limits<double>::infinity();
  const auto consider = [&](double other) { way = other != x ? std::min(way, std::abs(other - x)) : way; };
  for (const Support& support : input.supports) {
    if (std::isfinite(support.width)) {
      consider(support.position);
    }
  }
  for (const LineSupport& support : input.beam.line_supports) {
    consider(support.position);
  }
  return way;
}

/// Where points of one x are. @note Collective.
double x_of(const MassPoints& points, const PointRows& rows) {
  double x = -std::numeric_limits<double>::infinity();
  for (const PointRows::Row& row : rows.rows) {
    x = std::max(x, points.place(row.first).x);
  }
  MPI_Allreduce(MPI_IN_PLACE, &x, 1, MPI_DOUBLE, MPI_MAX, points.comm());
  return x;
}

}  // namespace

double Placed::away() const {
  const Place way{.x = used.x - asked.x, .y = used.y - asked.y, .z = used.z - asked.z};
  return in_space ? std::hypot(way.x, way.y, way.z) : std::abs(way.x);
}

std::string words_of(const Place& place) { return words_of(place, place.y != 0.0 || place.z != 0.0); }

std::string words_of(const Place& place, bool in_space) {
  std::ostringstream text;
  if (in_space) {
    text << '(' << place.x << ", " << place.y << ", " << place.z << ") m";
  } else {
    text << "x = " << place.x << " m";
  }
  return text.str();
}

Place place_of(const MassPoints& points, PetscInt global) {
  std::array<double, 3> place{};
  if (points.owns(global)) {
    const auto [x, y, z] = points.place(static_cast<std::size_t>(global - points.begin()));
    place = {x, y, z};
  }
  MPI_Allreduce(MPI_IN_PLACE, place.data(), 3, MPI_DOUBLE, MPI_SUM, points.comm());
  return {.x = place[0], .y = place[1], .z = place[2]};
}

std::vector<Placed> placed_at_nodes(const Case& input, const MassPoints& points) {
  std::vector<Placed> all;
  const auto add = [&](const char* name, std::size_t index, const Place& asked) {
    const PetscInt point = points.nearest(asked);
    all.push_back({.name = name + std::to_string(index),
                   .asked = asked,
                   .used = place_of(points, point),
                   .in_space = input.network || asked.y != 0.0 || asked.z != 0.0,
                   .point = point});
  };
  for (std::size_t i = 0; i < input.supports.size(); ++i) {
    const Support& support = input.supports[i];
    if (const auto striker = input.striker_of(support)) {
      add("striker ", *striker, input.strikers[*striker].place);
    } else if (const auto pair = input.pair_of(support)) {
      add("first node of pair ", *pair, input.pairs[*pair].from);
      add("second node of pair ", *pair, input.pairs[*pair].to);
    } else if (support.width == 0.0) {
      all.push_back({.name = "support " + std::to_string(i),
                     .asked = {.x = support.position},
                     .used = {.x = x_of(points, touched_points(points, support))}});
    }
  }
  for (std::size_t i = 0; i < input.beam.line_supports.size(); ++i) {
    add("line support ", i, {.x = input.beam.line_supports[i].position});
  }
  for (std::size_t i = 0; i < input.beam.point_masses.size(); ++i) {
    add("point mass ", i, {.x = input.beam.point_masses[i].position});
  }
  for (std::size_t i = 0; i < input.gauges.size(); ++i) {
    add("gauge ", i, input.gauges[i]);
  }
  for (std::size_t i = 0; i < input.loads.size() && (input.network || input.imported); ++i) {
    add("load ", i, input.loads[i].place());
  }
  return all;
}

void warn_of_places(const Case& input, const Structure& structure) {
  const MassPoints& points = structure.points();
  const BeamChain* beam = structure.chain();
  std::vector<std::string> moved;
  for (const Placed& placed : placed_at_nodes(input, points)) {
    const double allowed = placed.in_space ? kShareOfBeam * points.largest_extent()
                                           : std::min(kShareOfBeam * points.extent().length(),
                                                      kShareOfWay * way_to_support(input, placed.asked.x));
    if (placed.away() > allowed) {
      moved.push_back(placed.name + " at " + words_of(placed.asked, placed.in_space) +
                      " is taken to the nearest node, at " + words_of(placed.used, placed.in_space));
    }
  }
  warn(points.comm(), moved,
       beam != nullptr ? "more -beam_elements, or a border of two segments of -beam_length there, put a node there"
                       : "a finer mesh has one there");

  std::vector<std::string> narrow;
  for (std::size_t i = 0; i < input.supports.size(); ++i) {
    const Support& support = input.supports[i];
    if (support.width == 0.0 || std::isinf(support.width)) {
      continue;
    }
    if (const PointRows touched = touched_points(points, support); touched.count == 1) {
      const double x = x_of(points, touched);
      std::ostringstream text;
      text << "support " << i << " is " << support.width << " m wide but covers one node, ";
      if (beam != nullptr) {
        const PetscInt node = beam->nearest_node(x);
        text << node << " at x = " << x << " m, of elements of "
             << beam->element(std::min(node, beam->elements() - 1)).length << " m";
      } else {
        text << "at x = " << x << " m";
      }
      narrow.push_back(text.str());
    }
  }
  warn(points.comm(), narrow,
       beam != nullptr
           ? "it is met by one mass, as a support without width is: more -beam_elements spread it over its width"
           : "it is met by one mass");
}

}  // namespace udar::app
