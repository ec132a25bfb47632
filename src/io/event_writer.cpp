#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "io/block_writer.hpp"
#include "io/event_order.hpp"
#include "io/text_file.hpp"
#include "io/writers.hpp"
#include "udar/io/csv.hpp"
#include "udar/io/impact_merger.hpp"
#include "udar/motion/motion_state.hpp"
#include "udar/petsc/error.hpp"

namespace udar::io {
namespace {

/// Events of all ranks that may wait, and that rank 0 may get at a time.
constexpr PetscInt kEventsMax = 65536;
/// Rows that are made text at a time.
constexpr PetscInt kTextAtATime = 4096;
/// Rows of a table of events that are also written as text.
constexpr PetscInt kTextRowsMax = 1'000'000;

/// One table of events: a dataset of results.h5, and a text file as long as people may want to read it. Rows of steps
/// with few events wait with their rank and go to the disk through rank 0, in order of time, then node. A step with
/// many is written by all ranks at once, in order of nodes.
template <class Record>
class EventTable {
 public:
  using Append = void (ResultsFile::*)(RowStream<Record>);

  EventTable(const RunLayout& layout, const std::string& folder, std::string name, const std::string& header,
             const std::shared_ptr<ResultsFile>& results, Append append)
      : comm_{layout.comm()},
        name_{std::move(name)},
        results_{results},
        append_{append},
        file_{comm_, folder + name_, {.header = header}, layout.earlier} {
    if (layout.earlier != nullptr && layout.earlier->scalars.contains(name_of_rows())) {
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
  void add(RowStream<Record> rows, PetscInt all, const Text& as_text) {
    if (waiting_ + all > kEventsMax) {
      write(as_text);
    }
    if (all > kEventsMax) {
      end_text();
      ((*results_).*append_)(std::move(rows));
      return;
    }
    const std::span<const Record> few = rows.next(rows.size());
    rows_.insert(rows_.end(), few.begin(), few.end());
    waiting_ += all;
  }

  template <class Text>
  void write(const Text& as_text) {
    if (waiting_ == 0) {
      return;
    }
    const std::vector<Record> sorted = on_first_rank(comm_, std::exchange(rows_, {}));
    ((*results_).*append_)(RowStream{std::span{sorted}});
    text_rows_ += waiting_;
    if (text_rows_ > kTextRowsMax) {
      end_text();
    }
    for (PetscInt row = 0; row < waiting_ && !text_ended_; row += kTextAtATime) {
      const auto first = std::min(static_cast<std::size_t>(row), sorted.size());  // rank 0 has them all
      const auto count = std::min(static_cast<std::size_t>(kTextAtATime), sorted.size() - first);
      file_.append(as_text(std::span{sorted}.subspan(first, count)));
    }
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

constexpr const char* kLists = "lists of impacts";

std::string lists_of(const ImpactLists& lists) {
  std::string text;
  text += lists.raw ? "raw " : "";
  text += lists.rests ? "rests " : "";
  if (lists.merged) {
    text += "merged within ";
    append_number(text, lists.window);
    text += " s";
  }
  return text.empty() ? "none" : text;
}

/// What goes on in a file was there from the beginning.
void require_same_lists(const RunLayout& layout) {
  const auto there = layout.earlier->texts.find(kLists);
  if (there != layout.earlier->texts.end() && there->second != lists_of(layout.content.impacts)) {
    throw InputError{"output contacts: a run that goes on in its files keeps its lists, " + there->second + " there, " +
                     lists_of(layout.content.impacts) + " here"};
  }
}

class EventWriter final : public BlockWriter {
 public:
  EventWriter(const RunLayout& layout, const std::string& folder, const std::shared_ptr<ResultsFile>& results,
              double interval)
      : BlockWriter{interval},
        comm_{layout.comm()},
        results_{results},
        points_{layout.points},
        rows_{layout.rows},
        lists_{layout.content.impacts},
        in_place_{layout.earlier != nullptr} {
    if (in_place_) {
      require_same_lists(layout);
    }
    if (layout.content.impacts.raw) {
      impacts_.emplace(layout, folder, "impacts.csv", impact_header(), results, &ResultsFile::append_impacts);
    }
    if (layout.content.impacts.rests) {
      rests_.emplace(layout, folder, "rests.csv", rest_header(), results, &ResultsFile::append_rests);
    }
    if (layout.content.impacts.merged) {
      merged_.emplace(layout, folder, "impacts_merged.csv", merged_header(), results, &ResultsFile::append_merged);
      merger_.emplace(points_->begin(), points_->points(), layout.content.impacts.window);
    }
  }

  void events(const StepRecords<ImpactRecord>& impacts, const StepRecords<RestRecord>& rests,
              const EventCounts& all) override {
    std::array<PetscInt, 2> counts{all.impacts, all.rests};
    if (!rows_->whole()) {
      counts = {static_cast<PetscInt>(covered(impacts)), static_cast<PetscInt>(covered(rests))};
      MPI_Allreduce(MPI_IN_PLACE, counts.data(), 2, MPIU_INT, MPI_SUM, comm_);
    }
    if (impacts_) {
      impacts_->add(chosen(impacts), counts[0], impact_rows);
    }
    if (rests_) {
      rests_->add(chosen(rests), counts[1], rest_rows);
    }
    if (merger_) {
      for (const ImpactRecord& impact : impacts) {
        if (covers(impact)) {
          merger_->add({&impact, 1});
        }
      }
      to_merge_ += counts[0];
      if (to_merge_ > kEventsMax) {
        take_merged(merger_->latest());
      }
    }
  }

  void save(MotionState& state) const override {
    const auto save_table = [&state](const auto& table) {
      if (table) {
        table->save(state);
      }
    };
    save_table(impacts_);
    save_table(rests_);
    save_table(merged_);
    state.texts[kLists] = lists_of(lists_);
    if (merger_) {
      merger_->save(comm_, state);
    }
  }
  /// In another folder begins another list: what waited there is in the earlier one.
  void restore(const MotionState& state) override {
    if (merger_ && in_place_) {
      merger_->restore(state);
    }
  }

  void finish() override {
    if (merger_) {
      take_merged(std::numeric_limits<double>::infinity());
    }
    flush();
    results_.leave();
  }

 private:
  /// Whether the node is one of those that are written about.
  template <class Record>
  [[nodiscard]] bool covers(const Record& record) const {
    return rows_->whole() || rows_->covers(static_cast<std::size_t>(record.node - points_->begin()));
  }

  template <class Record>
  [[nodiscard]] std::size_t covered(const StepRecords<Record>& records) const {
    return rows_->whole() ? records.size()
                          : static_cast<std::size_t>(std::ranges::count_if(
                                records, [this](const Record& record) { return covers(record); }));
  }

  /// What is written about, in the user's numbers.
  template <class Record>
  [[nodiscard]] RowStream<Record> chosen(const StepRecords<Record>& records) const {
    return {covered(records), [this, at = records.begin(), part = std::vector<Record>{}](std::size_t count) mutable {
              part.clear();
              part.reserve(count);
              for (; part.size() < count; ++at) {
                if (covers(*at)) {
                  part.push_back(in_user_numbers(*at, *points_, *rows_));
                }
              }
              return std::span<const Record>{part};
            }};
  }

  void add(const Snapshot& /*state*/) override {}

  /// Writes merged impacts that no later one than `time` can join; this rank's time, of which the latest counts.
  void take_merged(double time) {
    MPI_Allreduce(MPI_IN_PLACE, &time, 1, MPI_DOUBLE, MPI_MAX, comm_);
    std::vector<MergedImpact> taken = merger_->take(time);
    for (MergedImpact& impact : taken) {
      impact = in_user_numbers(impact, *points_, *rows_);
    }
    auto all = static_cast<PetscInt>(taken.size());
    MPI_Allreduce(MPI_IN_PLACE, &all, 1, MPIU_INT, MPI_SUM, comm_);
    merged_->add(RowStream<MergedImpact>{taken}, all, merged_rows);
    to_merge_ = 0;
  }

  void write() override {
    if (merger_ && to_merge_ > 0) {
      take_merged(merger_->latest());
    }
    if (impacts_) {
      impacts_->write(impact_rows);
    }
    if (rests_) {
      rests_->write(rest_rows);
    }
    if (merged_) {
      merged_->write(merged_rows);
    }
  }

  void sync() override {
    const auto sync_table = [](auto& table) {
      if (table) {
        table->sync();
      }
    };
    sync_table(impacts_);
    sync_table(rests_);
    sync_table(merged_);
  }

  MPI_Comm comm_;
  SharedResults results_;
  const MassPoints* points_;
  std::shared_ptr<const FileRows> rows_;
  ImpactLists lists_;
  bool in_place_;  ///< goes on in the files of an earlier run
  std::optional<EventTable<ImpactRecord>> impacts_;
  std::optional<EventTable<RestRecord>> rests_;
  std::optional<EventTable<MergedImpact>> merged_;
  std::optional<ImpactMerger> merger_;
  PetscInt to_merge_ = 0;  ///< impacts of all ranks since merged ones were written
};

}  // namespace

std::unique_ptr<Observer> make_event_writer(const RunLayout& layout, const std::string& folder,
                                            const std::shared_ptr<ResultsFile>& results, double interval) {
  return std::make_unique<EventWriter>(layout, folder, results, interval);
}

}  // namespace udar::io
