#pragma once
/// @file
/// How far the planes that masses face are off the height fields that they stand for.

#include <cstddef>
#include <span>

#include "app/touch_errors.hpp"

namespace udar::app {

/// @brief Looks at every row whether masses that touch a height field are still where its plane below their start is
/// good. A plane and its field part with the square of the way across.
class FieldErrors final : public TouchErrors {
 public:
  /// @param points must outlive this object @note Collective.
  FieldErrors(const MassPoints& points, const Case& input);

 private:
  /// Of the plane beside the field above or below where the mass is, along the normal; infinite beside the field [m].
  [[nodiscard]] double error_of(std::size_t point, const Support& support,
                                std::span<const double> position) const override;
  /// The plane, or the field itself, is no further away than they are apart.
  [[nodiscard]] double reach(double error) const override;
};

/// @brief Says so if a plane was off by more than is tolerated. @param tolerance [m] @note Collective.
void warn_of_field(const MassPoints& points, const FieldErrors& errors, double tolerance);

}  // namespace udar::app
