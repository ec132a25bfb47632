#pragma once
/// @file
/// Rows of tables as they come with the snapshots, for files and for memory alike.

#include <array>
#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "udar/io/csv.hpp"
#include "udar/io/layout.hpp"
#include "udar/io/support_forces.hpp"
#include "udar/motion/observer.hpp"

namespace udar::io {

/// @brief What some places read of fields, row by row. Values stay with the rank that has the node.
class GaugeRows {
 public:
  /// What gauges.csv has, of each gauge.
  [[nodiscard]] static GaugeRows of_gauges(const RunLayout& layout);
  /// What strikers.csv has, of each striker.
  [[nodiscard]] static GaugeRows of_strikers(const RunLayout& layout);

  void add(const Snapshot& state);
  void clear();
  /// First line of the file.
  [[nodiscard]] std::string header() const;
  /// Rows of the file, on rank 0; elsewhere empty. @note Collective.
  [[nodiscard]] std::string text() const;
  /// Time, then the columns of each place, row behind row, on every rank. @note Collective: one reduction.
  [[nodiscard]] std::vector<double> numbers() const;

 private:
  GaugeRows(const RunLayout& layout, std::vector<std::vector<PointShare>> places);
  void read(std::size_t field, std::string name);

  MPI_Comm comm_;
  int rank_ = 0;
  const MassPoints* points_;
  std::vector<std::vector<PointShare>> places_;        ///< what each reads
  std::function<std::array<double, 2>(double)> base_;  ///< as `RunLayout` has it
  std::vector<std::size_t> field_;                     ///< that a place reads, indices into the snapshot's
  std::vector<std::string> name_;                      ///< of their columns
  std::vector<double> times_;                          ///< of the rows [s]
  std::vector<double> values_;  ///< of these rows, place by place; zero where the node is another rank's
};

/// @brief What contact.csv has, row by row.
class ContactRows {
 public:
  /// @param forces must outlive it
  ContactRows(const RunLayout& layout, SupportForces& forces);

  void add(const Snapshot& state);
  void clear();
  /// Rows so far; of masses and places those of all ranks on rank 0 alone. @note Collective: two reductions.
  [[nodiscard]] std::vector<ContactRow> rows() const;
  [[nodiscard]] std::span<const double> force() const noexcept { return force_; }      ///< row by row [N]
  [[nodiscard]] std::span<const double> impulse() const noexcept { return impulse_; }  ///< row by row [N s]
  [[nodiscard]] std::span<const double> lift() const noexcept { return lift_; }        ///< row by row [m]
  [[nodiscard]] bool moves() const noexcept { return moves_; }                         ///< some support does
  [[nodiscard]] bool on_first_rank() const noexcept { return rank_ == 0; }

 private:
  MPI_Comm comm_;
  int rank_ = 0;
  SupportForces* forces_;
  std::vector<ContactRow> rows_;
  std::vector<double> force_;    ///< of these rows, one for each support [N]
  std::vector<double> impulse_;  ///< [N s]
  std::vector<double> lift_;     ///< what motion adds to the supports' heights [m]; empty: none moves
  std::vector<std::function<double(double)>> lifts_;
  bool moves_ = false;
  std::vector<double> masses_;  ///< this rank's
  std::vector<double> edges_;   ///< -x_min, x_max of this rank's [m]
};

}  // namespace udar::io
