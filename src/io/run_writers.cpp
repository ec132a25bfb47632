#include "udar/io/run_writers.hpp"

#include <algorithm>
#include <utility>

#include "io/event_order.hpp"
#include "io/text_file.hpp"
#include "udar/io/csv.hpp"
#include "udar/io/results_file.hpp"
#include "udar/io/xdmf.hpp"
#include "udar/petsc/error.hpp"

namespace udar::io {
namespace {

/// Rows of a table that may wait for the disk.
constexpr std::size_t kBlockRows = 256;
/// Events of all ranks that may wait, and that rank 0 may get at a time.
constexpr PetscInt kEventsMax = 65536;
/// Rows of a table of events that are also written as text.
constexpr PetscInt kTextRowsMax = 1'000'000;

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

/// One table of events: a dataset of results.h5, and a text file as long as people may want to read it. Rows of steps
/// with few events wait with their rank and go to the disk through rank 0, in order of time, then node. A step with
/// many is written by all ranks at once, in order of nodes.
template <class Record>
class EventTable {
 public:
  using Append = void (ResultsFile::*)(std::span<const Record>);

  EventTable(MPI_Comm comm, const std::string& folder, std::string name, const std::string& header,
             std::shared_ptr<ResultsFile> results, Append append)
      : comm_{comm},
        name_{std::move(name)},
        results_{std::move(results)},
        append_{append},
        file_{comm, folder + name_} {
    file_.append(header);
  }

  /// @param all rows of all ranks
  template <class Text>
  void add(std::span<const Record> rows, PetscInt all, const Text& as_text) {
    if (waiting_ + all > kEventsMax) {
      write(as_text);
    }
    if (all > kEventsMax) {
      end_text();
      ((*results_).*append_)(rows);
      return;
    }
    rows_.insert(rows_.end(), rows.begin(), rows.end());
    waiting_ += all;
  }

  template <class Text>
  void write(const Text& as_text) {
    if (waiting_ == 0) {
      return;
    }
    const std::vector<Record> sorted = on_first_rank(comm_, rows_);
    ((*results_).*append_)(sorted);
    text_rows_ += waiting_;
    if (text_rows_ > kTextRowsMax) {
      end_text();
    }
    if (!text_ended_) {
      file_.append(as_text(sorted));
    }
    rows_ = {};
    waiting_ = 0;
  }

  void sync() { file_.sync(); }

 private:
  void end_text() {
    if (!text_ended_) {
      UDAR_CALL(
          PetscPrintf(comm_, "udar: too many events for %s: it ends here; all are in results.h5\n", name_.c_str()));
    }
    text_ended_ = true;
  }

  MPI_Comm comm_;
  std::string name_;
  std::shared_ptr<ResultsFile> results_;
  Append append_;
  TextFile file_;
  std::vector<Record> rows_;  ///< that wait, this rank's
  PetscInt waiting_ = 0;      ///< all ranks'
  PetscInt text_rows_ = 0;
  bool text_ended_ = false;
};

/// impacts.csv, rests.csv, /impacts and /rests.
class EventWriter final : public Observer {
 public:
  EventWriter(const RunLayout& layout, const std::string& folder, const std::shared_ptr<ResultsFile>& results,
              double interval)
      : interval_{interval},
        impacts_{layout.comm, folder, "impacts.csv", impact_header(), results, &ResultsFile::append_impacts},
        rests_{layout.comm, folder, "rests.csv", rest_header(), results, &ResultsFile::append_rests} {}

  [[nodiscard]] double interval() const override { return interval_; }

  void events(std::span<const ImpactRecord> impacts, std::span<const RestRecord> rests,
              const EventCounts& all) override {
    impacts_.add(impacts, all.impacts, impact_rows);
    rests_.add(rests, all.rests, rest_rows);
  }

  void snapshot(const Snapshot& /*state*/) override {
    if (schedule_.due()) {
      write();
    }
  }

  void finish() override {
    write();
    impacts_.sync();
    rests_.sync();
  }

 private:
  void write() {
    impacts_.write(impact_rows);
    rests_.write(rest_rows);
  }

  double interval_;
  Schedule schedule_;
  EventTable<ImpactRecord> impacts_;
  EventTable<RestRecord> rests_;
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
  writers.push_back(std::make_unique<EventWriter>(layout, folder, results, interval));
  writers.push_back(std::make_unique<FieldWriter>(layout, folder + "results.xdmf", results, field_interval));
  return writers;
}

}  // namespace udar::io
