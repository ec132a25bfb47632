#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <limits>
#include <string>
#include <vector>

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

enum class ListChoice : std::uint8_t { raw, merged, both, none };

constexpr std::array kListChoices{
    Names<ListChoice>{"raw", ListChoice::raw}, Names<ListChoice>{"merged", ListChoice::merged},
    Names<ListChoice>{"both", ListChoice::both}, Names<ListChoice>{"none", ListChoice::none}};

io::ImpactLists read_lists(OptionGroup& group) {
  ListChoice choice = ListChoice::raw;
  io::ImpactLists lists;
  group.choice<ListChoice>("-output_contacts", choice, kListChoices,
                           "lists of impacts: each by itself, those of a node and support within "
                           "-output_contact_window as one, both, or none, and no rests either");
  const bool given = group.real("-output_contact_window", lists.window, "s", petsc::positive(),
                                "impacts of a node on a support that come less than this after the first of them are "
                                "merged");
  lists.raw = choice == ListChoice::raw || choice == ListChoice::both;
  lists.rests = choice != ListChoice::none;
  lists.merged = choice == ListChoice::merged || choice == ListChoice::both;
  if (lists.merged != given) {
    throw InputError{lists.merged ? "option -output_contact_window is needed by -output_contacts: a time > 0 [s]"
                                  : "option -output_contact_window has nothing to merge: -output_contacts is neither "
                                    "merged nor both"};
  }
  return lists;
}

void read_rows(OptionGroup& group, OutputParameters& output) {
  std::vector<double> region;
  group.reals("-output_region", region, "m", petsc::any(),
              "nodes and elements that files have rows for: those between from,to along x, or from and to along x, y "
              "and z, two, four or six numbers; of others there are neither fields nor envelopes, impacts and rests");
  group.strings("-output_members", output.members,
                "for networks: files have rows for these members alone, by name, or that of their group");
  group.integer("-output_stride", output.rows.stride, petsc::at_least(1),
                "fields and envelopes of each so many nodes along a beam or member one, and the last");
  if (region.size() % 2 != 0 || region.size() > 6) {
    throw InputError{"option -output_region: " + std::to_string(region.size()) +
                     " values given, expected 2, 4 or 6 [m]"};
  }
  region.resize(6, std::numeric_limits<double>::infinity());
  output.rows.everywhere = !std::isfinite(region[0]);
  for (const std::size_t axis : {0U, 2U, 4U}) {
    if (!std::isfinite(region[axis])) {
      region[axis] = -Region::kEnd;
    } else if (region[axis] >= region[axis + 1]) {
      throw InputError{"option -output_region: from must be below to along each axis [m]"};
    }
  }
  output.rows.region = {.from = {.x = region[0], .y = region[2], .z = region[4]},
                        .to = {.x = region[1], .y = region[3], .z = region[5]}};
}

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
  group.strings("-output_fields", input.output.content.fields,
                "fields that are written, by their names in results.h5 (docs/output.md); all");
  PetscInt compression = input.output.content.compression;
  group.integer("-output_compression", compression, petsc::between(0, 9),
                "gzip level of fields and lists of events in results.h5, from 1, fast, to 9; 0: as they are. Rows of "
                "fields below 4 KiB stay as they are");
  input.output.content.compression = static_cast<int>(compression);
  input.output.content.impacts = read_lists(group);
  read_rows(group, input.output);
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
