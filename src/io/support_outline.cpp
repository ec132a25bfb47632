#include "io/support_outline.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "structure/place_algebra.hpp"

namespace udar::io {

std::array<Place, kCorners> outline_of(const RunLayout::Support& support, const Region& around) {
  const std::vector<double>& space = support.space;
  const Place normal{.x = space[0], .y = space[1], .z = space[2]};
  const double half = support.width > 0.0 ? 0.5 * support.width : std::numeric_limits<double>::infinity();
  const Place from{.x = std::max(around.from.x, support.position - half),
                   .y = std::max(around.from.y, space[3]),
                   .z = std::max(around.from.z, space[5])};
  const Place to{.x = std::min(around.to.x, support.position + half),
                 .y = std::min(around.to.y, space[4]),
                 .z = std::min(around.to.z, space[6])};
  const Place middle = 0.5 * (from + to);
  const Place centre = middle + (support.height - dot(normal, middle)) * normal;
  const Place across = cross(normal, std::abs(normal.z) < 0.9 ? Place{.z = 1.0} : Place{.x = 1.0});
  const Place first = (1.0 / norm(across)) * across;
  const Place second = cross(normal, first);
  const auto reach = [&](const Place& axis) {
    return 0.5 * (std::abs(axis.x) * (to.x - from.x) + std::abs(axis.y) * (to.y - from.y) +
                  std::abs(axis.z) * (to.z - from.z));
  };
  const auto corner = [&](double a, double b) {
    return centre + (a * reach(first)) * first + (b * reach(second)) * second;
  };
  return {corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1)};
}

}  // namespace udar::io
