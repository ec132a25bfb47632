#pragma once
/// @file
/// What the files of a run hold, in memory: for programs that go on with it at once.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "udar/io/layout.hpp"
#include "udar/io/support_forces.hpp"
#include "udar/motion/observer.hpp"

namespace udar::io {

class GaugeRows;
class ContactRows;
struct ContactRow;

/// @brief A table with the columns of a file, row behind row.
struct RecordedTable {
  std::vector<std::string> columns;
  std::vector<double> numbers;
};

/// @brief Keeps rows of gauges, strikers, energy and supports, fields where they are asked for, and all events: the
/// numbers of gauges.csv, strikers.csv, energy.csv, contact.csv, impacts.csv and rests.csv to the bit.
/// @note Its memory grows with the run: 8 bytes a number, 64 an event; of fields those of this rank's nodes a row.
class Recording final : public Observer {
 public:
  /// @param layout     borrows its points, which must outlive this object
  /// @param interval   between rows [s], above 0
  /// @param window     forces of supports are means over at least this [s]
  /// @param fields     names of fields whose rows are kept, too, as files have them
  /// @throws InputError if there is no such field, or it is a flag
  Recording(RunLayout layout, double interval, double window, const std::vector<std::string>& fields = {});
  Recording(const Recording&) = delete;
  Recording& operator=(const Recording&) = delete;
  ~Recording() override;

  /// What looks for peaks of forces between the rows, a listener of its own; null: rows are dense enough.
  [[nodiscard]] Observer* sampler() const noexcept { return sampler_.get(); }
  [[nodiscard]] double interval() const override { return interval_; }
  void snapshot(const Snapshot& state) override;
  void events(const StepRecords<ImpactRecord>& impacts, const StepRecords<RestRecord>& rests,
              const EventCounts& all) override;

  [[nodiscard]] const SupportForces& forces() const noexcept { return forces_; }
  [[nodiscard]] std::span<const double> times() const noexcept { return times_; }  ///< of the rows [s]
  /// @brief A field that is kept: row by row this rank's nodes, or its cells, with their components.
  struct KeptField : FileField {
    std::vector<double> rows{};
  };
  /// @throws InputError if it is not kept
  [[nodiscard]] const KeptField& field(const std::string& name) const;
  /// One of the points of each of this rank's nodes, in the order of fields.
  [[nodiscard]] std::span<const std::size_t> points_of_nodes() const noexcept { return layout_.rows->a_point(); }
  /// Number in the user's model of the node of a local point.
  [[nodiscard]] std::int64_t number(std::size_t point) const { return layout_.rows->number(point); }
  [[nodiscard]] RecordedTable energy() const;  ///< the columns of energy.csv

  /// @name The same on every rank. @note Collective.
  /// @{
  [[nodiscard]] RecordedTable gauges() const;    ///< the columns of gauges.csv
  [[nodiscard]] RecordedTable strikers() const;  ///< those of strikers.csv
  /// Forces and impulses: row by row, one number for each support [N], [N s], y up.
  [[nodiscard]] std::vector<ContactRow> contact() const;
  [[nodiscard]] std::span<const double> support_force() const;
  [[nodiscard]] std::span<const double> support_impulse() const;
  /// By time, then node, whose number is the user's.
  [[nodiscard]] std::vector<ImpactRecord> impacts() const;
  [[nodiscard]] std::vector<RestRecord> rests() const;
  /// @}

 private:
  RunLayout layout_;
  double interval_;
  SupportForces forces_;
  std::unique_ptr<Observer> sampler_;
  std::unique_ptr<GaugeRows> gauges_;
  std::unique_ptr<GaugeRows> strikers_;
  std::unique_ptr<ContactRows> contact_;
  std::vector<KeptField> fields_;
  std::vector<double> times_;
  std::vector<EnergyLedger> energy_;
  std::vector<ImpactRecord> impacts_;  // this rank's
  std::vector<RestRecord> rests_;
};

}  // namespace udar::io
