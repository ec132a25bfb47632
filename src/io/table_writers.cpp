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

/// What every rank is told alike, or the first one alone: some numbers of each of some things.
class StateWriter final : public BlockWriter {
 public:
  /// @param things how many @param columns of each @param numbers appends those of all to what it is given
  StateWriter(const RunLayout& layout, const std::string& path, double interval, std::size_t things,
              std::span<const std::string_view> columns,
              std::function<void(const Snapshot&, std::vector<double>&)> numbers)
      : BlockWriter{interval},
        comm_{layout.comm()},
        numbers_{std::move(numbers)},
        file_{comm_, path, {.header = gauge_header(things, columns)}, layout.earlier} {}

  void save(MotionState& state) const override { file_.save(state); }

 private:
  void add(const Snapshot& state) override {
    times_.push_back(state.time);
    numbers_(state, values_);
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
  std::function<void(const Snapshot&, std::vector<double>&)> numbers_;
  TextFile file_;
  std::vector<double> times_;   ///< of the rows that wait [s]
  std::vector<double> values_;  ///< of these rows, thing by thing
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
  constexpr std::array<std::string_view, 3> kColumns{"displacement", "velocity", "force"};
  return std::make_unique<StateWriter>(layout, folder + "places.csv", interval, layout.places, kColumns,
                                       [](const Snapshot& state, std::vector<double>& values) {
                                         for (const auto& [displacement, velocity, force] : state.places) {
                                           values.insert(values.end(), {displacement, velocity, force});
                                         }
                                       });
}

std::unique_ptr<Observer> make_axle_writer(const RunLayout& layout, const std::string& folder, double interval) {
  constexpr std::array<std::string_view, 5> kColumns{"x", "position", "velocity", "line", "force"};
  return std::make_unique<StateWriter>(layout, folder + "axles.csv", interval, layout.points->riders().size(), kColumns,
                                       [](const Snapshot& state, std::vector<double>& values) {
                                         for (const auto& [x, height, velocity, below, force] : state.riders) {
                                           values.insert(values.end(), {x, height, velocity, below, force});
                                         }
                                       });
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
