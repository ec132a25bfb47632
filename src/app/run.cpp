#include "udar/app/run.hpp"

#include <algorithm>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/checkpoint_writer.hpp"
#include "app/modal_estimate.hpp"
#include "app/run_costs.hpp"
#include "app/run_output.hpp"
#include "app/run_report.hpp"
#include "udar/app/echo.hpp"
#include "udar/app/filter_choice.hpp"
#include "udar/app/filter_warnings.hpp"
#include "udar/app/output_size.hpp"
#include "udar/app/places.hpp"
#include "udar/app/view.hpp"
#include "udar/io/run_directory.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/options.hpp"
#include "udar/petsc/session.hpp"
#include "udar/petsc/warnings.hpp"
#include "udar/structure/beam_matrices.hpp"

namespace udar::app {
namespace {

Case asked_case(MPI_Comm comm) {
  static_cast<void>(petsc::take_warnings());  // an earlier run's in this process
  UDAR_CALL(PetscMemorySetGetMaximumUsage());
  register_types();
  petsc::check_petsc_options();
  return resolve(comm, read_case(comm));
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

/// Runs to the end, or to what ends it: the last good step is kept and reported then, too.
io::Summary go(const Case& input, Model& model, ImpactDynamics& dynamics, RunOutput& output, const CostMark& begin) {
  const RunMarks marks{.begin = begin, .stepping = cost_mark(), .solves_before = model.line.solves()};
  try {
    dynamics.solve();
  } catch (const FileError&) {
    throw;  // what is on the disk stays as it is
  } catch (const std::exception&) {
    output.keep_last_step();
    static_cast<void>(summarise(input, model.line, dynamics, output, marks));
    throw;
  }
  return summarise(input, model.line, dynamics, output, marks);
}

/// @param signal that this rank was sent, 0 for none @note Collective.
int exit_code_of(MPI_Comm comm, bool completed, int signal) {
  constexpr int kStoppedBySteps = 3;
  MPI_Allreduce(MPI_IN_PLACE, &signal, 1, MPI_INT, MPI_MAX, comm);
  return completed ? 0 : signal != 0 ? 128 + signal : kStoppedBySteps;
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
  const Case input = asked_case(comm);
  const bool help = petsc::Session::help_requested();
  std::vector<Mode> modes;
  Model model{comm, input, [&](FilteredStructure& line) {
                if (!help) {
                  modes = settle_modes(line, input);
                }
              }};
  ImpactDynamics dynamics{model};
  if (help) {
    return {};
  }
  refuse_keys_of_other_programs();
  petsc::check_unknown_options(comm);
  refuse_large_output(input);
  std::optional<MotionState> earlier;
  if (!input.restart.file.empty()) {
    earlier = restore(dynamics, input, *model.structure);
  }
  io::prepare_run_directory(comm, input.output.directory, input.output.overwrite, input.restart.file);
  if (!input.write.empty()) {
    write_beam_matrices(*model.structure->chain(), input.write);
  }
  introduce(input, model, modes);

  RunOutput output{input, model.line, dynamics, earlier ? &*earlier : nullptr};
  earlier.reset();
  if (hooks.listener) {
    dynamics.add_observer(hooks.listener(input, model.structure->points()));
  }
  if (hooks.stop_signal) {
    dynamics.set_stop_request([&] { return hooks.stop_signal() != 0; });
  }
  io::Summary summary = go(input, model, dynamics, output, begin);
  output.require_present();
  // After everything of the run is on the disk: whatever becomes of the other run, this one is whole.
  summary.modal_estimate = estimate_by_more_modes(
      comm, input, summary, hooks.stop_signal ? [&] { return hooks.stop_signal() != 0; } : std::function<bool()>{});
  if (summary.modal_estimate) {
    write(comm, input, summary);
  }
  print_end(comm, input, summary);
  const int signal = hooks.stop_signal ? hooks.stop_signal() : 0;
  return {.exit_code = exit_code_of(comm, summary.completed, signal), .summary = summary};
}

}  // namespace udar::app
