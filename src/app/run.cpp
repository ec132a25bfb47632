#include "udar/app/run.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <new>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "app/checkpoint_writer.hpp"
#include "app/citations.hpp"
#include "app/continued_run.hpp"
#include "app/modal_estimate.hpp"
#include "app/run_costs.hpp"
#include "app/run_layout.hpp"
#include "app/run_output.hpp"
#include "app/run_report.hpp"
#include "udar/app/echo.hpp"
#include "udar/app/filter_choice.hpp"
#include "udar/app/filter_warnings.hpp"
#include "udar/app/memory_size.hpp"
#include "udar/app/output_size.hpp"
#include "udar/app/places.hpp"
#include "udar/app/program.hpp"
#include "udar/app/view.hpp"
#include "udar/io/run_directory.hpp"
#include "udar/motion/kinks.hpp"
#include "udar/petsc/diverted_text.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/options.hpp"
#include "udar/petsc/session.hpp"
#include "udar/petsc/warnings.hpp"
#include "udar/structure/beam_matrices.hpp"

namespace udar::app {
namespace {

Case settled_case(MPI_Comm comm, const CaseInput& asked, const std::optional<ContinuedRun>& continued) {
  refuse_large_memory(comm, asked);
  Case input = resolve(comm, asked);
  if (continued) {
    input.restart.in_place = !continued->file.empty();
    input.restart.file = input.restart.in_place ? continued->file : input.restart.file;
  }
  return input;
}

/// Whether there is nothing left to do, not even what comes at the end.
bool is_complete(MPI_Comm comm, const Case& input, const MotionState& earlier) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  int ended = 0;
  if (rank == 0) {
    std::ifstream file{input.output.directory + "/summary.json"};
    const std::string summary{std::istreambuf_iterator<char>{file}, {}};
    const bool estimated =
        !input.modal || !input.modal_estimate || summary.find("\"modal_estimate\"") != std::string::npos;
    ended = !summary.empty() && estimated ? 1 : 0;
  }
  MPI_Bcast(&ended, 1, MPI_INT, 0, comm);
  return ended != 0 && input.end_time - earlier.scalar("time") <= time_resolution(input.end_time);
}

/// The folder of a run, taken for this program alone.
io::FolderLock open_folder(MPI_Comm comm, const Case& input, std::optional<ContinuedRun>& continued) {
  const std::string& folder = input.output.directory;
  io::FolderLock lock = continued ? std::move(continued->lock) : io::FolderLock{};
  if (input.restart.in_place) {
    io::reopen_run_directory(comm, folder);
    return lock;
  }
  const bool known = continued && continued->known;
  std::error_code error;
  const std::filesystem::path of_restart = std::filesystem::path{input.restart.file}.parent_path();
  if (input.output.overwrite && !input.restart.file.empty() &&
      std::filesystem::equivalent(of_restart.empty() ? "." : of_restart, folder, error)) {
    petsc::warn(
        comm,
        "-output_overwrite removes the results in '%s' that its restart file belongs to; udar -continue %s goes "
        "on in them",
        folder.c_str(), folder.c_str());
  }
  const std::string keep = known ? folder + "/restart.h5" : input.restart.file;
  return io::prepare_run_directory(comm, folder, input.output.overwrite || known, keep, std::move(lock));
}

/// All that is said before the first step.
void introduce(const Case& input, Model& model, const std::vector<Mode>& modes) {
  FilteredStructure& line = model.line;
  const SupportSprings springs = support_springs(line, input);
  if (input.view) {
    print_view(input, line, modes, springs);
  } else {
    print_echo(input, line, modes);
  }
  warn_of_implausible(input, line.structure());
  if (!line.corrected_modes().empty() && model.equations.line_contact() != nullptr) {
    UDAR_CALL(PetscPrintf(line.points().comm(),
                          "udar: with the line on its supports no frequency is above %.10g rad/s\n",
                          model.equations.frequency_bound()));
  }
  print_warnings(input, line, modes, springs);
  warn_of_places(input, line.structure());
}

/// What is left of a run that failed. @return what to do about it
std::string keep(const Case& input, Model& model, const ImpactDynamics& dynamics, RunOutput& output,
                 const RunMarks& marks) {
  try {
    output.keep_last_step();
    static_cast<void>(summarise(input, model.line, dynamics, output, marks));
  } catch (const FileError& error) {
    return std::string{"; nor can the last good step be kept: "} + error.what() +
           how_to_go_on(input, dynamics.time(), false);
  }
  return how_to_go_on(input, dynamics.time(), true);
}

/// Runs to the end, or to what ends it: the last good step is kept and reported then, too.
io::Summary go(const Case& input, Model& model, ImpactDynamics& dynamics, RunOutput& output, const CostMark& begin,
               std::span<const Mode> modes) {
  const RunMarks marks{.begin = begin, .stepping = cost_mark(), .modes = modes};
  try {
    dynamics.solve();
  } catch (const FileError& error) {  // what is on the disk stays as it is
    throw FileError{error.what() + how_to_go_on(input, dynamics.time(), false)};
  } catch (const std::bad_alloc&) {  // on this rank alone, as a rule: the others cannot be asked to write
    throw SolveError{kShortOfMemory + how_to_go_on(input, dynamics.time(), false)};
  } catch (const std::exception& error) {
    throw SolveError{error.what() + keep(input, model, dynamics, output, marks)};
  }
  return summarise(input, model.line, dynamics, output, marks);
}

/// @param signal that this rank was sent, 0 for none @note Collective.
int exit_code_of(MPI_Comm comm, bool completed, int signal, bool late) {
  constexpr int kStoppedBySteps = 3;
  constexpr int kStoppedByClock = 4;
  std::array<int, 2> why{signal, late ? 1 : 0};
  MPI_Allreduce(MPI_IN_PLACE, why.data(), 2, MPI_INT, MPI_MAX, comm);
  return completed ? 0 : why[0] != 0 ? 128 + why[0] : why[1] != 0 ? kStoppedByClock : kStoppedBySteps;
}

/// Whose groups nobody here reads.
void refuse_keys_of_other_programs() {
  for (const auto& [group, program] : {std::pair{"study_", "udar-study"}, std::pair{"bench_", "udar-bench"}}) {
    if (const std::string key = petsc::unread_option(group); !key.empty()) {
      throw InputError{"option " + key + " is not allowed here, it is one of " + program};
    }
  }
}

}  // namespace

RunResult run(MPI_Comm comm, const RunHooks& hooks) {
  const CostMark begin = cost_mark();
  register_types();
  petsc::check_petsc_options();
  static_cast<void>(petsc::take_warnings());  // an earlier run's in this process
  UDAR_CALL(PetscMemorySetGetMaximumUsage());
  std::optional<ContinuedRun> continued = take_up_run(comm);
  const CaseInput asked = read_case(comm);
  const petsc::DivertedText diverted{asked.output.output.page == PageForm::json};
  const Case input = settled_case(comm, asked, continued);
  const bool help = petsc::Session::help_requested();
  std::vector<Mode> modes;
  Model model{comm, input, [&](FilteredStructure& line) {
                if (!help) {
                  modes = settle_modes(line, input);
                }
              }};
  ImpactDynamics dynamics{model};
  dynamics.set_guard(input.guard);
  if (help) {
    return {};
  }
  cite(!input.modal && input.filter.filtered());
  refuse_keys_of_other_programs();
  petsc::check_unknown_options(comm);
  refuse_large_output(input);
  // Before anything is written over.
  io::RunLayout layout = make_layout(input, model.line, model.contacts, dynamics.fields());
  std::optional<MotionState> earlier;
  if (!input.restart.file.empty()) {
    earlier = restore(dynamics, input, *model.structure);
  }
  const bool in_place = input.restart.in_place;
  if (in_place && is_complete(comm, input, *earlier)) {
    UDAR_CALL(PetscPrintf(comm,
                          "udar: the run in '%s' has reached its end at t = %.6g s; a later -ts_max_time goes on\n",
                          input.output.directory.c_str(), input.end_time));
    return {};
  }
  const io::FolderLock lock = open_folder(comm, input, continued);
  if (!input.write.empty()) {
    write_beam_matrices(*model.structure->chain(), input.write);
  }
  introduce(input, model, modes);

  if (in_place) {
    UDAR_CALL(PetscPrintf(comm, "udar: the run in '%s' goes on at t = %.6g s\n", input.output.directory.c_str(),
                          earlier->scalar("time")));
  }
  RunOutput output{input, model, dynamics, std::move(layout), earlier ? &*earlier : nullptr};
  earlier.reset();
  if (hooks.listener) {
    dynamics.add_observer(hooks.listener(input, model.structure->points()));
  }
  const auto signal = [&] { return hooks.stop_signal ? hooks.stop_signal() : 0; };
  const auto late = [&] { return input.wall_limit > 0.0 && wall_time() - begin.time >= input.wall_limit; };
  const auto stop = [&] { return signal() != 0 || late(); };
  dynamics.set_stop_request(stop);
  io::Summary summary = go(input, model, dynamics, output, begin, modes);
  output.require_present();
  // After everything of the run is on the disk: whatever becomes of the other run, this one is whole.
  summary.modal_estimate = estimate_by_more_modes(comm, input, summary, stop);
  if (summary.modal_estimate) {
    write(comm, input, summary);
  }
  print_end(comm, input, *model.structure, summary);
  return {.exit_code = exit_code_of(comm, summary.completed, signal(), late()), .summary = summary};
}

}  // namespace udar::app
