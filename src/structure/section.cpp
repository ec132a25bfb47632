#include "udar/structure/section.hpp"

#include <numbers>

namespace udar {

Section circle_section(double radius, double poisson_ratio) {
  const double area = std::numbers::pi * radius * radius;
  return {.area = area,
          .inertia = area * radius * radius / 4.0,
          .shear_coefficient = 6.0 * (1.0 + poisson_ratio) / (7.0 + 6.0 * poisson_ratio),
          .outer_fibre = radius};
}

Section tube_section(double outer_radius, double inner_radius, double poisson_ratio) {
  const double outer = outer_radius * outer_radius;
  const double inner = inner_radius * inner_radius;
  const double ratio = inner / outer;
  const double sum = (1.0 + ratio) * (1.0 + ratio);
  return {.area = std::numbers::pi * (outer - inner),
          .inertia = std::numbers::pi * (outer * outer - inner * inner) / 4.0,
          .shear_coefficient = 6.0 * (1.0 + poisson_ratio) * sum /
                               ((7.0 + 6.0 * poisson_ratio) * sum + (20.0 + 12.0 * poisson_ratio) * ratio),
          .outer_fibre = outer_radius};
}

Section rectangle_section(double width, double height, double poisson_ratio) {
  return {.area = width * height,
          .inertia = width * height * height * height / 12.0,
          .shear_coefficient = 10.0 * (1.0 + poisson_ratio) / (12.0 + 11.0 * poisson_ratio),
          .outer_fibre = height / 2.0};
}

}  // namespace udar
