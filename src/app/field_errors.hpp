#pragma once
/// @file
/// How far the planes that masses face are off the height fields that they stand for.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "udar/app/case.hpp"
#include "udar/contact/support.hpp"
#include "udar/io/peaks.hpp"
#include "udar/motion/motion_state.hpp"
#include "udar/motion/observer.hpp"
#include "udar/structure/mass_points.hpp"

namespace udar::app {

/// @brief Looks at every row whether masses that touch a height field are still where its plane below their start is
/// good. A plane and its field part with the square of the way across.
class FieldErrors final : public Observer {
 public:
  /// @param points must outlive this object @note Collective.
  FieldErrors(const MassPoints& points, const Case& input);

  [[nodiscard]] double interval() const override { return interval_; }
  void snapshot(const Snapshot& state) override;
  void events(std::span<const ImpactRecord> impacts, std::span<const RestRecord> rests,
              const EventCounts& all) override;
  void save(MotionState& state) const override;
  void restore(const MotionState& state) override;

  /// @brief The worst so far.
  struct Worst {
    io::Peak peak{};          ///< of a mass that touched; infinite: beside the field [m]
    Place place{};            ///< where that mass started, without height and shape [m]
    std::int64_t masses = 0;  ///< that were off by more than is tolerated
  };
  /// @param tolerance [m] @note Collective.
  [[nodiscard]] Worst worst(double tolerance) const;

 private:
  /// A mass, and the plane that it faces.
  struct Faced {
    std::size_t point = 0;
    std::size_t set = 0;
    HeightGrid::Surface plane{};
  };
  [[nodiscard]] double error_of(const Faced& faced, std::span<const double> position) const;

  const MassPoints* points_;
  double interval_;
  Contacts contacts_;
  std::vector<Faced> faced_;
  std::vector<std::uint8_t> hit_;  // of each local point, since the last row
  std::vector<double> error_;      // of each local point, the largest so far [m]
  std::vector<double> time_;       // when that was [s]
};

/// @brief Says so if a plane was off by more than is tolerated. @param tolerance [m] @note Collective.
void warn_of_field(const MassPoints& points, const FieldErrors& errors, double tolerance);

}  // namespace udar::app
