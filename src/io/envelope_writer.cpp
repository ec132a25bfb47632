#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "io/event_order.hpp"
#include "io/text_file.hpp"
#include "io/writers.hpp"
#include "udar/io/csv.hpp"
#include "udar/motion/motion_state.hpp"
#include "udar/petsc/error.hpp"

namespace udar::io {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// The least and the largest values of one field so far, and when they were first reached [s].
struct Extremes {
  FieldInfo field;
  std::size_t index = 0;  ///< in the snapshots
  std::array<std::vector<double>, 2> value;
  std::array<std::vector<double>, 2> time;

  /// @param places points or cells of this rank
  Extremes(const FieldInfo& of, std::size_t number, std::size_t places) : field{of}, index{number} {
    constexpr double kNone = std::numeric_limits<double>::infinity();
    value[0].assign(places, kNone);
    value[1].assign(places, -kNone);
    time.fill(std::vector<double>(places, 0.0));
  }

  [[nodiscard]] std::string name(std::size_t side) const {
    return std::string{field.name} + (side == 0 ? "_min" : "_max");
  }

  /// Of each place the larger of both.
  [[nodiscard]] std::vector<double> sizes() const {
    std::vector<double> all(value[0].size());
    for (std::size_t i = 0; i < all.size(); ++i) {
      all[i] = std::abs(value[larger(i)][i]);
    }
    return all;
  }

  void widen(double now, std::span<const double> values) {
    for (std::size_t i = 0; i < value[0].size(); ++i) {
      if (values[i] < value[0][i]) {
        value[0][i] = values[i];
        time[0][i] = now;
      }
      if (values[i] > value[1][i]) {
        value[1][i] = values[i];
        time[1][i] = now;
      }
    }
  }

  /// Which side of a point has the larger size.
  [[nodiscard]] std::size_t larger(std::size_t i) const {
    return std::abs(value[0][i]) > std::abs(value[1][i]) ? 0 : 1;
  }
};

/// The extremes of all snapshots, kept by the rank that has the point or the cell.
class EnvelopeWriter final : public Observer {
 public:
  EnvelopeWriter(const RunLayout& layout, std::string path, const std::shared_ptr<ResultsFile>& results,
                 double interval, Peaks* peaks)
      : comm_{layout.comm()},
        rows_{layout.rows},
        points_of_{layout.points},
        member_{layout.topology.member},
        points_{layout.points->points()},
        number_(layout.points->own_points()),
        x_(layout.points->own_points()),
        scaled_{layout.peaks},
        path_{std::move(path)},
        results_{results},
        interval_{interval},
        peaks_{peaks} {
    for (std::size_t i = 0; i < x_.size(); ++i) {
      number_[i] = layout.points->number(i);
      x_[i] = layout.points->place(i).x;
    }
    for (std::size_t i = 0; i < layout.fields.size(); ++i) {
      const FieldInfo& field = layout.fields[i];
      if (field.extremes) {
        const bool in_cells = field.where == Where::cells;
        assert(in_cells || !layout.rows->grouped());  // least and largest are of numbers, not of vectors
        extremes_.emplace_back(field, i, in_cells ? static_cast<std::size_t>(layout.topology.cells()) : x_.size());
      }
    }
  }

  [[nodiscard]] double interval() const override { return interval_; }

  void snapshot(const Snapshot& state) override {
    for (Extremes& extremes : extremes_) {
      extremes.widen(state.time, state.fields[extremes.index].numbers());
    }
  }

  void save(MotionState& state) const override {
    for (const Extremes& extremes : extremes_) {
      auto& fields = extremes.field.where == Where::points ? state.fields : state.cells;
      for (const std::size_t side : {0U, 1U}) {
        fields[extremes.name(side)] = padded(extremes, extremes.value[side]);
        fields[extremes.name(side) + "_time"] = padded(extremes, extremes.time[side]);
      }
    }
  }
  void restore(const MotionState& state) override {
    for (Extremes& extremes : extremes_) {
      for (const std::size_t side : {0U, 1U}) {
        const std::size_t places = extremes.value[side].size();
        const std::size_t kept = padded(extremes, extremes.value[side]).size();
        extremes.value[side] = state.field(extremes.name(side), kept, extremes.field.where);
        extremes.time[side] = state.field(extremes.name(side) + "_time", kept, extremes.field.where);
        extremes.value[side].resize(places);
        extremes.time[side].resize(places);
      }
    }
  }

  void finish() override {
    std::vector<EnvelopeColumn> columns;
    for (const Extremes& extremes : extremes_) {
      for (const std::size_t side : {0U, 1U}) {
        columns.push_back({.name = extremes.name(side), .field = extremes.field, .values = extremes.value[side]});
      }
    }
    std::vector<std::vector<double>> scaled;
    scaled.reserve(scaled_.size());  // columns look into them
    for (const ScaledPeak& peak : scaled_) {
      const Extremes& of = extremes_of(peak.field);
      scaled.push_back(scaled_sizes(peak, of));
      columns.push_back({.name = peak.name + "_max",
                         .field = {.name = peak.name, .unit = peak.unit, .body = of.field.body},
                         .values = scaled.back()});
      note(peak.name, scaled.back(), of);
    }
    for (const Extremes& extremes : extremes_) {
      note(std::string{extremes.field.name}, extremes.sizes(), extremes);
    }
    std::vector<std::vector<double>> rows;
    rows.reserve(columns.size());  // columns look into them
    for (EnvelopeColumn& column : columns) {
      rows.push_back(rows_->chosen(column.field.where, column.values));
      column.values = rows.back();
    }
    results_->add_envelope(columns);
    if (rows_->nodes().range().total <= kTextNodesMax &&
        std::ranges::any_of(columns, [this](const EnvelopeColumn& column) { return has_rows(column); })) {
      write_text(columns);
    }
    results_.leave();
  }

 private:
  static constexpr PetscInt kTextNodesMax = 100'000;

  /// As restart files have it: a number for each point, those of strikers included.
  [[nodiscard]] std::vector<double> padded(const Extremes& extremes, std::vector<double> values) const {
    values.resize(extremes.field.where == Where::points ? points_ : values.size(), 0.0);
    return values;
  }

  [[nodiscard]] const Extremes& extremes_of(const std::string& field) const {
    for (const Extremes& extremes : extremes_) {
      if (extremes.field.name == field) {
        return extremes;
      }
    }
    throw std::out_of_range{"there are no extremes of '" + field + "'"};
  }

  [[nodiscard]] std::vector<double> scaled_sizes(const ScaledPeak& peak, const Extremes& of) const {
    const std::vector<double> size = of.sizes();
    std::vector<double> values(x_.size());
    for (std::size_t i = 0; i < values.size(); ++i) {
      values[i] = peak.factor[i] * size[i];
    }
    return values;
  }

  /// Whether values stand with points: those of cells do in a chain alone, where a cell follows each point but the
  /// last.
  [[nodiscard]] bool has_rows(const EnvelopeColumn& column) const {
    return column.field.where == Where::points || (rows_->nodes().same() && !rows_->grouped());
  }

  /// One row a point, in the user's order; what lies in a cell of a chain stands with the point before.
  void write_text(std::span<const EnvelopeColumn> columns) const {
    const std::size_t width = columns.size() + 2;
    const std::vector<std::size_t>& points = rows_->a_point();
    std::vector<double> rows;
    rows.reserve(points.size() * width);
    for (std::size_t i = 0; i < points.size(); ++i) {
      rows.push_back(static_cast<double>(number_[points[i]]));
      rows.push_back(x_[points[i]]);
      for (const EnvelopeColumn& column : columns) {
        const bool there = has_rows(column) && i < column.values.size();
        rows.push_back(there ? column.values[i] : kUnknown);
      }
    }
    std::vector<std::string> names;
    for (const EnvelopeColumn& column : columns) {
      names.push_back(column.name);
    }
    TextFile file{comm_, path_};
    file.append(envelope_header(names) +
                envelope_rows(columns.size(), gathered(comm_, rows_->nodes().to_user(rows, static_cast<int>(width)))));
    file.sync();
  }

  /// Keeps the largest of all ranks' values, if any is known. @note Collective.
  void note(const std::string& name, std::span<const double> values, const Extremes& of) {
    if (peaks_ == nullptr) {
      return;
    }
    Peak peak{.value = -1.0};
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (values[i] > peak.value && std::isfinite(values[i])) {  // false where it is not known
        peak = place_of(of, i);
        peak.value = values[i];
        peak.time = of.time[of.larger(i)][i];
      }
    }
    if (peak = largest_of_all(comm_, peak); peak.value >= 0.0) {
      (*peaks_)[name] = peak;
    }
  }

  /// Of a point, or of the cell that follows it in a chain, or the member that a cell is a piece of.
  [[nodiscard]] Peak place_of(const Extremes& of, std::size_t i) const {
    if (of.field.where == Where::cells && !member_.empty()) {
      return {.member = member_[i]};
    }
    const auto [x, y, z] = i < x_.size() ? points_of_->place(i) : Place{};
    return {.x = x, .y = y, .z = z};
  }

  MPI_Comm comm_;
  std::shared_ptr<const FileRows> rows_;
  const MassPoints* points_of_;
  std::vector<std::int64_t> member_;  ///< of each cell of this rank; empty: no members
  std::size_t points_;                ///< of this rank
  std::vector<std::int64_t> number_;  ///< of this rank's nodes' points in the user's model
  std::vector<double> x_;             ///< of the same [m]
  std::vector<ScaledPeak> scaled_;
  std::string path_;
  SharedResults results_;
  double interval_;
  Peaks* peaks_;
  std::vector<Extremes> extremes_;
};

}  // namespace

std::unique_ptr<Observer> make_envelope_writer(const RunLayout& layout, const std::string& folder,
                                               const std::shared_ptr<ResultsFile>& results, double interval,
                                               Peaks* peaks) {
  return std::make_unique<EnvelopeWriter>(layout, folder + "envelope.csv", results, interval, peaks);
}

}  // namespace udar::io
