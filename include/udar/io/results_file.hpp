#pragma once
/// @file
/// results.h5: fields, events and energy of a run.

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "udar/io/csv.hpp"
#include "udar/io/impact_merger.hpp"
#include "udar/io/layout.hpp"
#include "udar/io/row_stream.hpp"
#include "udar/motion/observer.hpp"

namespace udar {
struct MotionState;
}

namespace udar::io {

class Hdf5File;

/// @brief What a run came to at each point or in each cell.
struct EnvelopeColumn {
  std::string name;                  ///< "moment_min"
  FieldInfo field;                   ///< what it is an extreme of
  std::span<const double> values{};  ///< one for each point, or cell, of this rank
};

/// @brief The file results.h5. Fields go from each rank straight to the disk; no rank ever holds a whole field.
///
/// Rows reach the disk about every second and with `flush`, each time as a whole file: a run that is killed keeps
/// those.
/// @note All calls are collective. @throws FileError on all ranks together if the disk takes no more; the file then
/// stays as the last append left it
/// @see docs/output.md
class ResultsFile {
 public:
  /// @brief Creates `path`, with positions, gauges, supports, options and versions in it; or goes on in it where it
  /// stood when `layout.earlier` was saved.
  ResultsFile(const RunLayout& layout, const std::string& path);
  ~ResultsFile();
  ResultsFile(const ResultsFile&) = delete;
  ResultsFile& operator=(const ResultsFile&) = delete;

  /// One row of the fields.
  void append_fields(const Snapshot& state);
  /// @name Rows of the tables: each rank's, one rank's behind the other's
  /// @{
  void append_impacts(RowStream<ImpactRecord> rows);
  void append_merged(RowStream<MergedImpact> rows);
  void append_rests(RowStream<RestRecord> rows);
  /// @}
  /// @param[in] times, rows equal on every rank
  void append_energy(std::span<const double> times, std::span<const EnergyLedger> rows);
  /// @brief Makes /contact and /supports. @param[in] force_window what forces are averaged over [s]
  /// @param[in] supports_move whether rows have their lift
  void add_contact(double force_window, bool supports_move);
  /// @param[in] rows, force, impulse as for `contact_rows`, equal on every rank or on rank 0 alone; lift by row, then
  /// support [m], empty if none moves
  void append_contact(std::span<const ContactRow> rows, std::span<const double> force, std::span<const double> impulse,
                      std::span<const double> lift);
  /// @brief Makes /envelope of these columns.
  void add_envelope(std::span<const EnvelopeColumn> columns);
  /// Brings all rows to the disk.
  void flush();
  /// Where the file stands, for who goes on in it; flushes.
  void save(MotionState& state) const;
  /// Times of the rows of the fields that are there [s].
  [[nodiscard]] std::vector<double> field_times() const;
  /// Rows of the fields that are there.
  [[nodiscard]] std::size_t field_rows_on_disk() const noexcept { return field_rows_on_disk_; }
  /// @brief Closes the file; the only way to learn that its last bytes did not reach the disk.
  void close();
  /// @name Of several that write into it, whoever leaves last closes it
  /// @{
  void join() noexcept { ++users_; }
  void leave() {
    if (--users_ == 0) {
      close();
    }
  }
  /// @}

 private:
  void append_field(const FileField& field, const Field& shown);
  template <class Row>
  void append_events(const char* table, RowStream<Row>& rows);
  void flush_if_due();

  std::unique_ptr<Hdf5File> file_;
  std::shared_ptr<const FileRows> rows_;
  std::vector<FileField> fields_;
  int users_ = 0;
  PetscInt supports_ = 0;
  bool first_rank_ = false;
  bool anew_ = true;  ///< not one of an earlier run
  std::size_t field_rows_ = 0;
  std::size_t field_rows_on_disk_ = 0;
};

}  // namespace udar::io
