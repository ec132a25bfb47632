#include "udar/io/run_writers.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "io/event_order.hpp"
#include "io/text_file.hpp"
#include "udar/io/csv.hpp"
#include "udar/io/results_file.hpp"
#include "udar/io/vtkhdf.hpp"
#include "udar/io/xdmf.hpp"
#include "udar/motion/motion_state.hpp"
#include "udar/petsc/error.hpp"

namespace udar::io {
namespace {

constexpr const char* kResults = "results.h5";
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

  void flush() override {
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

  void flush() override {
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

  void flush() override {
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

/// contact.csv, /contact and /supports.
class ContactWriter final : public Observer {
 public:
  ContactWriter(const RunLayout& layout, const std::string& path, std::shared_ptr<ResultsFile> results, double interval,
                SupportForces& forces)
      : comm_{layout.comm},
        results_{std::move(results)},
        interval_{interval},
        forces_{&forces},
        file_{layout.comm, path} {
    file_.append(contact_header(forces_->supports()));
    for (const RunLayout::Support& support : layout.supports) {
      lifts_.push_back(support.lift);
      moves_ = moves_ || support.lift;
    }
    results_->add_contact(forces_->window(), moves_);
  }

  [[nodiscard]] double interval() const override { return interval_; }

  void snapshot(const Snapshot& state) override {
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
    if (schedule_.due()) {
      write();
    }
  }

  void save(MotionState& state) const override { forces_->save(state); }
  void restore(const MotionState& state) override { forces_->restore(state); }

  void flush() override {
    write();
    file_.sync();
  }

 private:
  void write() {
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

  MPI_Comm comm_;
  std::shared_ptr<ResultsFile> results_;
  double interval_;
  SupportForces* forces_;
  TextFile file_;
  Schedule schedule_;
  std::vector<ContactRow> rows_;  ///< that wait
  std::vector<double> force_;     ///< of these rows, one for each support [N]
  std::vector<double> impulse_;   ///< [N s]
  std::vector<double> lift_;      ///< what motion adds to the supports' heights [m]; empty: none moves
  std::vector<std::function<double(double)>> lifts_;
  bool moves_ = false;
  std::vector<double> masses_;  ///< this rank's
  std::vector<double> edges_;   ///< -x_min, x_max of this rank's [m]
};

/// Looks for peaks of forces between rows.
class ForceSampler final : public Observer {
 public:
  ForceSampler(SupportForces& forces, double interval) : forces_{&forces}, interval_{interval} {}

  [[nodiscard]] double interval() const override { return interval_; }
  void snapshot(const Snapshot& state) override { forces_->sample(state.time, state.support_impulse); }

 private:
  SupportForces* forces_;
  double interval_;
};

/// envelope.csv and /envelope: the extremes of all snapshots, kept by the rank that has the node.
class EnvelopeWriter final : public Observer {
 public:
  EnvelopeWriter(const RunLayout& layout, std::string path, std::shared_ptr<ResultsFile> results, double interval,
                 BendingPeaks* bending)
      : comm_{layout.comm},
        nodes_{layout.nodes},
        x_{layout.x},
        stress_per_moment_{layout.stress_per_moment},
        utilisation_per_moment_{layout.utilisation_per_moment},
        path_{std::move(path)},
        results_{std::move(results)},
        interval_{interval},
        bending_{bending} {
    constexpr double kNone = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < kNames.size(); ++i) {
      extremes_[i].assign(x_.size(), i % 2 == 0 ? kNone : -kNone);
      times_[i].assign(x_.size(), 0.0);
    }
    stress_per_moment_.resize(x_.size(), kUnknown);
    utilisation_per_moment_.resize(x_.size(), kUnknown);
  }

  [[nodiscard]] double interval() const override { return interval_; }

  void snapshot(const Snapshot& state) override {
    widen(state.time, state.moment, 0);
    widen(state.time, state.shear, 2);
  }

  void save(MotionState& state) const override {
    for (std::size_t i = 0; i < kNames.size(); ++i) {
      state.fields[kNames[i]] = extremes_[i];
      state.fields[std::string{kNames[i]} + "_time"] = times_[i];
    }
  }
  void restore(const MotionState& state) override {
    for (std::size_t i = 0; i < kNames.size(); ++i) {
      extremes_[i] = state.field(kNames[i], x_.size());
      times_[i] = state.field(std::string{kNames[i]} + "_time", x_.size());
    }
  }

  void finish() override {
    const auto& [moment_min, moment_max, shear_min, shear_max] = extremes_;
    const std::vector<double> stress = times_largest_moment(stress_per_moment_);
    const std::vector<double> utilisation = times_largest_moment(utilisation_per_moment_);
    if (bending_ != nullptr) {
      *bending_ = {.stress = largest(stress), .utilisation = largest(utilisation)};
    }
    results_->add_envelope(moment_min, moment_max, shear_min, shear_max, stress, utilisation);
    if (nodes_.total > kTextNodesMax) {
      return;
    }
    std::vector<EnvelopeRow> rows;
    rows.reserve(x_.size());
    for (std::size_t i = 0; i < x_.size(); ++i) {
      const PetscInt node = nodes_.begin + static_cast<PetscInt>(i);
      const bool element = node + 1 < nodes_.total;
      rows.push_back({.node = node,
                      .x = x_[i],
                      .moment_min = moment_min[i],
                      .moment_max = moment_max[i],
                      .shear_min = element ? shear_min[i] : kUnknown,
                      .shear_max = element ? shear_max[i] : kUnknown,
                      .stress_max = stress[i],
                      .utilisation_max = utilisation[i]});
    }
    TextFile file{comm_, path_};
    file.append(envelope_header() + envelope_rows(gathered(comm_, rows)));
    file.sync();
  }

 private:
  static constexpr PetscInt kTextNodesMax = 100'000;
  static constexpr std::array kNames{"moment_min", "moment_max", "shear_min", "shear_max"};
  static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

  /// The extremes number `least` and the one after it, and when they were first reached.
  void widen(double time, std::span<const double> values, std::size_t least) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (values[i] < extremes_[least][i]) {
        extremes_[least][i] = values[i];
        times_[least][i] = time;
      }
      if (values[i] > extremes_[least + 1][i]) {
        extremes_[least + 1][i] = values[i];
        times_[least + 1][i] = time;
      }
    }
  }

  /// Which of a node's moments is the larger: index into `extremes_`.
  [[nodiscard]] std::size_t larger(std::size_t i) const {
    return std::abs(extremes_[0][i]) > std::abs(extremes_[1][i]) ? 0 : 1;
  }

  [[nodiscard]] std::vector<double> times_largest_moment(std::span<const double> factor) const {
    std::vector<double> values(x_.size());
    for (std::size_t i = 0; i < values.size(); ++i) {
      values[i] = factor[i] * std::abs(extremes_[larger(i)][i]);
    }
    return values;
  }

  /// The largest of all ranks' values that are known. @note Collective.
  [[nodiscard]] std::optional<Peak> largest(std::span<const double> values) const {
    struct {
      double value = -1.0;
      int rank = 0;
    } most;
    MPI_Comm_rank(comm_, &most.rank);
    Peak peak;
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (values[i] > most.value) {  // false where it is not known
        most.value = values[i];
        peak = {.value = values[i], .x = x_[i], .time = times_[larger(i)][i]};
      }
    }
    MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_DOUBLE_INT, MPI_MAXLOC, comm_);
    MPI_Bcast(&peak, 3, MPI_DOUBLE, most.rank, comm_);
    return most.value >= 0.0 ? std::optional{peak} : std::nullopt;
  }

  MPI_Comm comm_;
  NodeRange nodes_;
  std::vector<double> x_;
  std::vector<double> stress_per_moment_;
  std::vector<double> utilisation_per_moment_;
  std::string path_;
  std::shared_ptr<ResultsFile> results_;
  double interval_;
  BendingPeaks* bending_;
  std::array<std::vector<double>, kNames.size()> extremes_;  ///< per node, or per element right of it
  std::array<std::vector<double>, kNames.size()> times_;     ///< when they were first reached [s]
};

/// /fields, results.xdmf and results.vtkhdf; the last of the observers, which closes results.h5.
class FieldWriter final : public Observer {
 public:
  FieldWriter(const RunLayout& layout, const std::string& folder, std::shared_ptr<ResultsFile> results, double interval)
      : results_{std::move(results)}, interval_{interval} {
    if (interval_ > 0.0) {
      xdmf_ = std::make_unique<XdmfFile>(layout.comm, folder + "results.xdmf", kResults,
                                         "results.vtkhdf:/VTKHDF/Points", layout.nodes.total);
      vtkhdf_ = std::make_unique<VtkHdfFile>(layout, folder + "results.vtkhdf", kResults);
    }
  }

  [[nodiscard]] double interval() const override { return interval_; }

  void snapshot(const Snapshot& state) override {
    results_->append_fields(state);
    times_.push_back(state.time);
    show_rows();
    if (rows_shown_ >= 2 * rows_in_vtkhdf_) {  // written anew each time
      write_vtkhdf();
    }
  }

  void flush() override {
    results_->flush();
    show_rows();
  }

  void finish() override {
    flush();
    write_vtkhdf();
    results_->close();
  }

 private:
  /// Shows ParaView the rows that results.h5 has on the disk.
  void show_rows() {
    for (; rows_shown_ < results_->field_rows_on_disk(); ++rows_shown_) {
      xdmf_->append(times_[rows_shown_]);
    }
  }

  void write_vtkhdf() {
    if (rows_shown_ > 0) {
      vtkhdf_->write(std::span{times_}.first(rows_shown_));
    }
    rows_in_vtkhdf_ = rows_shown_;
  }

  std::shared_ptr<ResultsFile> results_;
  double interval_;
  std::unique_ptr<XdmfFile> xdmf_;      ///< null without fields, as the next
  std::unique_ptr<VtkHdfFile> vtkhdf_;  ///< the same rows for other readers
  std::vector<double> times_;           ///< of the rows [s]
  std::size_t rows_shown_ = 0;
  std::size_t rows_in_vtkhdf_ = 0;
};

}  // namespace

double sampling_interval(double interval, double longest) {
  constexpr double kRounding = 1e-6;  // of a part: decimal fractions that rounding has touched
  return longest > 0.0 ? interval / std::max(1.0, std::ceil(interval / longest - kRounding)) : interval;
}

std::vector<std::unique_ptr<Observer>> make_run_writers(const RunLayout& layout, const std::string& directory,
                                                        double interval, double field_interval, SupportForces* forces,
                                                        BendingPeaks* bending) {
  const std::string folder = directory + "/";
  const double sampling = sampling_interval(interval, layout.longest_sample);
  auto results = std::make_shared<ResultsFile>(layout, folder + kResults);
  std::vector<std::unique_ptr<Observer>> writers;
  writers.push_back(std::make_unique<GaugeWriter>(layout, folder + "gauges.csv", interval));
  writers.push_back(std::make_unique<EnergyWriter>(layout, folder + "energy.csv", results, interval));
  writers.push_back(std::make_unique<EventWriter>(layout, folder, results, interval));
  if (forces != nullptr && forces->supports() > 0) {
    writers.push_back(std::make_unique<ContactWriter>(layout, folder + "contact.csv", results, interval, *forces));
    if (sampling < interval) {
      writers.push_back(std::make_unique<ForceSampler>(*forces, sampling));
    }
  }
  writers.push_back(std::make_unique<EnvelopeWriter>(layout, folder + "envelope.csv", results, sampling, bending));
  writers.push_back(std::make_unique<FieldWriter>(layout, folder, results, field_interval));
  return writers;
}

}  // namespace udar::io
