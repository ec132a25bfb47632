#include "structure/beam_nodes.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <numeric>
#include <string>

#include "udar/petsc/error.hpp"

namespace udar {
namespace {

/// Of nodes; what strikes one takes part in its height. @note Collective.
std::ptrdiff_t nodes_at(const MassPoints& points, const Place& place) {
  return std::ranges::count_if(points.lever(place), [&](const PointShare& share) {
    return std::ranges::find(points.strikes(), share.point, &Strike::gap) == points.strikes().end();
  });
}

}  // namespace

std::vector<double> beam_nodes(const MassPoints& points, const char* quantity) {
  std::vector<double> own;
  own.reserve(points.own_points());
  for (std::size_t point = 0; point < points.own_points(); ++point) {
    own.push_back(points.direction(point) == Direction::y ? points.place(point).x
                                                          : std::numeric_limits<double>::quiet_NaN());
  }
  int ranks = 1;
  MPI_Comm_size(points.comm(), &ranks);
  std::vector<int> counts(static_cast<std::size_t>(ranks));
  std::vector<int> begins(counts.size());
  const auto count = static_cast<int>(own.size());
  MPI_Allgather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, points.comm());
  std::exclusive_scan(counts.begin(), counts.end(), begins.begin(), 0);
  std::vector<double> all(static_cast<std::size_t>(begins.back() + counts.back()));
  MPI_Allgatherv(own.data(), count, MPI_DOUBLE, all.data(), counts.data(), begins.data(), MPI_DOUBLE, points.comm());
  for (std::size_t node = 0; node + 1 < all.size(); ++node) {
    const double middle = 0.5 * (all[node] + all[node + 1]);
    if (!(all[node] < all[node + 1]) || nodes_at(points, {.x = middle}) < 2) {
      throw InputError{std::string{quantity} + ": not allowed but on one straight beam without gaps, expected none"};
    }
  }
  return all;
}

}  // namespace udar
