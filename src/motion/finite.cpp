#include "udar/motion/finite.hpp"

#include <algorithm>
#include <bit>
#include <sstream>

#include "udar/petsc/error.hpp"

namespace udar {
namespace {

constexpr std::uint64_t kExponent = 0x7ff0'0000'0000'0000;
constexpr std::uint64_t kOneMore = 0x0010'0000'0000'0000;

/// Its sign bit is that of an exponent of ones alone: infinite, or not a number. No comparison, so that it goes in
/// lanes.
std::uint64_t spoiled(double value) noexcept { return (std::bit_cast<std::uint64_t>(value) & kExponent) + kOneMore; }

}  // namespace

NodeName name_of_node(const Structure& structure, std::size_t point) {
  const MassPoints& points = structure.points();
  const Topology topology = structure.topology();
  const std::size_t own = points.own_point(point);
  return {.node = topology.node.empty() ? points.number(own) : topology.node_number[topology.node[own]],
          .x = points.place(point).x};
}

std::size_t first_not_finite(std::span<const double> values) noexcept {
  std::uint64_t any = 0;
  for (const double value : values) {
    any |= spoiled(value);
  }
  const auto is_spoiled = [](double value) { return spoiled(value) >> 63U != 0; };
  return any >> 63U == 0 ? values.size()
                         : static_cast<std::size_t>(std::ranges::find_if(values, is_spoiled) - values.begin());
}

void require_finite(const Equations& equations, std::span<const double> position, std::span<const double> velocity,
                    double since) {
  const MassPoints& points = equations.points();
  const std::size_t first = std::min(first_not_finite(position), first_not_finite(velocity));
  std::string failure;
  if (first < position.size()) {
    const auto [node, x] = name_of_node(equations.line().structure(), first % points.points());
    int rank = 0;
    MPI_Comm_rank(points.comm(), &rank);
    std::ostringstream text;
    text << "the motion is no longer finite after t = " << since << " s at node " << node << ", x = " << x
         << " m, on rank " << rank
         << "; a load or the line solve is not finite, or the steps are too long for `filter frequency` (see -ts_dt, "
            "-ts_adapt_type)";
    failure = text.str();
  }
  throw_together<SolveError>(points.comm(), failure);
}

}  // namespace udar
