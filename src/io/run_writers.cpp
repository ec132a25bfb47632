#include "udar/io/run_writers.hpp"

#include <algorithm>
#include <utility>

#include "io/event_order.hpp"
#include "io/text_file.hpp"
#include "udar/io/csv.hpp"
#include "udar/io/results_file.hpp"
#include "udar/io/xdmf.hpp"

namespace udar::io {
namespace {

/// Rows of a table that may wait for the disk.
constexpr std::size_t kBlockRows = 256;
/// Events a rank may hold before all ranks meet to write them.
constexpr std::size_t kEventsMax = 4096;

/// @brief When a table goes to the disk: after 1, 2, 4, ... rows at first, so that a run shows early that it lives,
/// then every `kBlockRows`, so that the ranks seldom have to meet. The same on every rank.
class Schedule {
 public:
  /// Counts a row; true if what waits is to be written now.
  [[nodiscard]] bool due() noexcept {
    if (++rows_ < block_) {
      return false;
    }
    rows_ = 0;
    block_ = std::min(2 * block_, kBlockRows);
    return true;
  }

 private:
  std::size_t rows_ = 0;
  std::size_t block_ = 1;
};

/// gauges.csv. Values stay with the rank that has the node until a block of rows is full.
class GaugeWriter final : public Observer {
 public:
  GaugeWriter(const RunLayout& layout, const std::string& path, double interval)
      : comm_{layout.comm},
        nodes_{layout.nodes},
        gauge_node_{layout.gauge_node},
        interval_{interval},
        file_{layout.comm, path} {
    MPI_Comm_rank(comm_, &rank_);
    file_.append(gauge_header(gauge_node_.size()));
  }

  [[nodiscard]] double interval() const override { return interval_; }

  void snapshot(const Snapshot& state) override {
    times_.push_back(state.time);
    for (const PetscInt node : gauge_node_) {
      const bool here = nodes_.begin <= node && node < nodes_.end;
      const auto local = static_cast<std::size_t>(here ? node - nodes_.begin : 0);
      values_.push_back(here ? state.mass_position[local] : 0.0);
      values_.push_back(here ? state.mass_velocity[local] : 0.0);
      values_.push_back(here ? state.line_position[local] : 0.0);
    }
    if (schedule_.due()) {
      write();
    }
  }

  void finish() override {
    write();
    file_.sync();
  }

 private:
  void write() {
    // All but one rank add zeros.
    std::vector<double> sum(rank_ == 0 ? values_.size() : 0);
    MPI_Reduce(values_.data(), sum.data(), static_cast<int>(values_.size()), MPI_DOUBLE, MPI_SUM, 0, comm_);
    file_.append(rank_ == 0 ? gauge_rows(times_, sum) : "");
    times_.clear();
    values_.clear();
  }

  MPI_Comm comm_;
  int rank_ = 0;
  NodeRange nodes_;
  std::vector<PetscInt> gauge_node_;
  double interval_;
  TextFile file_;
  Schedule schedule_;
  std::vector<double> times_;   ///< of the rows that wait [s]
  std::vector<double> values_;  ///< of these rows, three for each gauge; zero where the node is another rank's
};

/// energy.csv and /energy.
class EnergyWriter final : public Observer {
 public:
  EnergyWriter(const RunLayout& layout, const std::string& path, std::shared_ptr<ResultsFile> results, double interval)
      : results_{std::move(results)}, interval_{interval}, file_{layout.comm, path} {
    file_.append(energy_header());
  }

  [[nodiscard]] double interval() const override { return interval_; }

  void snapshot(const Snapshot& state) override {
    times_.push_back(state.time);
    rows_.push_back(state.energy);
    if (schedule_.due()) {
      write();
    }
  }

  void finish() override {
    write();
    file_.sync();
  }

 private:
  void write() {
    file_.append(energy_rows(times_, rows_));
    results_->append_energy(times_, rows_);
    times_.clear();
    rows_.clear();
  }

  std::shared_ptr<ResultsFile> results_;
  double interval_;
  TextFile file_;
  Schedule schedule_;
  std::vector<double> times_;  ///< of the rows that wait [s]
  std::vector<EnergyLedger> rows_;
};

/// impacts.csv, rests.csv, /impacts and /rests. Events stay with their rank until written.
class EventWriter final : public Observer {
 public:
  EventWriter(const RunLayout& layout, const std::string& impacts_path, const std::string& rests_path,
              std::shared_ptr<ResultsFile> results, double interval)
      : comm_{layout.comm},
        results_{std::move(results)},
        interval_{interval},
        impacts_file_{layout.comm, impacts_path},
        rests_file_{layout.comm, rests_path} {
    impacts_file_.append(impact_header());
    rests_file_.append(rest_header());
  }

  [[nodiscard]] double interval() const override { return interval_; }

  void events(std::span<const ImpactRecord> impacts, std::span<const RestRecord> rests) override {
    impacts_.insert(impacts_.end(), impacts.begin(), impacts.end());
    rests_.insert(rests_.end(), rests.begin(), rests.end());
  }

  void snapshot(const Snapshot& /*state*/) override {
    const bool due = schedule_.due();
    int write_now = due || impacts_.size() > kEventsMax || rests_.size() > kEventsMax ? 1 : 0;
    MPI_Allreduce(MPI_IN_PLACE, &write_now, 1, MPI_INT, MPI_MAX, comm_);
    if (write_now != 0) {
      write();
    }
  }

  void finish() override {
    write();
    impacts_file_.sync();
    rests_file_.sync();
  }

 private:
  void write() {
    in_order(comm_, impacts_, [this](std::span<const ImpactRecord> rows, std::size_t count) {
      impacts_file_.append(impact_rows(rows));
      results_->append_impacts(rows, count);
    });
    in_order(comm_, rests_, [this](std::span<const RestRecord> rows, std::size_t count) {
      rests_file_.append(rest_rows(rows));
      results_->append_rests(rows, count);
    });
  }

  MPI_Comm comm_;
  std::shared_ptr<ResultsFile> results_;
  double interval_;
  TextFile impacts_file_;
  TextFile rests_file_;
  Schedule schedule_;
  std::vector<ImpactRecord> impacts_;  ///< that wait, in the order they came
  std::vector<RestRecord> rests_;
};

/// /fields and results.xdmf; the last of the observers, which closes results.h5.
class FieldWriter final : public Observer {
 public:
  FieldWriter(const RunLayout& layout, const std::string& xdmf_path, std::shared_ptr<ResultsFile> results,
              double interval)
      : results_{std::move(results)}, interval_{interval} {
    if (interval_ > 0.0) {
      xdmf_ = std::make_unique<XdmfFile>(layout.comm, xdmf_path, "results.h5", layout.nodes.total);
    }
  }

  [[nodiscard]] double interval() const override { return interval_; }

  void snapshot(const Snapshot& state) override {
    results_->append_fields(state);
    xdmf_->append(state.time);
  }

  void finish() override { results_->close(); }

 private:
  std::shared_ptr<ResultsFile> results_;
  double interval_;
  std::unique_ptr<XdmfFile> xdmf_;  ///< null without fields
};

}  // namespace

std::vector<std::unique_ptr<Observer>> make_run_writers(const RunLayout& layout, const std::string& directory,
                                                        double interval, double field_interval) {
  const std::string folder = directory + "/";
  auto results = std::make_shared<ResultsFile>(layout, folder + "results.h5");
  std::vector<std::unique_ptr<Observer>> writers;
  writers.push_back(std::make_unique<GaugeWriter>(layout, folder + "gauges.csv", interval));
  writers.push_back(std::make_unique<EnergyWriter>(layout, folder + "energy.csv", results, interval));
  writers.push_back(
      std::make_unique<EventWriter>(layout, folder + "impacts.csv", folder + "rests.csv", results, interval));
  writers.push_back(std::make_unique<FieldWriter>(layout, folder + "results.xdmf", results, field_interval));
  return writers;
}

}  // namespace udar::io
