#pragma once
/// @file
/// When each support was touched.

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "udar/app/case.hpp"
#include "udar/motion/observer.hpp"
#include "udar/structure/mass_points.hpp"

namespace udar::app {

/// @brief Keeps of each support when it was first and last touched: by impacts and rests to their time, by forces to a
/// row of the output.
class SupportContacts final : public Observer {
 public:
  /// @brief [s]; empty: never.
  struct Times {
    std::optional<double> first;
    std::optional<double> last;
  };

  /// @param points must outlive this object
  SupportContacts(const Case& input, const MassPoints& points);

  [[nodiscard]] double interval() const override { return interval_; }
  void snapshot(const Snapshot& state) override;
  void events(const StepRecords<ImpactRecord>& impacts, const StepRecords<RestRecord>& rests,
              const EventCounts& all) override;
  void save(MotionState& state) const override;
  void restore(const MotionState& state) override;

  /// Of each support. @note Collective.
  [[nodiscard]] std::vector<Times> times() const;

 private:
  void note(std::size_t support, double first, double last);
  [[nodiscard]] std::vector<double> of_all_ranks() const;

  MPI_Comm comm_;
  double interval_;
  std::vector<double> ends_;     // of each support minus the first time, then the last; of this rank's events
  std::vector<double> impulse_;  // of each support at the last row [N s]
  double row_ = 0.0;             // its time [s]
};

}  // namespace udar::app
