#include "app/field_errors.hpp"

#include <cmath>
#include <limits>
#include <sstream>

#include "udar/petsc/warnings.hpp"

namespace udar::app {

FieldErrors::FieldErrors(const MassPoints& points, const Case& input)
    : TouchErrors{points, input, "height_field_error",
                  [](const Support& support) { return support.field != nullptr; }} {}

double FieldErrors::error_of(std::size_t point, const Support& support, std::span<const double> position) const {
  const HeightGrid& field = *support.field;
  const Place place = points().place(point);
  const auto [x, y, z] = way_of(point, position);
  const auto [height, along_x, along_z] = field.at(place.x, place.z).value();
  const auto now = field.at(place.x + x, place.z + z);
  return now ? points().axis(point).y * std::abs(now->height - height - along_x * x - along_z * z)
             : std::numeric_limits<double>::infinity();
}

double FieldErrors::reach(double error) const { return std::isfinite(error) ? error : 0.0; }

void warn_of_field(const MassPoints& points, const FieldErrors& errors, double tolerance) {
  const auto [peak, place, masses] = errors.worst(tolerance);
  if (masses > 0) {
    std::ostringstream off;
    if (std::isfinite(peak.value)) {
      off << "by " << peak.value << " m";
    } else {
      off << "who has left the field,";
    }
    petsc::warn(
        points.comm(),
        "planes of a height field were off by more than %.3g m (-support_field_tolerance) under %lld masses that "
        "touched it: most under the one from (%g, %g, %g) m, %s at t = %g s; each keeps the plane of its start, "
        "do not trust what follows",
        tolerance, static_cast<long long>(masses), place.x, place.y, place.z, off.str().c_str(), peak.time);
  }
}

}  // namespace udar::app
