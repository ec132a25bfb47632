#include "app/run_report.hpp"

#include <filesystem>
#include <optional>
#include <sstream>
#include <string>
#include <system_error>
#include <utility>

#include "app/modal_estimate.hpp"
#include "udar/app/echo.hpp"
#include "udar/app/places.hpp"
#include "udar/io/versions.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/warnings.hpp"
#include "udar/structure/network.hpp"

namespace udar::app {
namespace {

// A plane that is off its height field by more than this share of the motion's scale is worth a warning.
constexpr double kFieldShare = 1e-2;

double field_tolerance(const Case& input, const ImpactDynamics& dynamics) {
  return input.field_tolerance > 0.0 ? input.field_tolerance : kFieldShare * dynamics.motion_length();
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

io::Summary gather_summary(const Case& input, FilteredStructure& line, const ImpactDynamics& dynamics,
                           const RunOutput& output) {
  const io::SupportForces& forces = output.forces();
  const io::Peaks& peaks = output.peaks();
  const MassPoints& points = line.points();
  const RunCounts& counts = dynamics.counts();
  int size = 1;
  MPI_Comm_size(points.comm(), &size);
  io::Summary summary;
  summary.completed = dynamics.completed();
  summary.end_time = dynamics.time();
  const BeamChain* beam = line.structure().chain();
  const Network* network = line.structure().network();
  summary.elements = beam != nullptr      ? beam->elements()
                     : network != nullptr ? static_cast<PetscInt>(network->total_elements())
                                          : 0;
  summary.ranks = size;
  TSType type = nullptr;
  UDAR_CALL(TSGetType(dynamics.stepper(), &type));
  summary.integrator = type;
  summary.integrator_counts = dynamics.tally();
  summary.costs.streamed_bytes = dynamics.streamed_bytes();  // of this rank
  summary.counts.steps = counts.steps;
  summary.counts.rejected_steps = counts.rejected_steps;
  summary.counts.repeated_steps = counts.repeated_steps;
  summary.counts.rhs_evaluations = counts.rhs_evaluations;
  summary.counts.row_line_solves = counts.row_line_solves;
  summary.counts.line_solves = counts.setup_line_solves + counts.line_solves;
  summary.counts.stepping_line_solves = counts.line_solves;
  summary.counts.event_steps = counts.event_steps;
  summary.counts.impacts = counts.impacts;
  summary.counts.rests = counts.rests;
  summary.counts.releases = counts.releases;
  if (counts.first_contact_time >= 0.0) {
    summary.contact.first_contact_time = counts.first_contact_time;
    summary.contact.last_contact_time = counts.last_contact_time;
  }
  if (!input.supports.empty()) {
    const LineGap gap = dynamics.smallest_line_gap();
    summary.contact.min_line_gap = gap.gap;
    summary.contact.min_line_gap_x = gap.x;
    summary.contact.min_line_gap_time = gap.time;
    summary.contact.support_impulse = dynamics.support_impulses();
    summary.contact.force_window = forces.window();
    summary.contact.peak_force_window = forces.peak_window();
    summary.contact.peak_support_force.assign(forces.peaks().begin(), forces.peaks().end());
  }
  for (const auto& [key, name] : {std::pair{"max_bending_stress", "stress"}, {"max_utilisation", "utilisation"}}) {
    const auto peak = peaks.find(name);
    summary.peaks.emplace_back(key, peak != peaks.end() ? std::optional{peak->second} : std::nullopt);
  }
  if (const FieldErrors* errors = output.field_errors(); errors != nullptr) {
    summary.peaks.emplace_back("height_field_error", errors->worst(field_tolerance(input, dynamics)).peak);
  }
  summary.energy_drift = dynamics.energy().drift();
  for (const Place& gauge : input.gauges) {
    summary.gauge_position.push_back(gauge.x);
    summary.gauge_node_position.push_back(place_of(points, points.nearest(gauge)).x);
  }
  summary.warnings = petsc::take_warnings();
  summary.versions = io::library_versions();
  return summary;
}

io::Summary summarise(const Case& input, FilteredStructure& line, const ImpactDynamics& dynamics,
                      const RunOutput& output, const RunMarks& marks) {
  const MPI_Comm comm = line.points().comm();
  const CostMark end = cost_mark();
  if (dynamics.completed() && dynamics.counts().first_contact_time < 0.0) {
    warn_of_no_contact(input, line.structure());
  }
  warn_of_yielding(comm, output.peaks());
  if (const FieldErrors* errors = output.field_errors(); errors != nullptr) {
    warn_of_field(line.points(), *errors, field_tolerance(input, dynamics));
  }
  io::Summary summary = gather_summary(input, line, dynamics, output);
  add_costs(comm, marks.begin, marks.stepping, end, summary);
  write(comm, input, summary);
  return summary;
}

void write(MPI_Comm comm, const Case& input, const io::Summary& summary) {
  io::write_summary(comm, (std::filesystem::path{input.output.directory} / "summary.json").string(), summary);
}

std::string continue_with(const Case& input) { return "go on with udar -continue " + input.output.directory; }

std::string how_to_go_on(const Case& input, double time, bool kept) {
  std::ostringstream text;
  if (kept) {
    text << "; the last good step, at t = " << time << " s, is kept: ";
  } else {
    std::error_code unknown;
    text << "; the run had come to t = " << time << " s";
    if (!std::filesystem::exists(std::filesystem::path{input.output.directory} / "restart.h5", unknown)) {
      text << ", without a checkpoint to go on from (see -restart_wall_minutes)";
      return text.str();
    }
    text << ", its last checkpoint is kept: ";
  }
  text << continue_with(input);
  return text.str();
}

void print_end(MPI_Comm comm, const Case& input, const io::Summary& summary) {
  UDAR_CALL(PetscPrintf(
      comm, "udar: %s at t = %g s after %lld steps, %lld impacts, %lld line solves, energy drift %.1e; results in %s\n",
      summary.completed ? "finished" : "stopped", summary.end_time, static_cast<long long>(summary.counts.steps),
      static_cast<long long>(summary.counts.impacts), static_cast<long long>(summary.counts.line_solves),
      summary.energy_drift, input.output.directory.c_str()));
  print_estimate(comm, summary);
  if (!summary.completed) {
    UDAR_CALL(PetscPrintf(comm, "udar: %s\n", continue_with(input).c_str()));
  }
}

}  // namespace udar::app
