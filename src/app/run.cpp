#include "udar/app/run.hpp"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "app/run_costs.hpp"
#include "udar/app/case.hpp"
#include "udar/app/describe_case.hpp"
#include "udar/app/echo.hpp"
#include "udar/app/filter_choice.hpp"
#include "udar/app/output_size.hpp"
#include "udar/app/places.hpp"
#include "udar/app/stop_signals.hpp"
#include "udar/app/view.hpp"
#include "udar/dynamics/impact_dynamics.hpp"
#include "udar/filter/modes.hpp"
#include "udar/io/checkpoint.hpp"
#include "udar/io/hdf5_file.hpp"
#include "udar/io/run_directory.hpp"
#include "udar/io/run_writers.hpp"
#include "udar/io/summary.hpp"
#include "udar/io/versions.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/options.hpp"
#include "udar/petsc/session.hpp"
#include "udar/petsc/warnings.hpp"

namespace udar::app {
namespace {

// An energy balance that is off by more than this is worth a warning.
constexpr double kWorthAWarning = 1e-3;

io::NodeRange node_range(const BeamChain& beam) {
  return {.begin = beam.begin(), .end = beam.end(), .total = beam.nodes()};
}

/// A quarter of the shortest time in which the model knows a force or a moment to come and go, pi / wf; a step of the
/// unfiltered beam, which knows nothing in between.
double longest_sample(const Case& input) {
  return (input.filter.unfiltered ? 2.0 : 0.25 * std::numbers::pi) / input.filter.filter_frequency;
}

io::RunLayout make_layout(const Case& input, const FilteredStructure& line, std::vector<FieldInfo> fields) {
  const BeamChain& beam = line.beam();
  io::RunLayout layout;
  layout.comm = beam.comm();
  layout.elements = beam.elements();
  layout.nodes = node_range(beam);
  layout.filter_frequency = input.filter.filter_frequency;
  layout.longest_sample = longest_sample(input);
  layout.options_text = petsc::effective_options();
  layout.fields = std::move(fields);
  layout.peaks = {{.name = "stress", .unit = "Pa", .field = "moment", .factor = {}},
                  {.name = "utilisation", .unit = "1", .field = "moment", .factor = {}}};
  for (PetscInt node = beam.begin(); node < beam.end(); ++node) {
    layout.x.push_back(beam.position(node));
    const MomentStress per_moment = beam.moment_stress(node);
    layout.peaks[0].factor.push_back(per_moment.stress);
    layout.peaks[1].factor.push_back(per_moment.utilisation);
  }
  layout.mass = line.mass();
  for (const double gauge : input.gauges) {
    layout.gauge_node.push_back(beam.nearest_node(gauge));
  }
  layout.gauge_position = input.gauges;
  for (const Support& support : input.supports) {
    layout.supports.push_back(
        {.position = support.position,
         .width = support.width,
         .height = support.profile.x.empty() ? support.height : std::ranges::max(support.profile.height),
         .restitution = support.restitution,
         .side = static_cast<int>(support.side)});
    if (support.motion) {
      layout.supports.back().lift = [motion = support.motion](double time) { return motion->at(time).height; };
    }
    layout.ground_x.insert(layout.ground_x.end(), support.profile.x.begin(), support.profile.x.end());
    layout.ground_height.insert(layout.ground_height.end(), support.profile.height.begin(),
                                support.profile.height.end());
  }
  return layout;
}

/// The lowest modes: six for the view, else three. They do not depend on a fine mesh: they are taken from a coarser one
/// where the line has more elements than that needs.
std::vector<Mode> modes_to_show(const Case& input, FilteredStructure& line) {
  constexpr PetscInt kEchoed = 3;
  const MPI_Comm comm = line.beam().comm();
  const auto coarse = input.view ? std::nullopt : coarser(comm, input.beam, kEchoed);
  if (!coarse) {
    return lowest_modes(line, input.view ? 6 : kEchoed);
  }
  const BeamChain coarse_beam{comm, *coarse};
  FilteredStructure coarse_line{coarse_beam, input.filter};
  return lowest_modes(coarse_line, kEchoed);
}

/// Writes restart.h5 after the first step beyond each multiple of the interval, at the end, and when somebody asks.
class CheckpointWriter final : public Observer {
 public:
  /// @param others what is flushed before, so that no row is missing between this run and the one that goes on
  CheckpointWriter(const ImpactDynamics& dynamics, const Case& input, const BeamChain& beam,
                   std::span<const std::unique_ptr<Observer>> others)
      : dynamics_{&dynamics},
        order_{beam.comm(), node_range(beam)},
        path_{(std::filesystem::path{input.output.directory} / "restart.h5").string()},
        interval_{input.restart.interval},
        parameters_{describe(input).parameters()} {
    for (const auto& other : others) {
      others_.push_back(other.get());
    }
    set_next(0.0);
  }

  void step(const Progress& progress) override {
    if (interval_ > 0.0 && progress.time >= next_) {
      for (Observer* other : others_) {
        other->flush();
      }
      write();
      set_next(progress.time);
    }
  }
  void restore(const MotionState& state) override { set_next(state.scalar("time")); }
  void finish() override { write(); }

  void write() const {
    MotionState state = dynamics_->save();
    state.parameters = parameters_;
    io::write_checkpoint(order_, path_, state);
  }

 private:
  /// The least multiple of the interval above `time`, or `time` itself if their distance is below its last digit.
  void set_next(double time) { next_ = interval_ > 0.0 ? time + (interval_ - std::fmod(time, interval_)) : 0.0; }

  const ImpactDynamics* dynamics_;
  io::PointOrder order_;
  std::string path_;
  double interval_;
  double next_ = 0.0;
  std::vector<Parameter> parameters_;
  std::vector<Observer*> others_;
};

MotionState restore(ImpactDynamics& dynamics, const Case& input, const BeamChain& beam) {
  const auto accept = [&](std::span<const Parameter> there) {
    const std::string differ = differences(there, describe(input).parameters());
    if (!differ.empty()) {
      throw InputError{"option -restart_file: '" + input.restart.file + "' belongs to another case: " + differ};
    }
  };
  const io::PointOrder order{beam.comm(), node_range(beam)};
  MotionState state = io::read_checkpoint(order, input.restart.file, accept);
  dynamics.restore(state);
  return state;
}

io::Summary make_summary(const Case& input, FilteredStructure& line, const ImpactDynamics& dynamics,
                         const io::SupportForces& forces, const io::Peaks& peaks) {
  const BeamChain& beam = line.beam();
  const RunCounts& counts = dynamics.counts();
  int size = 1;
  MPI_Comm_size(beam.comm(), &size);
  io::Summary summary;
  summary.completed = dynamics.completed();
  summary.end_time = dynamics.time();
  summary.elements = beam.elements();
  summary.ranks = size;
  TSType type = nullptr;
  UDAR_CALL(TSGetType(dynamics.stepper(), &type));
  summary.integrator = type;
  summary.integrator_counts = dynamics.tally();
  summary.streamed_bytes = dynamics.streamed_bytes();  // of this rank
  summary.steps = counts.steps;
  summary.rejected_steps = counts.rejected_steps;
  summary.repeated_steps = counts.repeated_steps;
  summary.rhs_evaluations = counts.rhs_evaluations;
  summary.row_line_solves = counts.row_line_solves;
  summary.line_solves = line.solves();
  summary.event_steps = counts.event_steps;
  summary.impacts = counts.impacts;
  summary.rests = counts.rests;
  summary.releases = counts.releases;
  if (counts.first_contact_time >= 0.0) {
    summary.first_contact_time = counts.first_contact_time;
    summary.last_contact_time = counts.last_contact_time;
  }
  if (!input.supports.empty()) {
    const LineGap gap = dynamics.smallest_line_gap();
    summary.min_line_gap = gap.gap;
    summary.min_line_gap_x = gap.x;
    summary.min_line_gap_time = gap.time;
    summary.support_impulse = dynamics.support_impulses();
    summary.force_window = forces.window();
    summary.peak_force_window = forces.peak_window();
    summary.peak_support_force.assign(forces.peaks().begin(), forces.peaks().end());
  }
  for (const auto& [key, name] : {std::pair{"max_bending_stress", "stress"}, {"max_utilisation", "utilisation"}}) {
    const auto peak = peaks.find(name);
    summary.peaks.emplace_back(key, peak != peaks.end() ? std::optional{peak->second} : std::nullopt);
  }
  summary.energy_drift = dynamics.energy().drift();
  summary.gauge_position = input.gauges;
  for (const double gauge : input.gauges) {
    summary.gauge_node_position.push_back(beam.position(beam.nearest_node(gauge)));
  }
  summary.warnings = petsc::take_warnings();
  summary.versions = io::library_versions();
  return summary;
}

void warn_of_drift(MPI_Comm comm, double drift) {
  if (!(std::abs(drift) <= kWorthAWarning)) {
    petsc::warn(comm, "the energy balance is off by %.1e: do not trust these curves; lower -ts_rtol or -ts_dt", drift);
  }
}

void warn_of_yielding(MPI_Comm comm, const io::Peaks& peaks) {
  const auto used = peaks.find("utilisation");
  if (used != peaks.end() && used->second.value > 1.0) {
    petsc::warn(comm,
                "the bending stress reaches %.3g times the yield stress, at x = %g m, t = %g s; what follows is that "
                "of a beam that stays elastic",
                used->second.value, used->second.x, used->second.time);
  }
}

}  // namespace

RunResult run(MPI_Comm comm, const MakeListener& listener) {
  const CostMark begin = cost_mark();
  static_cast<void>(petsc::take_warnings());  // an earlier run's in this process
  const StopSignals signals;
  UDAR_CALL(PetscMemorySetGetMaximumUsage());
  register_types();
  petsc::check_petsc_options();
  const Case input = resolve(comm, read_case(comm));
  const bool help = petsc::Session::help_requested();
  std::vector<Mode> modes;
  Model model{comm, input, [&](FilteredStructure& line) {
                if (help) {
                  return;
                }
                modes = modes_to_show(input, line);
                for (const PetscInt number : correct_modes(line, input.exact)) {
                  if (number <= static_cast<PetscInt>(modes.size())) {
                    modes[static_cast<std::size_t>(number - 1)].corrected = true;
                  }
                }
              }};
  const BeamChain& beam = *model.structure->chain();
  FilteredStructure& line = model.line;
  ImpactDynamics dynamics{model};
  if (help) {
    return {};
  }
  petsc::check_unknown_options(comm);
  refuse_large_output(input);
  std::optional<MotionState> earlier;
  if (!input.restart.file.empty()) {
    earlier = restore(dynamics, input, beam);
  }
  io::prepare_run_directory(comm, input.output.directory, input.output.overwrite, input.restart.file);

  const SupportSprings springs = support_springs(line, input);
  if (input.view) {
    print_view(input, line, modes, springs);
  } else {
    print_echo(input, line, modes);
  }
  warn_of_implausible(input, beam);
  print_warnings(input, line, modes, springs);
  warn_of_places(input, beam);

  const double sampling = io::sampling_interval(input.output.interval, longest_sample(input));
  io::SupportForces forces{input.supports.size(), input.output.interval, input.output.force_window, sampling};
  io::Peaks peaks;
  std::vector<std::unique_ptr<Observer>> observers =
      io::make_run_writers(make_layout(input, line, dynamics.fields()), input.output.directory, input.output.interval,
                           input.output.field_interval, &forces, &peaks);
  const io::RunFiles files{comm, input.output.directory};
  auto writer = std::make_unique<CheckpointWriter>(dynamics, input, beam, observers);
  const CheckpointWriter& checkpoint = *writer;
  observers.push_back(std::move(writer));
  observers.push_back(std::make_unique<ProgressLine>(comm));
  for (const auto& observer : observers) {
    if (earlier) {
      observer->restore(*earlier);
    }
    dynamics.add_observer(*observer);
  }
  earlier.reset();
  if (listener) {
    dynamics.add_observer(listener(input, beam, line.mass()));
  }
  dynamics.set_stop_request([] { return StopSignals::received() != 0; });

  const CostMark stepping = cost_mark();
  const PetscInt solves_before = line.solves();
  RunResult result;
  const auto summarise = [&] {
    const CostMark end = cost_mark();
    warn_of_drift(comm, dynamics.energy().drift());
    if (dynamics.completed() && dynamics.counts().first_contact_time < 0.0) {
      warn_of_no_contact(input, beam);
    }
    io::Summary& summary = result.summary;
    warn_of_yielding(comm, peaks);
    summary = make_summary(input, line, dynamics, forces, peaks);
    summary.stepping_line_solves = line.solves() - solves_before;
    add_costs(comm, begin, stepping, end, summary);
    io::write_summary(comm, (std::filesystem::path{input.output.directory} / "summary.json").string(), summary);
  };
  try {
    dynamics.solve();
  } catch (const FileError&) {
    throw;  // what is on the disk stays as it is
  } catch (const std::exception&) {
    for (const auto& observer : observers) {  // the last good step is kept, and everything before it
      if (observer.get() != &checkpoint) {
        observer->finish();
      }
    }
    checkpoint.write();
    summarise();
    throw;
  }
  summarise();
  files.require_present();

  int signal_number = StopSignals::received();
  MPI_Allreduce(MPI_IN_PLACE, &signal_number, 1, MPI_INT, MPI_MAX, comm);
  const RunCounts& counts = dynamics.counts();
  UDAR_CALL(PetscPrintf(
      comm, "udar: %s at t = %g s after %lld steps, %lld impacts, %lld line solves, energy drift %.1e; results in %s\n",
      dynamics.completed() ? "finished" : "stopped", dynamics.time(), static_cast<long long>(counts.steps),
      static_cast<long long>(counts.impacts), static_cast<long long>(line.solves()), dynamics.energy().drift(),
      input.output.directory.c_str()));
  if (!dynamics.completed()) {
    UDAR_CALL(PetscPrintf(comm, "udar: continue with -restart_file %s/restart.h5 and another -output_directory\n",
                          input.output.directory.c_str()));
    constexpr int kStoppedBySteps = 3;
    result.exit_code = signal_number != 0 ? 128 + signal_number : kStoppedBySteps;
  }
  return result;
}

std::string failure_of(MPI_Comm comm, const std::function<void()>& body) {
  MPI_Comm watch = MPI_COMM_NULL;
  MPI_Comm_dup(comm, &watch);
  std::string failure;
  try {
    body();
  } catch (const std::exception& error) {
    failure = petsc::with_option_keys(error.what());
  }
  if (!failure.empty()) {
    // All ranks fail together, or this one is alone and the others wait for it in some collective: find out.
    using namespace std::chrono_literals;
    MPI_Request request = MPI_REQUEST_NULL;
    MPI_Ibarrier(watch, &request);
    int together = 0;
    for (int wait = 0; wait < 100 && together == 0; ++wait) {
      MPI_Test(&request, &together, MPI_STATUS_IGNORE);
      std::this_thread::sleep_for(together != 0 ? 0ms : 20ms);
    }
    if (together == 0) {
      int rank = 0;
      MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
      std::fprintf(stderr, "udar: error: %s (on rank %d alone)\n", failure.c_str(), rank);
      std::fflush(stderr);
      MPI_Abort(PETSC_COMM_WORLD, 1);
    }
  }
  MPI_Comm_free(&watch);
  return failure;
}

namespace {

void print_versions(MPI_Comm comm) {
  std::map<std::string, std::string> versions = io::library_versions();
  UDAR_CALL(PetscPrintf(comm, "udar %s\n", versions.extract("udar").mapped().c_str()));
  for (const auto& [library, version] : versions) {
    UDAR_CALL(PetscPrintf(comm, "  %-6s %s\n", library.c_str(), version.c_str()));
  }
}

}  // namespace

int guarded_main(int argc, char** argv, const char* help, int (*program)(MPI_Comm)) {
  int code = 0;
  std::signal(SIGPIPE, SIG_IGN);  // `udar -help | head` is no crash
  std::signal(SIGXFSZ, SIG_IGN);  // a file that grows beyond the limit is an error of the write, which names it
  io::start_hdf5();
  try {
    const petsc::Session session{argc, argv, help};
    if (session.version_requested()) {
      print_versions(PETSC_COMM_WORLD);
      return 0;
    }
    const std::string failure = failure_of(PETSC_COMM_WORLD, [&] {
      code = program(PETSC_COMM_WORLD);
      if (petsc::Session::help_found_nothing()) {
        throw InputError{"-help: no key of that topic; topics are words of keys, such as beam, filter, support, ts"};
      }
    });
    if (!failure.empty()) {
      code = 1;
      petsc::Session::forget_unused_options();
      if (petsc::Session::on_first_rank()) {
        std::fprintf(stderr, "udar: error: %s\n", failure.c_str());
        std::fflush(stderr);
      }
    }
  } catch (const std::exception& error) {  // an options file that cannot be used: the same on every rank
    if (petsc::Session::on_first_rank()) {
      std::fprintf(stderr, "udar: error: %s\n", petsc::with_option_keys(error.what()).c_str());
    }
    code = 1;
  }
  return code;
}

}  // namespace udar::app
