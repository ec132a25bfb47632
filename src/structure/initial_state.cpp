#include "udar/structure/initial_state.hpp"

#include <array>
#include <string>

#include "structure/place_algebra.hpp"
#include "udar/numerics/polyline.hpp"
#include "udar/petsc/error.hpp"

namespace udar {

namespace {

/// Of all that moves along y. @note Collective.
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

}  // namespace

std::vector<double> reference_axis(const MassPoints& points, const InitialState& initial) {
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

MassState initial_masses(const MassPoints& points, const InitialState& initial) {
  MassState masses{.position = reference_axis(points, initial), .velocity = std::vector<double>(points.points())};
  const double middle = points.extent().middle();
  const Place centre = initial.spins() ? centre_of_mass(points) : Place{};
  for (std::size_t point = 0; point < points.points(); ++point) {
    if (points.fixed(point)) {
      continue;
    }
    const Place at = points.place(point);
    const Place along = points.axis(point);
    masses.position[point] += along.y * interpolate(initial.shape.x, initial.shape.offset, at.x);
    Place velocity{.x = initial.velocity_x - initial.angular_velocity * at.y,
                   .y = initial.velocity + initial.angular_velocity * (at.x - middle) +
                        interpolate(initial.shape.x, initial.shape.velocity, at.x),
                   .z = initial.velocity_z};
    if (initial.spins()) {
      velocity = velocity + cross(initial.spin, at - centre);
    }
    masses.velocity[point] = points.direction(point) == Direction::other
                                 ? dot(points.turning(point), initial.spin + initial.angular_velocity * Place{.z = 1.0})
                                 : dot(along, velocity);
  }
  each_own(points, [&](const Strike& strike, std::size_t both, std::size_t gap) {
    const double speed = strike.side * (strike.velocity - masses.velocity[both]);  // of the gap
    masses.position[both] += strike.share * strike.side * strike.start;
    masses.velocity[both] += strike.share * strike.side * speed;
    masses.position[gap] = strike.start;
    masses.velocity[gap] = speed;
  });
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

}  // namespace udar
