#include <array>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/block_writer.hpp"
#include "io/table_rows.hpp"
#include "io/text_file.hpp"
#include "io/writers.hpp"
#include "udar/io/csv.hpp"
#include "udar/motion/motion_state.hpp"

namespace udar::io {
namespace {

/// A file of what places read.
class GaugeWriter final : public BlockWriter {
 public:
  GaugeWriter(MPI_Comm comm, const std::string& path, double interval, GaugeRows rows, const MotionState* earlier)
      : BlockWriter{interval}, rows_{std::move(rows)}, file_{comm, path, {.header = rows_.header()}, earlier} {}

  void save(MotionState& state) const override { file_.save(state); }

 private:
  void add(const Snapshot& state) override { rows_.add(state); }

  void write() override {
    file_.append(rows_.text());
    rows_.clear();
  }

  void sync() override { file_.sync(); }

  GaugeRows rows_;
  TextFile file_;
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
        results_{results},
        forces_{&forces},
        rows_{layout, forces},
        file_{layout.comm(), path, {.header = contact_header(forces.supports())}, layout.earlier} {
    results_->add_contact(forces_->window(), rows_.moves());
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
  void add(const Snapshot& state) override { rows_.add(state); }

  void write() override {
    const std::vector<ContactRow> rows = rows_.rows();
    file_.append(rows_.on_first_rank() ? contact_rows(rows, rows_.force(), rows_.impulse()) : "");
    results_->append_contact(rows, rows_.force(), rows_.impulse(), rows_.lift());
    rows_.clear();
  }

  void sync() override { file_.sync(); }

  SharedResults results_;
  SupportForces* forces_;
  ContactRows rows_;
  TextFile file_;
};

}  // namespace

std::unique_ptr<Observer> make_gauge_writer(const RunLayout& layout, const std::string& folder, double interval) {
  return std::make_unique<GaugeWriter>(layout.comm(), folder + "gauges.csv", interval, GaugeRows::of_gauges(layout),
                                       layout.earlier);
}

std::unique_ptr<Observer> make_striker_writer(const RunLayout& layout, const std::string& folder, double interval) {
  return std::make_unique<GaugeWriter>(layout.comm(), folder + "strikers.csv", interval, GaugeRows::of_strikers(layout),
                                       layout.earlier);
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
