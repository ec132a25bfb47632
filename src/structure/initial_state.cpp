#include "udar/structure/initial_state.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>
#include <string>

#include "structure/place_algebra.hpp"
#include "udar/numerics/polyline.hpp"
#include "udar/petsc/error.hpp"
#include "udar/structure/striker.hpp"

namespace udar {

namespace {

/// Of all that moves along y. @param points of nodes @note Collective.
Place centre_of_mass(const MassPoints& points) {
  std::array<double, 4> sums{};
  for (std::size_t point = 0; point < points.points(); ++point) {
    if (points.direction(point) == Direction::y) {
      const double mass = points.mass()[point];
      const auto [x, y, z] = points.place(point);
      sums[0] += mass;
      sums[1] += mass * x;
      sums[2] += mass * y;
      sums[3] += mass * z;
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), 4, MPI_DOUBLE, MPI_SUM, points.comm());
  return {.x = sums[1] / sums[0], .y = sums[2] / sums[0], .z = sums[3] / sums[0]};
}

/// Velocities of a body that does not strain.
class RigidMotion {
 public:
  /// @note Collective with a spin and no pivot.
  RigidMotion(const MassPoints& points, const InitialState& initial)
      : initial_{&initial},
        pivot_{initial.pivot.value_or(Place{.x = points.extent().middle()})},
        centre_{initial.pivot     ? *initial.pivot
                : initial.spins() ? centre_of_mass(points.nodes())
                                  : Place{}} {}

  [[nodiscard]] Place at(const Place& place) const {
    const double turning = initial_->angular_velocity;
    Place velocity{.x = initial_->velocity_x - turning * (place.y - pivot_.y),
                   .y = initial_->velocity + turning * (place.x - pivot_.x),
                   .z = initial_->velocity_z};
    if (initial_->spins()) {
      velocity = velocity + cross(initial_->spin, place - centre_);
    }
    return velocity;
  }
  [[nodiscard]] Place turning() const { return initial_->spin + initial_->angular_velocity * Place{.z = 1.0}; }

 private:
  const InitialState* initial_;
  Place pivot_;
  Place centre_;
};

/// @param points of nodes
std::vector<double> node_axis(const MassPoints& points, const InitialState& initial) {
  const Extent extent = points.extent();
  std::vector<double> axis;
  axis.reserve(points.points());
  for (std::size_t point = 0; point < points.points(); ++point) {
    const Place place = points.place(point);
    const double up = points.axis(point).y;
    axis.push_back(up == 0.0 ? 0.0 : up * (place.y + initial.axis(place.x, extent)));
  }
  return axis;
}

/// Masses that travel, on the line of the masses or on the road. @param nodes of these @note Collective.
void place_riders(const MassPoints& points, const InitialState& initial, const MassState& nodes, MassState& masses) {
  const std::span<const Rider> riders = points.riders();
  if (riders.empty()) {
    return;
  }
  const auto first = static_cast<std::size_t>(points.nodes().begin());
  std::vector<double> sums(2 * riders.size(), 0.0);  // heights, velocities
  for (std::size_t i = 0; i < riders.size(); ++i) {
    const Passage::State at = riders[i].passage.at(0.0);
    const std::array<double, 2> shares{1.0 - at.ahead, at.ahead};
    const std::array<double, 2> rates{-at.rate, at.rate};
    for (std::size_t k = 0; k < 2 && at.where == Passage::Where::on; ++k) {
      if (const std::size_t node = at.node + k; node >= first && node - first < nodes.position.size()) {
        sums[2 * i] += shares.at(k) * nodes.position[node - first];
        sums[2 * i + 1] += shares.at(k) * nodes.velocity[node - first] + rates.at(k) * nodes.position[node - first];
      }
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM, points.comm());
  for (std::size_t i = 0; i < riders.size(); ++i) {
    if (points.owns(riders[i].point)) {
      const auto point = static_cast<std::size_t>(riders[i].point - points.begin());
      const Passage::Where where = riders[i].passage.at(0.0).where;
      masses.position[point] =
          where == Passage::Where::on ? sums[2 * i] : initial.axis(riders[i].passage.end(where), points.extent());
      masses.velocity[point] = sums[2 * i + 1];
    }
  }
}

}  // namespace

std::vector<double> reference_axis(const MassPoints& points, const InitialState& initial) {
  std::vector<double> axis = node_axis(points.nodes(), initial);
  axis.resize(points.points());  // gaps to strikers strain nothing, nor do masses that travel
  nodes_to_centres(points, axis);
  return axis;
}

MassState initial_masses(const MassPoints& points, const InitialState& initial) {
  const MassPoints& nodes = points.nodes();
  MassState masses{.position = node_axis(nodes, initial), .velocity = std::vector<double>(nodes.points())};
  const RigidMotion motion{points, initial};
  for (std::size_t point = 0; point < nodes.points(); ++point) {
    if (nodes.fixed(point)) {
      continue;
    }
    const Place at = nodes.place(point);
    const Place along = nodes.axis(point);
    masses.position[point] += along.y * interpolate(initial.shape.x, initial.shape.offset, at.x);
    Place velocity = motion.at(at);
    velocity.y += interpolate(initial.shape.x, initial.shape.velocity, at.x);
    for (const InitialState::Part& part : initial.parts) {
      velocity = part.region.holds(at) ? velocity + part.velocity : velocity;
    }
    masses.velocity[point] =
        nodes.direction(point) == Direction::other ? dot(nodes.turning(point), motion.turning()) : dot(along, velocity);
  }
  for (const auto& [point, displacement, velocity] : initial.held) {
    masses.position[point] += displacement;
    masses.velocity[point] += velocity;
  }
  const MassState of_nodes = points.riders().empty() ? MassState{} : masses;
  masses.position.resize(points.points());
  masses.velocity.resize(points.points());
  place_riders(points, initial, of_nodes, masses);
  each_own(points, [&](const Strike& strike, std::size_t both, std::size_t gap) {
    if (!strike.of_nodes()) {
      masses.position[gap] = strike.start;
      masses.velocity[gap] = strike.gap_of(masses.velocity[both], strike.velocity);
    }
  });
  nodes_to_centres(points, masses.position);
  nodes_to_centres(points, masses.velocity);
  return masses;
}

void refuse_shape(const MassPoints& points, const InitialState& initial) {
  std::string fault;
  for (std::size_t point = 0; point < points.points() && !initial.shape.x.empty(); ++point) {
    if (points.direction(point) != Direction::y) {
      fault = "initial shape: not allowed where unknowns move along x or z, expected none: it gives heights alone";
    }
  }
  throw_together<InputError>(points.comm(), fault);
}

void refuse_torn(const MassPoints& points, const InitialState& initial) {
  if (!initial.pivot) {
    return;
  }
  constexpr double kStill = 1e-9;  // of the speed at the largest distance: places typed with ten digits
  const RigidMotion motion{points, initial};
  const double fastest = norm(motion.turning()) * points.largest_extent();
  double torn = 0.0;
  for (std::size_t point = 0; point < points.points(); ++point) {
    if (points.fixed(point) && points.direction(point) != Direction::other) {
      torn = std::max(torn, std::abs(dot(points.axis(point), motion.at(points.place(point)))));
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, &torn, 1, MPI_DOUBLE, MPI_MAX, points.comm());
  if (torn > kStill * fastest) {
    std::ostringstream message;
    message << "initial pivot: a place that is held would start with " << torn
            << " m/s, expected a pivot about which nothing that is held moves [m]";
    throw InputError{message.str()};
  }
}

}  // namespace udar
