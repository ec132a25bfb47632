#include "udar/structure/initial_state.hpp"

#include <string>

#include "udar/numerics/polyline.hpp"
#include "udar/petsc/error.hpp"

namespace udar {

std::vector<double> reference_axis(const MassPoints& points, const InitialState& initial) {
  const Extent extent = points.extent();
  std::vector<double> axis;
  axis.reserve(points.points());
  for (std::size_t point = 0; point < points.points(); ++point) {
    const Place place = points.place(point);
    axis.push_back(points.direction(point) == Direction::y ? place.y + initial.axis(place.x, extent) : 0.0);
  }
  return axis;
}

MassState initial_masses(const MassPoints& points, const InitialState& initial) {
  MassState masses{.position = reference_axis(points, initial), .velocity = {}};
  const double middle = points.extent().middle();
  masses.velocity.reserve(points.points());
  for (std::size_t point = 0; point < points.points(); ++point) {
    const auto [x, y, z] = points.place(point);
    const bool fixed = points.fixed(point);
    if (points.direction(point) != Direction::y) {
      const bool turns = points.direction(point) == Direction::x && !fixed;
      masses.velocity.push_back(turns ? -initial.angular_velocity * y : 0.0);
      continue;
    }
    masses.position[point] += fixed ? 0.0 : interpolate(initial.shape.x, initial.shape.offset, x);
    masses.velocity.push_back(fixed ? 0.0
                                    : initial.velocity + initial.angular_velocity * (x - middle) +
                                          interpolate(initial.shape.x, initial.shape.velocity, x));
  }
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
