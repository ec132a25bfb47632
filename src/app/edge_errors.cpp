#include "app/edge_errors.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "udar/petsc/warnings.hpp"

namespace udar::app {
namespace {

constexpr std::array kWays{&Place::x, &Place::y, &Place::z};

/// Where a support has edges; along the axis of its normal it has none, nor along x without a width.
Region edges_of(const Support& support) {
  Region edges = support.region();
  for (double Place::* const axis : kWays) {
    if (support.normal.*axis == 1.0 || (axis == &Place::x && support.width == 0.0)) {
      edges.from.*axis = -Region::kEnd;
      edges.to.*axis = Region::kEnd;
    }
  }
  return edges;
}

bool has_edges(const Support& support) {
  const Region edges = edges_of(support);
  return support.strike < 0 &&
         std::ranges::any_of(
             kWays,
             [&](double Place::* axis) { return std::isfinite(edges.from.*axis) || std::isfinite(edges.to.*axis); });
}

}  // namespace

EdgeErrors::EdgeErrors(const MassPoints& points, const Case& input)
    : TouchErrors{points, input, "support_edge_error", has_edges} {}

bool EdgeErrors::needed(const Case& input) {
  return input.network.has_value() && std::ranges::any_of(input.supports, has_edges);
}

/// How far beyond the edge that it has left furthest behind; 0: over the support [m].
double EdgeErrors::error_of(std::size_t point, const Support& support, std::span<const double> position) const {
  const Region edges = edges_of(support);
  const Place place = points().place(point);
  const Place way = way_of(point, position);
  double beyond = 0.0;
  for (double Place::* const axis : kWays) {
    const double at = place.*axis + way.*axis;
    beyond = std::max({beyond, edges.from.*axis - at, at - edges.to.*axis});
  }
  return beyond;
}

void warn_of_edges(const MassPoints& points, const EdgeErrors& errors, double tolerance) {
  const auto [peak, place, masses] = errors.worst(tolerance);
  if (masses > 0) {
    petsc::warn(points.comm(),
                "%lld masses touched a support from beyond its edges by more than %.3g m: most the one from (%g, %g, "
                "%g) m, by %g m at t = %g s; who faces which pad or box is settled by where the network stands without "
                "its initial height and does not change, do not trust what follows",
                static_cast<long long>(masses), tolerance, place.x, place.y, place.z, peak.value, peak.time);
  }
}

}  // namespace udar::app
