/// @file
/// Convergence studies: one case over a grid of options, and what its results converge to.

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "tools/design_report.hpp"
#include "tools/finished_runs.hpp"
#include "tools/study_plan.hpp"
#include "tools/study_quantities.hpp"
#include "tools/study_report.hpp"
#include "udar/app/program.hpp"
#include "udar/app/run.hpp"
#include "udar/app/stop_signals.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/options.hpp"
#include "udar/petsc/scoped_options.hpp"
#include "udar/petsc/session.hpp"

namespace {

using namespace udar;
using study::Design;
using study::Outcome;
using study::PlannedRun;
using study::Series;

constexpr const char* kHelp =
    "udar-study: how the results of a case depend on filter frequency, mesh and time step\n"
    "\n"
    "usage:  udar-study case.yaml -filter_frequency 50,100,200,400 -beam_elements 20,40,80 [-key value ...]\n"
    "        mpirun -n 4 udar-study case.yaml -study_design lines -filter_frequency 100,200,400 -ts_rtol 1e-6,1e-8\n"
    "        udar-study case.yaml -study_vary 'initial_height: 0.1..2' -study_design latin -study_samples 50\n"
    "\n"
    "Runs udar once for every combination of the listed values, several runs side by side, each in a folder of its\n"
    "own, and tells for each quantity the order of convergence observed, the limit where there is one, and the error\n"
    "that filter frequency, mesh and time step leave. -filter_frequency, -beam_elements, -ts_rtol and -ts_dt are axes\n"
    "wherever they have several values; all other options are those of udar (udar -help). Exit codes: 0 all runs\n"
    "reached their end; 1 a run failed; 3 a run was ended by -ts_max_steps; 128 and its number: stopped by a signal.\n";

constexpr std::array kDesigns{
    std::pair<const char*, Design>{"grid", Design::grid}, std::pair<const char*, Design>{"lines", Design::lines},
    std::pair<const char*, Design>{"latin", Design::latin}, std::pair<const char*, Design>{"random", Design::random}};
constexpr std::array kStudyKeys{"-study_axes",   "-study_series", "-study_reference", "-study_design", "-study_ranks",
                                "-study_refine", "-study_vary",   "-study_samples",   "-study_seed",   "-study_resume"};

/// What the user asks of the study itself.
struct StudyParameters {
  study::Request request;
  std::string series;
  std::string reference;
  PetscInt ranks = 1;  // of a run
  std::string directory = "udar-study";
  bool overwrite = false;
  bool resume = false;  // runs that an earlier call has finished are not made again
};

StudyParameters read_parameters(MPI_Comm comm) {
  petsc::OptionGroup group{comm, "Study"};
  StudyParameters asked;
  std::vector<std::string> refine;
  group.strings("-study_axes", asked.request.axes,
                "further keys whose lists of numbers, from coarse to fine, are axes; for most keys a list means "
                "something else");
  group.string("-study_series", asked.series,
               "'name: -key value ...; name: ...': sets of options to compare, each over the axes of the study or its "
               "own; without, the case itself is the only one");
  group.string("-study_reference", asked.reference,
               "series whose limits count as true in the table of work and error, or own: each series its own "
               "(default: the first series)");
  std::string vary;
  group.string(
      "-study_vary", vary,
      "'key: 1, 2; key: 0.1..2; key: 1e6..1e9 log': keys of a design study and their values; in a list, numbers "
      "that belong together stand apart by spaces. No limits are looked for, but peaks, their spread and what "
      "they follow");
  group.choice<Design>("-study_design", asked.request.design, kDesigns,
                       "all combinations, or only those needed: each axis with the others at their finest; of "
                       "-study_vary -study_samples runs: Latin hypercube, or by chance");
  group.integer("-study_samples", asked.request.samples, petsc::at_least(0), "runs of latin and random");
  group.integer("-study_seed", asked.request.seed, petsc::at_least(0), "of their random numbers");
  group.strings("-study_refine", refine, "an axis for beams in segments: factors of every entry of -beam_elements");
  group.integer("-study_ranks", asked.ranks, petsc::at_least(1), "ranks of each run, a divisor of all");
  group.string("-output_directory", asked.directory,
               "folder of the study: study.csv, study.json and a folder for each run");
  group.boolean("-output_overwrite", asked.overwrite, "replace the study that is there");
  group.boolean("-study_resume", asked.resume,
                "go on with the study that is there: runs that have finished with the same options are kept");
  if (petsc::Session::help_requested()) {
    return asked;
  }
  petsc::check_unknown_options(comm, "study_");
  app::register_types();
  petsc::check_petsc_options();
  for (std::string& key : asked.request.axes) {
    key = study::with_dash(key).substr(1);
  }
  std::ranges::replace(asked.series, '\n', ' ');
  std::ranges::replace(vary, '\n', ' ');
  asked.request.variables = study::read_variables(vary);
  return asked;
}

void prepare_directory(MPI_Comm comm, const StudyParameters& asked) {
  namespace fs = std::filesystem;
  std::string failure;
  if (petsc::Session::on_first_rank()) {
    const fs::path folder{asked.directory};
    std::error_code error;
    fs::create_directories(folder, error);
    if (error) {
      failure = "cannot be made a folder: " + error.message();
    } else if (fs::exists(folder / "study.json", error) && !asked.overwrite && !asked.resume) {
      failure =
          "already holds a study (study.json); give -output_overwrite to replace it, -study_resume to go on with it, "
          "or another folder";
    } else {
      fs::remove(folder / "study.json", error);
      fs::remove(folder / "study.csv", error);
    }
  }
  throw_together<FileError>(comm,
                            failure.empty() ? "" : "option -output_directory: '" + asked.directory + "' " + failure);
}

/// The ranks that share a run, and what a run says meanwhile.
class Group {
 public:
  Group(MPI_Comm comm, PetscInt ranks) : index_{rank_in(comm) / static_cast<int>(ranks)} {
    MPI_Comm_split(comm, index_, rank_in(comm), &comm_);
    first_ = rank_in(comm_) == 0;
    if (first_) {
      log_ = std::fopen("/dev/null", "w");
    }
  }
  Group(const Group&) = delete;
  Group& operator=(const Group&) = delete;
  ~Group() {
    PETSC_STDOUT = stdout;  // what comes at the end is of the study
    MPI_Comm_free(&comm_);
  }

  [[nodiscard]] int index() const noexcept { return index_; }
  [[nodiscard]] bool first_rank() const noexcept { return first_; }

  /// One run of the study. @note Collective over the group.
  Outcome run(const PlannedRun& planned) {
    const study::ScopedOptions options{planned.options};
    write_into(planned.options.back().second.value_or("."));
    Outcome outcome;
    int code = 0;
    // Of its own: messages that a failed run has left behind do not reach the next.
    MPI_Comm comm = MPI_COMM_NULL;
    MPI_Comm_dup(comm_, &comm);
    outcome.reason = app::failure_of(comm, [&] {
      const petsc::ScopedOptions alone{{{"-modal_estimate", "no"}}};  // the study compares
      std::optional<study::Sampler> sampler;
      app::Case input;
      const auto listener = [&](const app::Case& seen, const MassPoints& points) -> Observer& {
        input = seen;
        return sampler.emplace(seen, points);
      };
      const app::RunResult result = app::run(comm, {.listener = listener, .stop_signal = app::StopSignals::received});
      code = result.exit_code;
      outcome.quantities = study::quantities(input, result.summary, *sampler);
    });
    MPI_Comm_free(&comm);
    outcome.state = !outcome.reason.empty() ? "failed" : code == 0 ? "finished" : "stopped";
    if (code > 128) {
      stopped_by_ = code;
      outcome.reason = "by a signal";
    } else if (code != 0) {
      outcome.reason = code == 4 ? "by -wall_limit" : "by -ts_max_steps";
    }
    return outcome;
  }
  /// Exit code of a run that a signal stopped, 0 if none.
  [[nodiscard]] int stopped_by() const noexcept { return stopped_by_; }

 private:
  static int rank_in(MPI_Comm comm) {
    int rank = 0;
    MPI_Comm_rank(comm, &rank);
    return rank;
  }

  /// Sends what PETSc and udar print into log.txt of a folder. The stream stays the same for the life of the program:
  /// PETSc's viewers keep it.
  void write_into(const std::string& folder) {
    if (log_ == nullptr) {
      return;
    }
    std::error_code error;
    std::filesystem::create_directories(folder, error);  // the run itself complains if this fails
    log_ = std::freopen((folder + "/log.txt").c_str(), "w", log_);
    if (log_ == nullptr) {
      log_ = std::fopen("/dev/null", "w");
    }
    if (log_ != nullptr) {
      std::setvbuf(log_, nullptr, _IOLBF, BUFSIZ);
      PETSC_STDOUT = log_;
      PETSC_STDERR = log_;
    }
  }

  MPI_Comm comm_ = MPI_COMM_NULL;
  int index_;
  bool first_ = false;
  std::FILE* log_ = nullptr;
  int stopped_by_ = 0;
};

/// Waits for all ranks without taking the processor from those that still compute.
void wait_for_all(MPI_Comm comm) {
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Ibarrier(comm, &request);
  int together = 0;
  for (MPI_Test(&request, &together, MPI_STATUS_IGNORE); together == 0;
       MPI_Test(&request, &together, MPI_STATUS_IGNORE)) {
    std::this_thread::sleep_for(std::chrono::milliseconds{5});
  }
}

/// All texts one after the other, on rank 0.
std::string gathered(MPI_Comm comm, const std::string& text) {
  int rank = 0;
  int ranks = 1;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &ranks);
  const int length = static_cast<int>(text.size());
  std::vector<int> lengths(static_cast<std::size_t>(ranks));
  MPI_Gather(&length, 1, MPI_INT, lengths.data(), 1, MPI_INT, 0, comm);
  std::vector<int> offsets;
  int total = 0;
  for (const int one : lengths) {
    offsets.push_back(total);
    total += one;
  }
  std::string all(static_cast<std::size_t>(rank == 0 ? total : 0), ' ');
  MPI_Gatherv(text.data(), length, MPI_CHAR, all.data(), lengths.data(), offsets.data(), MPI_CHAR, 0, comm);
  return all;
}

std::string describe(const Series& series, const PlannedRun& run) {
  std::string text = series.name;
  for (std::size_t a = 0; a < series.axes.size(); ++a) {
    text += (a == 0 ? ": " : ", ") + series.axes[a].key + " " + series.axes[a].values[run.at[a]];
  }
  return text;
}

std::string write_file(const std::string& path, const std::string& text) {
  std::ofstream file{path};
  file << text << std::flush;
  return file.good() ? "" : "option -output_directory: cannot write '" + path + "'";
}

/// Reads series and reference, which depend on each other.
std::vector<Series> read_series(StudyParameters& asked) {
  std::vector<Series> series = study::read_series(asked.series);
  if (asked.reference.empty()) {
    asked.reference = series.front().name;
  } else if (asked.reference != "own" && std::ranges::find(series, asked.reference, &Series::name) == series.end()) {
    throw InputError{"option -study_reference: there is no series '" + asked.reference + "'"};
  }
  return series;
}

/// The runs dealt to a group, one after the other, until a signal stops one.
/// @return their outcomes, packed, on the group's first rank
study::Json run_dealt(Group& group, const std::vector<std::size_t>& dealt, const std::vector<Series>& series,
                      const std::vector<PlannedRun>& runs, const study::FinishedRuns& kept) {
  study::Json own = study::Json::array();
  for (const std::size_t number : dealt) {
    if (group.stopped_by() != 0) {
      break;
    }
    const double begin = MPI_Wtime();
    const Outcome outcome = group.run(runs[number]);
    if (group.first_rank()) {
      if (outcome.state == "finished") {
        kept.add(runs[number], outcome);
      }
      own.push_back(study::packed(number, outcome));
      std::printf("run %zu of %zu %s after %.3g s (%s)%s\n", number, runs.size(), outcome.state.c_str(),
                  MPI_Wtime() - begin, describe(series[runs[number].series], runs[number]).c_str(),
                  outcome.reason.empty() ? "" : (": " + outcome.reason).c_str());
      std::fflush(stdout);
    }
  }
  return own;
}

/// Outcomes of `count` runs from those of before and what the groups packed, one array of them a line.
std::vector<Outcome> unpacked(const std::string& all, const std::map<std::size_t, Outcome>& before, std::size_t count) {
  std::vector<Outcome> outcomes(count);
  for (const auto& [number, outcome] : before) {
    outcomes[number] = outcome;
  }
  for (const std::string& line : study::split(all, '\n')) {
    for (const study::Json& entry : line.empty() ? study::Json::array() : study::Json::parse(line)) {
      outcomes[entry["number"].get<std::size_t>()] = study::unpacked(entry);
    }
  }
  return outcomes;
}

/// The exit code that a program ends with after such runs.
int exit_code_of(const std::vector<Outcome>& outcomes) {
  constexpr int kStoppedBySteps = 3;
  int code = 0;
  for (const Outcome& outcome : outcomes) {
    if (outcome.state == "failed") {
      return 1;
    }
    code = outcome.state != "finished" ? kStoppedBySteps : code;
  }
  return code;
}

/// Prints and writes what the runs come to. @return what went wrong
template <class Report>
std::string write_report(const Report& report, const std::string& directory) {
  std::string failure = write_file(directory + "/study.csv", report.csv());
  if (failure.empty()) {
    failure = write_file(directory + "/study.json", report.json().dump(2) + "\n");
  }
  std::printf("%sudar-study: results in %s\n", report.tables().c_str(), directory.c_str());
  std::fflush(stdout);
  return failure;
}

/// What an earlier study has finished of these runs, if this one goes on with it. @note Collective.
std::map<std::size_t, Outcome> runs_before(MPI_Comm comm, const StudyParameters& asked,
                                           const std::vector<PlannedRun>& runs, const study::FinishedRuns& kept) {
  if (asked.resume) {
    UDAR_CALL(PetscOptionsSetValue(nullptr, "-output_overwrite", "true"));  // folders of runs that did not finish
    return kept.among(comm, runs);
  }
  if (petsc::Session::on_first_rank()) {
    kept.clear();
  }
  MPI_Barrier(comm);
  return {};
}

int run_study(MPI_Comm comm) {
  const app::StopSignals signals;
  if (petsc::effective_options().empty()) {
    UDAR_CALL(PetscPrintf(comm, "%s", kHelp));
    return 1;
  }
  int ranks = 1;
  MPI_Comm_size(comm, &ranks);
  StudyParameters asked = read_parameters(comm);
  if (petsc::Session::help_requested()) {
    return 0;
  }
  if (ranks % asked.ranks != 0) {
    throw InputError{"option -study_ranks: " + std::to_string(asked.ranks) +
                     " is not allowed, expected a divisor of the " + std::to_string(ranks) + " ranks"};
  }
  std::vector<Series> series = read_series(asked);
  std::vector<PlannedRun> runs = study::plan(series, asked.request, asked.directory);
  for (const char* key : kStudyKeys) {  // so that the options in each run's files are its own
    UDAR_CALL(PetscOptionsClearValue(nullptr, key));
  }
  prepare_directory(comm, asked);

  Group group{comm, asked.ranks};
  const study::FinishedRuns kept{asked.directory, group.index()};
  const std::map<std::size_t, Outcome> before = runs_before(comm, asked, runs, kept);
  const auto groups = static_cast<std::size_t>(ranks) / static_cast<std::size_t>(asked.ranks);
  if (petsc::Session::on_first_rank()) {
    std::printf("udar-study: %zu runs, %zu side by side, %d rank(s) each\n", runs.size(), std::min(groups, runs.size()),
                static_cast<int>(asked.ranks));
    if (!before.empty()) {
      std::printf("%zu of them have finished before\n", before.size());
    }
    std::fflush(stdout);
  }
  std::vector<PlannedRun> left = runs;
  std::erase_if(left, [&before](const PlannedRun& run) { return before.contains(run.number); });
  const auto dealt = study::deal(left, groups);
  const study::Json own = run_dealt(group, dealt[static_cast<std::size_t>(group.index())], series, runs, kept);
  wait_for_all(comm);
  if (groups > 1) {
    // mpirun passes on the lines of each rank when it gets round to it: the last must not fall into the tables.
    std::this_thread::sleep_for(std::chrono::milliseconds{200});
  }

  const std::string all = gathered(comm, group.first_rank() ? own.dump() + "\n" : "");
  std::array<int, 2> worst{group.stopped_by(), 0};
  std::string failure;
  if (petsc::Session::on_first_rank()) {
    std::vector<Outcome> outcomes = unpacked(all, before, runs.size());
    worst[1] = exit_code_of(outcomes);
    study::Runs table{std::move(series), std::move(runs), std::move(outcomes)};
    failure = asked.request.variables.empty()
                  ? write_report(study::Report{std::move(table), asked.reference}, asked.directory)
                  : write_report(study::DesignReport{std::move(table)}, asked.directory);
  }
  throw_together<FileError>(comm, failure);
  MPI_Allreduce(MPI_IN_PLACE, worst.data(), 2, MPI_INT, MPI_MAX, comm);
  return worst[0] != 0 ? worst[0] : worst[1];
}

}  // namespace

int main(int argc, char** argv) { return udar::app::guarded_main(argc, argv, kHelp, run_study); }
