#include "app/run_report.hpp"

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <sstream>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "app/modal_estimate.hpp"
#include "app/run_page.hpp"
#include "udar/app/echo.hpp"
#include "udar/app/places.hpp"
#include "udar/io/versions.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/warnings.hpp"
#include "udar/structure/network.hpp"

namespace udar::app {
namespace {

// Masses that touch what is off, or is no longer there, by more than this share of the motion's scale are worth a
// warning.
constexpr double kShareOff = 1e-2;

double field_tolerance(const Case& input, const ImpactDynamics& dynamics) {
  return input.field_tolerance > 0.0 ? input.field_tolerance : kShareOff * dynamics.motion_length();
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

io::SummaryCounts counts_of(const RunCounts& counts) {
  return {.steps = counts.steps,
          .rejected_steps = counts.rejected_steps,
          .repeated_steps = counts.repeated_steps,
          .rhs_evaluations = counts.rhs_evaluations,
          .line_solves = counts.setup_line_solves + counts.line_solves,
          .stepping_line_solves = counts.line_solves,
          .row_line_solves = counts.row_line_solves,
          .event_steps = counts.event_steps,
          .impacts = counts.impacts,
          .rests = counts.rests,
          .releases = counts.releases};
}

/// @note Collective.
io::SummaryContact contact_of(const Case& input, const ImpactDynamics& dynamics, const RunOutput& output) {
  io::SummaryContact contact;
  if (dynamics.counts().first_contact_time >= 0.0) {
    contact.first_contact_time = dynamics.counts().first_contact_time;
    contact.last_contact_time = dynamics.counts().last_contact_time;
  }
  if (input.supports.empty()) {
    return contact;
  }
  const LineGap gap = dynamics.smallest_line_gap();
  contact.min_line_gap = gap.gap;
  contact.min_line_gap_x = gap.x;
  contact.min_line_gap_time = gap.time;
  contact.support_impulse = dynamics.support_impulses();
  const io::SupportForces& forces = output.forces();
  contact.force_window = forces.window();
  contact.peak_force_window = forces.peak_window();
  contact.peak_support_force.assign(forces.peaks().begin(), forces.peaks().end());
  for (const auto& [first, last] : output.support_contacts().times()) {
    contact.support_first_contact.push_back(first);
    contact.support_last_contact.push_back(last);
  }
  const Rebound rebound = output.body_motion().rebound();
  contact.impact_velocity = rebound.impact;
  contact.rebound_velocity = rebound.velocity;
  return contact;
}

/// By their keys in summary.json; stress and utilisation also where they are not known. @note Collective.
std::vector<std::pair<std::string, std::optional<io::Peak>>> peaks_of(const Structure& structure,
                                                                      const RunOutput& output) {
  std::vector<std::pair<std::string, std::optional<io::Peak>>> all;
  const auto add = [&](const std::string& key, const std::string& name) {
    const auto peak = output.peaks().find(name);
    all.emplace_back(key, peak != output.peaks().end() ? std::optional{peak->second} : std::nullopt);
  };
  add("max_bending_stress", "stress");
  add("max_utilisation", "utilisation");
  for (const auto& [name, peak] : output.peaks()) {
    if (name != "stress" && name != "utilisation") {
      all.emplace_back("max_" + name, peak);
    }
  }
  all.emplace_back(structure.grounded() ? "max_displacement" : "max_deflection", output.body_motion().deflection());
  return all;
}

/// The largest that is left.
std::optional<io::Peak> plastic_rotation(const HingedLine& hinges, const BeamChain& beam, double time) {
  std::optional<io::Peak> most;
  for (std::size_t i = 0; i < hinges.hinges().size(); ++i) {
    const double size = std::abs(hinges.rotations()[i]);
    if (!most || size > most->value) {
      most = {.value = size, .x = beam.position(hinges.hinges()[i].node), .time = time};
    }
  }
  return most;
}

}  // namespace

io::Summary gather_summary(const Case& input, FilteredStructure& line, const ImpactDynamics& dynamics,
                           const RunOutput& output) {
  const MassPoints& points = line.points();
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
  summary.counts = counts_of(dynamics.counts());
  summary.contact = contact_of(input, dynamics, output);
  summary.peaks = peaks_of(line.structure(), output);
  if (const HingedLine* hinges = dynamics.hinges(); hinges != nullptr && beam != nullptr) {
    summary.peaks.emplace_back("plastic_rotation", plastic_rotation(*hinges, *beam, dynamics.time()));
  }
  if (const FieldErrors* errors = output.field_errors(); errors != nullptr) {
    summary.peaks.emplace_back("height_field_error", errors->worst(field_tolerance(input, dynamics)).peak);
  }
  summary.energy = dynamics.energy();
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
  if (dynamics.hinges() == nullptr) {
    warn_of_yielding(comm, output.peaks());
  }
  if (const FieldErrors* errors = output.field_errors(); errors != nullptr) {
    warn_of_field(line.points(), *errors, field_tolerance(input, dynamics));
  }
  if (const EdgeErrors* errors = output.edge_errors(); errors != nullptr) {
    warn_of_edges(line.points(), *errors, kShareOff * dynamics.motion_length());
  }
  io::Summary summary = gather_summary(input, line, dynamics, output);
  for (const Mode& mode : marks.modes) {
    summary.mode_frequency.push_back(mode.frequency);
    if (input.filter.filtered() && !input.modal) {
      summary.mode_filtered.push_back(mode.corrected ? mode.frequency : mode.filtered);
    }
  }
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

void print_end(MPI_Comm comm, const Case& input, const Structure& structure, const io::Summary& summary) {
  if (input.output.page == PageForm::text) {
    UDAR_CALL(PetscPrintf(comm, "%s", run_page(input, structure, summary).c_str()));
  }
  UDAR_CALL(PetscPrintf(
      comm,
      "udar: %s at t = %.6g s after %lld steps, %lld impacts, %lld line solves, energy drift %.1e; results in %s\n",
      summary.completed ? "finished" : "stopped", summary.end_time, static_cast<long long>(summary.counts.steps),
      static_cast<long long>(summary.counts.impacts), static_cast<long long>(summary.counts.line_solves),
      summary.energy.drift(), input.output.directory.c_str()));
  print_estimate(comm, summary);
  if (!summary.completed) {
    UDAR_CALL(PetscPrintf(comm, "udar: %s\n", continue_with(input).c_str()));
  }
  if (int rank = 0; input.output.page == PageForm::json) {
    MPI_Comm_rank(comm, &rank);
    std::fputs(rank == 0 ? io::as_json(summary).c_str() : "", stdout);
    std::fflush(stdout);
  }
}

}  // namespace udar::app
