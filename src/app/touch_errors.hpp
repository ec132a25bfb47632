#pragma once
/// @file
/// How far off masses that touch supports are from where these are what was settled at the start.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "udar/app/case.hpp"
#include "udar/contact/support.hpp"
#include "udar/io/peaks.hpp"
#include "udar/motion/motion_state.hpp"
#include "udar/motion/observer.hpp"
#include "udar/structure/mass_points.hpp"

namespace udar::app {

/// @brief Looks at every row at the masses that touch some of the supports: their errors, and the largest so far.
class TouchErrors : public Observer {
 public:
  [[nodiscard]] double interval() const override { return interval_; }
  void snapshot(const Snapshot& state) override;
  void events(const StepRecords<ImpactRecord>& impacts, const StepRecords<RestRecord>& rests,
              const EventCounts& all) override;
  void save(MotionState& state) const override;
  void restore(const MotionState& state) override;

  /// @brief The worst so far.
  struct Worst {
    io::Peak peak{};          ///< of a mass that touched; infinite: nothing is there [m]
    Place place{};            ///< where that mass started, without height and shape [m]
    std::int64_t masses = 0;  ///< that were off by more than is tolerated
  };
  /// @param tolerance [m] @note Collective.
  [[nodiscard]] Worst worst(double tolerance) const;

 protected:
  /// @param points must outlive this object @param name of what is saved @param looked_at which supports matter
  /// @note Collective.
  TouchErrors(const MassPoints& points, const Case& input, std::string name,
              const std::function<bool(const Support&)>& looked_at);

  [[nodiscard]] const MassPoints& points() const noexcept { return *points_; }
  /// How far the node of a point is from where it stands [m].
  [[nodiscard]] Place way_of(std::size_t point, std::span<const double> position) const;

 private:
  /// A mass, and the support that it faces.
  struct Faced {
    std::size_t point = 0;
    std::size_t set = 0;
  };
  /// Of a mass that touches [m].
  [[nodiscard]] virtual double error_of(std::size_t point, const Support& support,
                                        std::span<const double> position) const = 0;
  /// From how far away a mass touches, by its error [m].
  [[nodiscard]] virtual double reach(double /*error*/) const { return 0.0; }

  const MassPoints* points_;
  std::string name_;
  double interval_;
  Contacts contacts_;
  std::vector<Faced> faced_;
  std::vector<std::uint8_t> hit_;  // of each local point, since the last row
  std::vector<double> error_;      // of each local point, the largest so far [m]
  std::vector<double> time_;       // when that was [s]
};

}  // namespace udar::app
