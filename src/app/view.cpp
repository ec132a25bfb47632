#include "udar/app/view.hpp"

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "udar/app/describe_case.hpp"
#include "udar/app/places.hpp"
#include "udar/petsc/error.hpp"
#include "udar/structure/describe.hpp"

namespace udar::app {
namespace {

/// Six digits, as people read them.
std::string rounded(double value) {
  std::string text(32, '\0');
  text.resize(static_cast<std::size_t>(std::snprintf(text.data(), text.size(), "%g", value)));
  return text;
}

std::string rounded(const std::vector<double>& values) {
  std::string text;
  for (const double value : values) {
    text.append(text.empty() ? "" : " ").append(rounded(value));
  }
  return text;
}

void print(MPI_Comm comm, const char* title, const Description& what) {
  constexpr std::size_t kColumn = 44;
  std::string text = std::string{title} + '\n';
  for (const auto& [name, value] : what.parameters()) {
    text.append("  ").append(name).append(std::max(name.size() + 1, kColumn) - name.size(), ' ').append(value);
    text += '\n';
  }
  UDAR_CALL(PetscPrintf(comm, "%s", text.c_str()));
}

void add_structure(Description& built, const FilteredStructure& line) {
  const BeamChain& beam = line.beam();
  int ranks = 1;
  MPI_Comm_size(beam.comm(), &ranks);
  built.add("length [m]", rounded(beam.length()));
  built.add("mass [kg]", rounded(beam.total_mass()));
  built.add("elements", static_cast<double>(beam.elements()));
  built.add("nodes", static_cast<double>(beam.nodes()));
  built.add("ranks", ranks);
}

void add_filter(Description& built, const FilteredStructure& line) {
  const BeamChain& beam = line.beam();
  const double wf = line.filter_frequency();
  if (line.parameters().unfiltered) {
    built.add("time step [s]", rounded(2.0 / wf));
  } else {
    const double decay = decay_length(beam, wf);
    built.add("decay length [m]", rounded(decay));
    built.add("decay length, elements", rounded(decay / beam.length() * static_cast<double>(beam.elements())));
    built.add("residual of the first solves", rounded(line.worst_residual()));
  }
  const std::string reason = line.chain() != nullptr ? "" : line.filter_operator().block_form_reason();
  built.add("line solver (details: -filter_ksp_view)",
            line.chain() != nullptr ? "chain recursion"
            : reason.empty()        ? "assembled block form, as asked for"
                                    : "assembled block form, because the chain recursion cannot carry it: " + reason);
}

/// @note Collective.
void add_supports(Description& built, const Case& input, const FilteredStructure& line, const SupportSprings& springs) {
  if (input.supports.empty()) {
    return;
  }
  const BeamChain& beam = line.beam();
  std::vector<double> first;
  std::vector<double> last;
  std::vector<double> stiffness;
  const double wf = line.filter_frequency();
  for (const Support& support : input.supports) {
    const auto [begin, end] = touched_nodes(beam, support);
    double mass = 0.0;
    for (PetscInt node = std::max(begin, beam.begin()); node <= std::min(end, beam.end() - 1); ++node) {
      mass += line.mass()[static_cast<std::size_t>(node - beam.begin())];
    }
    first.push_back(static_cast<double>(begin));
    last.push_back(static_cast<double>(end));
    stiffness.push_back(wf * wf * mass);
  }
  MPI_Allreduce(MPI_IN_PLACE, stiffness.data(), static_cast<int>(stiffness.size()), MPI_DOUBLE, MPI_SUM, beam.comm());
  built.add("supports, first node", first);
  built.add("supports, last node", last);
  built.add("supports, stiffness of filter springs [N/m]", rounded(stiffness));
  if (springs.stiffness > 0.0) {
    built.add("supports below, stiffness [N/m]", rounded(springs.stiffness));
    built.add("supports below, drop [m]", rounded(springs.drop));
    built.add("predicted sag of the line through them [m]", rounded(springs.predicted_sag));
  }
}

/// Where things that act at nodes are, and where they were asked for. @note Collective.
void add_places(Description& built, const Case& input, const BeamChain& beam) {
  for (const auto& [name, asked, used] : placed_at_nodes(input, beam)) {
    built.add(name + ", asked [m], node, its place [m]",
              rounded({asked, static_cast<double>(beam.nearest_node(asked)), used}));
  }
  for (std::size_t i = 0; i < input.loads.size(); ++i) {
    const auto [near, far] = beam.lever(input.loads[i].position);
    std::vector<double> shares;
    for (const auto& [node, share] : {near, far}) {
      if (share > 0.0) {
        shares.insert(shares.end(), {static_cast<double>(node), beam.position(node), share});
      }
    }
    built.add("load " + std::to_string(i) + ", nodes, places [m], shares", rounded(shares));
  }
}

void print_modes(MPI_Comm comm, const std::vector<Mode>& modes) {
  UDAR_CALL(PetscPrintf(comm, "  mode   w [rad/s]   filtered [rad/s]   error\n"));
  for (std::size_t i = 0; i < modes.size(); ++i) {
    UDAR_CALL(PetscPrintf(comm, "  %4zu %11.5g %18.5g %6.1f %%%s\n", i + 1, modes[i].frequency, modes[i].filtered,
                          100.0 * modes[i].distortion(), modes[i].corrected ? ", corrected to 0" : ""));
  }
}

}  // namespace

void print_view(const Case& input, const FilteredStructure& line, const std::vector<Mode>& modes,
                const SupportSprings& springs) {
  const BeamChain& beam = line.beam();
  print(beam.comm(), "case, as a restart compares it:", describe(input));
  Description built;
  add_structure(built, line);
  add_filter(built, line);
  add_supports(built, input, line, springs);
  add_places(built, input, beam);
  built.add("output", input.output.directory);
  built.add("interval of rows, of fields [s]", rounded({input.output.interval, input.output.field_interval}));
  print(beam.comm(), "as built:", built);
  print_modes(beam.comm(), modes);
}

}  // namespace udar::app
