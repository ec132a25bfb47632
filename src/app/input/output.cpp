#include <algorithm>
#include <array>
#include <iterator>

#include "app/input/readers.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/options.hpp"

namespace udar::app {

using petsc::OptionGroup;

namespace {

constexpr std::array kGuardModes{Names<GuardMode>{"warn", GuardMode::warn}, Names<GuardMode>{"stop", GuardMode::stop}};

constexpr std::array kPageForms{Names<PageForm>{"text", PageForm::text}, Names<PageForm>{"json", PageForm::json},
                                Names<PageForm>{"none", PageForm::none}};

constexpr PlaceKeys kGauges{
    .position = {"-gauge_position", "where gauges read, x: the nearest node"},
    .place = {"-gauge_place",
              "for a structure in space: where more gauges read, x,y,z of the first, then of the second, ...: the "
              "nearest node"},
    .junction = {"-gauge_junction", "for a network: where more gauges read, names of junctions"},
    .thing = "gauge"};

}  // namespace

OutputInput read_output(MPI_Comm comm, const StructureInput& structure) {
  OutputInput input;
  OptionGroup group{comm, "Output and restart"};
  input.gauges = read_places(group, kGauges, structure);
  group.string("-output_directory", input.output.directory, "folder for everything a run writes");
  group.boolean("-output_overwrite", input.output.overwrite, "replace the run that is there");
  group.real("-output_interval", input.output.interval, "s", petsc::positive(),
             "simulated time between rows of gauges.csv, energy.csv and contact.csv; peak forces and envelope.csv are "
             "sampled every pi / (4 wf) at least");
  group.real("-output_field_interval", input.output.field_interval, "s", petsc::non_negative(),
             "simulated time between fields in results.h5; 0: none");
  group.boolean("-output_allow_large", input.output.allow_large,
                "write more than 1e6 rows or 10 GB, which is refused else: as a rule an interval is in the wrong unit");
  group.real("-output_monitor", input.output.monitor_interval, "s", petsc::non_negative(),
             "simulated time between rows of a table on the terminal: energies, impulse of all supports, drift; 0: "
             "none");
  group.real("-output_force_window", input.output.force_window, "s", petsc::non_negative(),
             "forces of supports in contact.csv are means over this time, rounded up to rows; with impacts at least pi "
             "/ wf; 0: "
             "that");
  group.string("-restart_file", input.restart.file, "continue from this restart.h5");
  group.real("-restart_interval", input.restart.interval, "s", petsc::non_negative(),
             "simulated time between restart files; 0: by the clock alone, and when the run ends or is stopped");
  group.real("-restart_wall_minutes", input.restart.wall_minutes, "min", petsc::non_negative(),
             "wall time between restart files; 0: none by the clock");
  group.real("-wall_limit", input.wall_limit, "s", petsc::non_negative_or_infinite(),
             "wall time after which the run ends in order, to be continued; 0: none");
  group.choice<GuardMode>(
      "-udar_guard", input.guard, kGuardModes,
      "what becomes of a run whose energy balance is off, whose masses are below a support, or whose "
      "impacts give energy: a warning, once, or its end");
  group.choice<PageForm>("-udar_summary", input.output.page, kPageForms,
                         "the end of a run on the terminal: a page of supports, largest values and energies, the "
                         "content of summary.json and nothing else, or one line");
  group.boolean("-udar_view", input.view, "print case, sizes, frequencies and supports before the run");
  return input;
}

}  // namespace udar::app
