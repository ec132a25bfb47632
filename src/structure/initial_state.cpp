#include "udar/structure/initial_state.hpp"

#include "udar/numerics/polyline.hpp"

namespace udar {

std::vector<double> reference_axis(const MassPoints& points, const InitialState& initial) {
  const Extent extent = points.extent();
  std::vector<double> axis;
  axis.reserve(points.points());
  for (std::size_t point = 0; point < points.points(); ++point) {
    const Place place = points.place(point);
    axis.push_back(place.y + initial.axis(place.x, extent));
  }
  return axis;
}

MassState initial_masses(const MassPoints& points, const InitialState& initial) {
  MassState masses{.position = reference_axis(points, initial), .velocity = {}};
  const double middle = points.extent().middle();
  masses.velocity.reserve(points.points());
  for (std::size_t point = 0; point < points.points(); ++point) {
    const double x = points.place(point).x;
    const bool fixed = points.fixed(point);
    masses.position[point] += fixed ? 0.0 : interpolate(initial.shape.x, initial.shape.offset, x);
    masses.velocity.push_back(fixed ? 0.0
                                    : initial.velocity + initial.angular_velocity * (x - middle) +
                                          interpolate(initial.shape.x, initial.shape.velocity, x));
  }
  return masses;
}

}  // namespace udar
