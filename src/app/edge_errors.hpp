#pragma once
/// @file
/// How far masses that touch a pad or a box are beyond its edges.

#include <cstddef>
#include <span>

#include "app/touch_errors.hpp"

namespace udar::app {

/// @brief Looks at every row whether masses that touch a support with edges are still over it: who faces what is
/// settled by where the network stands at the start.
class EdgeErrors final : public TouchErrors {
 public:
  /// @param points must outlive this object @note Collective.
  EdgeErrors(const MassPoints& points, const Case& input);

  /// Whether some support has edges that masses can leave.
  [[nodiscard]] static bool needed(const Case& input);

 private:
  [[nodiscard]] double error_of(std::size_t point, const Support& support,
                                std::span<const double> position) const override;
};

/// @brief Says so if a mass was beyond an edge by more than is tolerated. @param tolerance [m] @note Collective.
void warn_of_edges(const MassPoints& points, const EdgeErrors& errors, double tolerance);

}  // namespace udar::app
