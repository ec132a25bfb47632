#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/block_writer.hpp"
#include "io/text_file.hpp"
#include "io/writers.hpp"
#include "udar/io/csv.hpp"
#include "udar/motion/motion_state.hpp"

namespace udar::io {
namespace {

/// What is read of one place over time: fields of the snapshots, and what their columns are called.
struct GaugeColumns {
  std::vector<std::size_t> field;  ///< indices into the snapshot's
  std::vector<std::string> name;   ///< as many
};

GaugeColumns of_gauges(const RunLayout& layout) {
  GaugeColumns columns;
  for (std::size_t i = 0; i < layout.fields.size(); ++i) {
    if (!layout.fields[i].gauge.empty()) {
      columns.field.push_back(i);
      columns.name.emplace_back(layout.fields[i].gauge);
    }
  }
  return columns;
}

GaugeColumns of_strikers(const RunLayout& layout) {
  GaugeColumns columns;
  for (std::size_t i = 0; i < layout.fields.size(); ++i) {
    if (layout.fields[i].name == "mass_position" || layout.fields[i].name == "mass_velocity") {
      columns.field.push_back(i);
      columns.name.emplace_back(layout.fields[i].position ? "position" : "velocity");
    }
  }
  return columns;
}

/// Values stay with the rank that has the node until a block of rows is full.
class GaugeWriter final : public BlockWriter {
 public:
  /// @param heights what each place reads
  GaugeWriter(const RunLayout& layout, const std::string& path, double interval, const GaugeColumns& columns,
              std::vector<std::vector<PointShare>> heights)
      : BlockWriter{interval},
        comm_{layout.comm()},
        points_{layout.points},
        gauges_{std::move(heights)},
        base_{layout.base},
        field_{columns.field},
        file_{comm_, path, {.header = header(columns, gauges_.size(), layout.base != nullptr)}, layout.earlier} {
    MPI_Comm_rank(comm_, &rank_);
  }

  void save(MotionState& state) const override { file_.save(state); }

 private:
  [[nodiscard]] static std::string header(const GaugeColumns& columns, std::size_t places, bool absolute) {
    std::vector<std::string> names = columns.name;
    for (std::size_t i = 0; absolute && i < columns.name.size(); ++i) {
      names.push_back("absolute_" + columns.name[i]);
    }
    return gauge_header(places, std::vector<std::string_view>{names.begin(), names.end()});
  }

  void add(const Snapshot& state) override {
    times_.push_back(state.time);
    const std::array<double, 2> base = base_ && rank_ == 0 ? base_(state.time) : std::array<double, 2>{};
    for (const std::vector<PointShare>& gauge : gauges_) {
      const std::size_t first = values_.size();
      for (const std::size_t field : field_) {
        double value = 0.0;
        for (const auto& [point, share] : gauge) {
          if (points_->owns(point)) {
            value += share * state.fields[field].numbers()[static_cast<std::size_t>(point - points_->begin())];
          }
        }
        values_.push_back(value);
      }
      for (std::size_t i = 0; base_ && i < field_.size(); ++i) {
        values_.push_back(values_[first + i] + (state.fields[field_[i]].position ? base[0] : base[1]));
      }
    }
  }

  void write() override {
    // All but one rank add zeros.
    std::vector<double> sum(rank_ == 0 ? values_.size() : 0);
    MPI_Reduce(values_.data(), sum.data(), static_cast<int>(values_.size()), MPI_DOUBLE, MPI_SUM, 0, comm_);
    file_.append(rank_ == 0 ? gauge_rows(times_, sum) : "");
    times_.clear();
    values_.clear();
  }

  void sync() override { file_.sync(); }

  MPI_Comm comm_;
  int rank_ = 0;
  const MassPoints* points_;
  std::vector<std::vector<PointShare>> gauges_;
  std::function<std::array<double, 2>(double)> base_;  ///< as `RunLayout` has it
  std::vector<std::size_t> field_;                     ///< that a gauge reads, indices into the snapshot's
  TextFile file_;
  std::vector<double> times_;   ///< of the rows that wait [s]
  std::vector<double> values_;  ///< of these rows, gauge by gauge; zero where the node is another rank's
};

/// Where places are that hold the structure and move, and their forces.
class PlaceWriter final : public BlockWriter {
 public:
  PlaceWriter(const RunLayout& layout, const std::string& path, double interval)
      : BlockWriter{interval},
        comm_{layout.comm()},
        file_{comm_, path, {.header = gauge_header(layout.places, kColumns)}, layout.earlier} {}

  void save(MotionState& state) const override { file_.save(state); }

 private:
  static constexpr std::array<std::string_view, 3> kColumns{"displacement", "velocity", "force"};

  void add(const Snapshot& state) override {
    times_.push_back(state.time);
    for (const auto& [displacement, velocity, force] : state.places) {
      values_.insert(values_.end(), {displacement, velocity, force});
    }
  }

  void write() override {
    int rank = 0;
    MPI_Comm_rank(comm_, &rank);
    file_.append(rank == 0 ? gauge_rows(times_, values_) : "");
    times_.clear();
    values_.clear();
  }

  void sync() override { file_.sync(); }

  MPI_Comm comm_;
  TextFile file_;
  std::vector<double> times_;   ///< of the rows that wait [s]
  std::vector<double> values_;  ///< of these rows, place by place
};

class EnergyWriter final : public BlockWriter {
 public:
  EnergyWriter(const RunLayout& layout, const std::string& path, const std::shared_ptr<ResultsFile>& results,
               double interval)
      : BlockWriter{interval},
        results_{results},
        file_{layout.comm(), path, {.header = energy_header()}, layout.earlier} {}

  void save(MotionState& state) const override { file_.save(state); }
  void finish() override {
    flush();
    results_.leave();
  }

 private:
  void add(const Snapshot& state) override {
    times_.push_back(state.time);
    rows_.push_back(state.energy);
  }

  void write() override {
    file_.append(energy_rows(times_, rows_));
    results_->append_energy(times_, rows_);
    times_.clear();
    rows_.clear();
  }

  void sync() override { file_.sync(); }

  SharedResults results_;
  TextFile file_;
  std::vector<double> times_;  ///< of the rows that wait [s]
  std::vector<EnergyLedger> rows_;
};

class ContactWriter final : public BlockWriter {
 public:
  ContactWriter(const RunLayout& layout, const std::string& path, const std::shared_ptr<ResultsFile>& results,
                double interval, SupportForces& forces)
      : BlockWriter{interval},
        comm_{layout.comm()},
        results_{results},
        forces_{&forces},
        file_{comm_, path, {.header = contact_header(forces.supports())}, layout.earlier} {
    for (const RunLayout::Support& support : layout.supports) {
      lifts_.push_back(support.lift);
      moves_ = moves_ || support.lift;
    }
    results_->add_contact(forces_->window(), moves_);
  }

  void save(MotionState& state) const override {
    forces_->save(state);
    file_.save(state);
  }
  void restore(const MotionState& state) override { forces_->restore(state); }

  void finish() override {
    flush();
    results_.leave();
  }

 private:
  void add(const Snapshot& state) override {
    const std::vector<double> force = forces_->add(state.time, state.support_impulse);
    force_.insert(force_.end(), force.begin(), force.end());
    impulse_.insert(impulse_.end(), state.support_impulse.begin(), state.support_impulse.end());
    for (std::size_t k = 0; moves_ && k < lifts_.size(); ++k) {
      lift_.push_back(lifts_[k] ? lifts_[k](state.time) : 0.0);
    }
    rows_.push_back({.time = state.time,
                     .force = std::reduce(force.begin(), force.end()),
                     .impulse = std::reduce(state.support_impulse.begin(), state.support_impulse.end())});
    masses_.push_back(static_cast<double>(state.zone.masses));
    edges_.insert(edges_.end(), {-state.zone.x_min, state.zone.x_max});
  }

  void write() override {
    int rank = 0;
    MPI_Comm_rank(comm_, &rank);
    std::vector<double> masses(masses_.size());
    std::vector<double> edges(edges_.size());
    MPI_Reduce(masses_.data(), masses.data(), static_cast<int>(masses.size()), MPI_DOUBLE, MPI_SUM, 0, comm_);
    MPI_Reduce(edges_.data(), edges.data(), static_cast<int>(edges.size()), MPI_DOUBLE, MPI_MAX, 0, comm_);
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      constexpr double kNowhere = std::numeric_limits<double>::quiet_NaN();
      rows_[i].masses = masses[i];
      rows_[i].x_min = masses[i] > 0.0 ? -edges[2 * i] : kNowhere;
      rows_[i].x_max = masses[i] > 0.0 ? edges[2 * i + 1] : kNowhere;
    }
    file_.append(rank == 0 ? contact_rows(rows_, force_, impulse_) : "");
    results_->append_contact(rows_, force_, impulse_, lift_);
    rows_.clear();
    force_.clear();
    impulse_.clear();
    lift_.clear();
    masses_.clear();
    edges_.clear();
  }

  void sync() override { file_.sync(); }

  MPI_Comm comm_;
  SharedResults results_;
  SupportForces* forces_;
  TextFile file_;
  std::vector<ContactRow> rows_;  ///< that wait
  std::vector<double> force_;     ///< of these rows, one for each support [N]
  std::vector<double> impulse_;   ///< [N s]
  std::vector<double> lift_;      ///< what motion adds to the supports' heights [m]; empty: none moves
  std::vector<std::function<double(double)>> lifts_;
  bool moves_ = false;
  std::vector<double> masses_;  ///< this rank's
  std::vector<double> edges_;   ///< -x_min, x_max of this rank's [m]
};

}  // namespace

std::unique_ptr<Observer> make_gauge_writer(const RunLayout& layout, const std::string& folder, double interval) {
  return std::make_unique<GaugeWriter>(layout, folder + "gauges.csv", interval, of_gauges(layout),
                                       layout.gauges.height);
}

std::unique_ptr<Observer> make_striker_writer(const RunLayout& layout, const std::string& folder, double interval) {
  std::vector<std::vector<PointShare>> heights;
  for (const Strike& strike : layout.points->strikes()) {
    if (!strike.of_nodes()) {
      heights.push_back(layout.points->height_of(strike.gap));
    }
  }
  return std::make_unique<GaugeWriter>(layout, folder + "strikers.csv", interval, of_strikers(layout),
                                       std::move(heights));
}

std::unique_ptr<Observer> make_place_writer(const RunLayout& layout, const std::string& folder, double interval) {
  return std::make_unique<PlaceWriter>(layout, folder + "places.csv", interval);
}

std::unique_ptr<Observer> make_energy_writer(const RunLayout& layout, const std::string& folder,
                                             const std::shared_ptr<ResultsFile>& results, double interval) {
  return std::make_unique<EnergyWriter>(layout, folder + "energy.csv", results, interval);
}

std::unique_ptr<Observer> make_contact_writer(const RunLayout& layout, const std::string& folder,
                                              const std::shared_ptr<ResultsFile>& results, double interval,
                                              SupportForces& forces) {
  return std::make_unique<ContactWriter>(layout, folder + "contact.csv", results, interval, forces);
}

}  // namespace udar::io
