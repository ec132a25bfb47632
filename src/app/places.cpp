#include "udar/app/places.hpp"

#include <algorithm>
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

std::vector<Placed> placed_at_nodes(const Case& input, const BeamChain& beam) {
  std::vector<Placed> all;
  const auto add = [&](const char* name, std::size_t index, double asked) {
    all.push_back(
        {.name = name + std::to_string(index), .asked = asked, .used = beam.position(beam.nearest_node(asked))});
  };
  for (std::size_t i = 0; i < input.supports.size(); ++i) {
    if (input.supports[i].width == 0.0) {
      add("support ", i, input.supports[i].position);
    }
  }
  for (std::size_t i = 0; i < input.beam.line_supports.size(); ++i) {
    add("line support ", i, input.beam.line_supports[i].position);
  }
  for (std::size_t i = 0; i < input.beam.point_masses.size(); ++i) {
    add("point mass ", i, input.beam.point_masses[i].position);
  }
  for (std::size_t i = 0; i < input.gauges.size(); ++i) {
    add("gauge ", i, input.gauges[i]);
  }
  return all;
}

void warn_of_places(const Case& input, const BeamChain& beam) {
  std::vector<std::string> moved;
  for (const auto& [name, asked, used] : placed_at_nodes(input, beam)) {
    const double allowed = std::min(kShareOfBeam * beam.length(), kShareOfWay * way_to_support(input, asked));
    if (std::abs(used - asked) > allowed) {
      std::ostringstream text;
      text << name << " at x = " << asked << " m is taken to the nearest node, at x = " << used << " m";
      moved.push_back(text.str());
    }
  }
  warn(beam.comm(), moved, "more -beam_elements, or a border of two segments of -beam_length there, put a node there");

  std::vector<std::string> narrow;
  for (std::size_t i = 0; i < input.supports.size(); ++i) {
    const Support& support = input.supports[i];
    const auto [first, last] = touched_nodes(beam, support);
    if (support.width > 0.0 && first == last) {
      std::ostringstream text;
      text << "support " << i << " is " << support.width << " m wide but covers one node, " << first
           << " at x = " << beam.position(first) << " m, of elements of "
           << beam.element(std::min(first, beam.elements() - 1)).length << " m";
      narrow.push_back(text.str());
    }
  }
  warn(beam.comm(), narrow,
       "it is met by one mass, as a support without width is: more -beam_elements spread it over its width");
}

}  // namespace udar::app
