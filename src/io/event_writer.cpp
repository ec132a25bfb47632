#include <utility>
#include <vector>

#include "io/block_writer.hpp"
#include "io/event_order.hpp"
#include "io/text_file.hpp"
#include "io/writers.hpp"
#include "udar/io/csv.hpp"
#include "udar/motion/motion_state.hpp"
#include "udar/petsc/error.hpp"

namespace udar::io {
namespace {

/// Events of all ranks that may wait, and that rank 0 may get at a time.
constexpr PetscInt kEventsMax = 65536;
/// Rows of a table of events that are also written as text.
constexpr PetscInt kTextRowsMax = 1'000'000;

/// One table of events: a dataset of results.h5, and a text file as long as people may want to read it. Rows of steps
/// with few events wait with their rank and go to the disk through rank 0, in order of time, then node. A step with
/// many is written by all ranks at once, in order of nodes.
template <class Record>
class EventTable {
 public:
  using Append = void (ResultsFile::*)(std::span<const Record>);

  EventTable(const RunLayout& layout, const std::string& folder, std::string name, const std::string& header,
             const std::shared_ptr<ResultsFile>& results, Append append)
      : comm_{layout.comm()},
        name_{std::move(name)},
        results_{results},
        append_{append},
        file_{comm_, folder + name_, {.header = header}, layout.earlier} {
    if (layout.earlier != nullptr) {
      text_rows_ = static_cast<PetscInt>(layout.earlier->scalar(name_of_rows()));
      text_ended_ = text_rows_ > kTextRowsMax;
    }
  }

  void save(MotionState& state) const {
    file_.save(state);
    state.scalars[name_of_rows()] = static_cast<double>(text_ended_ ? kTextRowsMax + 1 : text_rows_);
  }

  /// @param all rows of all ranks
  template <class Text>
  void add(const std::vector<Record>& rows, PetscInt all, const Text& as_text) {
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
  [[nodiscard]] std::string name_of_rows() const { return "rows of " + name_; }

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

class EventWriter final : public BlockWriter {
 public:
  EventWriter(const RunLayout& layout, const std::string& folder, const std::shared_ptr<ResultsFile>& results,
              double interval)
      : BlockWriter{interval},
        results_{results},
        points_{layout.points},
        rows_{layout.rows},
        impacts_{layout, folder, "impacts.csv", impact_header(), results, &ResultsFile::append_impacts},
        rests_{layout, folder, "rests.csv", rest_header(), results, &ResultsFile::append_rests} {}

  void events(std::span<const ImpactRecord> impacts, std::span<const RestRecord> rests,
              const EventCounts& all) override {
    impacts_.add(in_user_numbers(impacts), all.impacts, impact_rows);
    rests_.add(in_user_numbers(rests), all.rests, rest_rows);
  }

  void save(MotionState& state) const override {
    impacts_.save(state);
    rests_.save(state);
  }

  void finish() override {
    flush();
    results_.leave();
  }

 private:
  template <class Record>
  [[nodiscard]] std::vector<Record> in_user_numbers(std::span<const Record> records) const {
    std::vector<Record> named{records.begin(), records.end()};
    for (Record& record : named) {
      record.node = static_cast<PetscInt>(rows_->number(static_cast<std::size_t>(record.node - points_->begin())));
    }
    return named;
  }

  void add(const Snapshot& /*state*/) override {}

  void write() override {
    impacts_.write(impact_rows);
    rests_.write(rest_rows);
  }

  void sync() override {
    impacts_.sync();
    rests_.sync();
  }

  SharedResults results_;
  const MassPoints* points_;
  std::shared_ptr<const FileRows> rows_;
  EventTable<ImpactRecord> impacts_;
  EventTable<RestRecord> rests_;
};

}  // namespace

std::unique_ptr<Observer> make_event_writer(const RunLayout& layout, const std::string& folder,
                                            const std::shared_ptr<ResultsFile>& results, double interval) {
  return std::make_unique<EventWriter>(layout, folder, results, interval);
}

}  // namespace udar::io
