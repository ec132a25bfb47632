#include "udar/app/view.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "udar/app/describe_case.hpp"
#include "udar/app/network_size.hpp"
#include "udar/app/places.hpp"
#include "udar/filter/filter_cost.hpp"
#include "udar/io/file_rows.hpp"
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

/// Without what strikes it.
const MassPoints& own_points(const FilteredStructure& line) { return line.structure().elastic().points(); }

void add_structure(Description& built, const FilteredStructure& line) {
  const MassPoints& points = own_points(line);
  int ranks = 1;
  MPI_Comm_size(points.comm(), &ranks);
  built.add("length [m]", rounded(points.extent().length()));
  built.add("mass [kg]", rounded(points.total_mass()));
  if (const BeamChain* beam = line.structure().chain(); beam != nullptr) {
    built.add("elements", static_cast<double>(beam->elements()));
    std::vector<double> modulus;
    std::vector<double> yields;
    for (const BeamSegment& segment : beam->parameters().segments) {
      modulus.push_back(segment.section_modulus);
      yields.push_back(segment.yield_stress);
    }
    built.add("section moduli I/c [m^3], 0: not known", rounded(modulus));
    built.add("yield stress [Pa], 0: not known", rounded(yields));
    if (beam->parameters().yields()) {
      built.add("plastic hinges", static_cast<double>(beam->plastic_hinges().size()));
    }
  } else if (const Network* network = line.structure().network(); network != nullptr) {
    const NetworkSize size = size_of(*network);
    built.add("extent", size.extent);
    built.add("junctions, members, elements",
              rounded({static_cast<double>(size.junctions), static_cast<double>(size.members),
                       static_cast<double>(size.elements)}));
    built.add("members of unequal elements", static_cast<double>(size.unequal));
    built.add("shortest element [m]", rounded(size.shortest));
    built.add("connected parts", static_cast<double>(network->connected_parts()));
    for (const std::string& note : network->notes()) {
      built.add("note", note);
    }
  }
  if (const Network* network = line.structure().network(); network != nullptr) {
    const double moving = 3.0 * static_cast<double>(network->total_nodes());
    built.add("masses, three of a node", moving);
    if (network->rotary()) {
      built.add("rotary inertia, nodes' axes about which they have it", static_cast<double>(points.total()) - moving);
    }
  } else {
    built.add("nodes", static_cast<double>(points.total()));
  }
  built.add("ranks", ranks);
}

/// How a network is dealt to the ranks. @note Collective.
void add_dealing(Description& built, const Network& network, const NetworkSolver& solver) {
  std::array<double, 2> nodes{static_cast<double>(network.nodes()), static_cast<double>(network.nodes())};
  MPI_Allreduce(MPI_IN_PLACE, nodes.data(), 1, MPI_DOUBLE, MPI_MAX, network.comm());
  MPI_Allreduce(MPI_IN_PLACE, &nodes[1], 1, MPI_DOUBLE, MPI_SUM, network.comm());
  int ranks = 1;
  MPI_Comm_size(network.comm(), &ranks);
  std::size_t cut = 0;
  for (const Member& member : network.parameters().members) {
    const std::vector<int>& owner = network.junction_ranks();
    cut += owner[member.ends[0].junction] != owner[member.ends[1].junction] ? 1 : 0;
  }
  built.add("nodes of a rank, most over mean", rounded(nodes[0] / nodes[1] * ranks));
  built.add("members between ranks, junctions between ranks",
            rounded({static_cast<double>(cut), static_cast<double>(solver.report().interface)}));
}

/// How far forces reach on filter springs, and how well the junctions of a network are conditioned there.
void add_condensation(Description& built, const Network& network, double filter_frequency) {
  std::array<double, 2> decay{};  // longest: bending, axial
  double condition = 1.0;
  for (const MemberKind& kind : network.kinds()) {
    const MemberSection& section = network.parameters().sections[kind.section];
    const double length = kind.element_length * static_cast<double>(kind.elements);
    const double ground = section.mass_per_length() * filter_frequency * filter_frequency;  // of the filter [N/m^2]
    const double bend = std::pow(4.0 * std::max(section.bending(0), section.bending(1)) / ground, 0.25);
    const double axial = std::sqrt(section.axial() / ground);
    decay = {std::max(decay[0], bend), std::max(decay[1], axial)};
    condition = std::max(condition, 1.0 + 4.0 * std::pow(axial / length, 2) + 12.0 * std::pow(bend / length, 4));
  }
  built.add("decay length of bending, of axial forces, longest [m]", rounded({decay[0], decay[1]}));
  built.add("condition of the junctions, bound", rounded(condition));
}

/// What matrices cost, and whether the filter pays. @note Collective; a second of solves.
void add_cost(Description& built, FilteredStructure& line) {
  PetscInt unknowns = 0;
  UDAR_CALL(MatGetSize(line.op(), &unknowns, nullptr));
  const FilterCost cost = measure_cost(line);
  const double ratio = cost.highest_frequency / line.filter_frequency();
  built.add("unknowns", static_cast<double>(unknowns));
  if (cost.factor_nonzeros > 0.0) {
    built.add("nonzeros of the factor, of an unknown",
              rounded({cost.factor_nonzeros, cost.factor_nonzeros / static_cast<double>(unknowns)}));
  }
  built.add("a solve, of four together [s]", rounded({cost.solve_time, cost.batch_time}));
  built.add("a product with the stiffness [s]", rounded(cost.product_time));
  built.add("a solve, products", rounded(cost.solve_time / cost.product_time));
  built.add("highest frequency of the mesh [rad/s], wf", rounded({cost.highest_frequency, ratio}));
  for (const auto& [type, solves] : {std::pair{"impact", FilterCost::kImpactSolves},
                                     std::pair{"chebyshev, between few impacts", FilterCost::kChebyshevSolves}}) {
    const double least = cost.break_even(solves);
    built.add(std::string{"the filter with "} + type, std::string{ratio > least ? "pays" : "does not pay"} +
                                                          ": above " + rounded(least) + " wf, gains " +
                                                          rounded(ratio / least) + " times");
  }
}

void add_filter(Description& built, const FilteredStructure& line, bool modal) {
  const BeamChain* beam = line.structure().chain();
  const double wf = line.filter_frequency();
  if (modal) {
    built.add("filter", "none, modes alone");
  } else if (!line.parameters().filtered()) {
    built.add("time step [s]", rounded(2.0 / wf));
  } else {
    if (beam != nullptr) {
      const double decay = decay_length(*beam, wf);
      built.add("decay length [m]", rounded(decay));
      built.add("decay length, elements", rounded(decay / beam->length() * static_cast<double>(beam->elements())));
    }
    built.add("residual of the first solves", rounded(line.worst_residual()));
  }
  if (line.network() != nullptr) {
    add_dealing(built, *line.structure().network(), *line.network());
    if (line.parameters().filtered()) {
      add_condensation(built, *line.structure().network(), wf);
    }
  }
  const std::string reason = line.chain() != nullptr ? "" : line.filter_operator().block_form_reason();
  built.add("line solver (details: -filter_ksp_view)",
            line.chain() != nullptr     ? "chain recursion"
            : line.network() != nullptr ? "members condensed to junctions"
            : beam == nullptr           ? "assembled matrix"
            : reason.empty()            ? "assembled block form, as asked for"
                             : "assembled block form, because the chain recursion cannot carry it: " + reason);
}

/// Which nodes some things touch. @note Collective.
void add_touched(Description& built, const std::string& things, const MassPoints& points,
                 const std::vector<PointRows>& touched, double wf, bool side_by_side) {
  std::vector<double> count;
  std::vector<double> ends;  // the last node, and the first below zero: one reduction finds both
  std::vector<double> stiffness;
  for (const PointRows& nodes : touched) {
    const double none = -std::numeric_limits<double>::infinity();
    const bool here = !nodes.rows.empty();
    ends.push_back(here ? static_cast<double>(points.begin()) + static_cast<double>(nodes.rows.back().last) - 1.0
                        : none);
    ends.push_back(here ? -static_cast<double>(points.begin()) - static_cast<double>(nodes.rows.front().first) : none);
    count.push_back(static_cast<double>(nodes.count));
    stiffness.push_back(wf * wf * nodes.mass);
  }
  MPI_Allreduce(MPI_IN_PLACE, ends.data(), static_cast<int>(ends.size()), MPI_DOUBLE, MPI_MAX, points.comm());
  std::vector<double> first;
  std::vector<double> last;
  for (std::size_t i = 0; i < ends.size(); i += 2) {
    last.push_back(ends[i]);
    first.push_back(-ends[i + 1]);
  }
  built.add(things + ", nodes", count);
  if (side_by_side) {
    built.add(things + ", first node", first);
    built.add(things + ", last node", last);
  }
  built.add(things + ", stiffness of filter springs [N/m]", rounded(stiffness));
}

/// @note Collective.
void add_supports(Description& built, const Case& input, const FilteredStructure& line, const SupportSprings& springs) {
  const MassPoints& points = own_points(line);
  std::vector<PointRows> supports;
  std::vector<PointRows> strikers;
  for (const Support& support : input.supports) {
    if (support.strike < 0) {
      supports.push_back(touched_points(points, support));
    } else if (const auto striker = input.striker_of(support)) {
      strikers.push_back(points.single(points.nearest(input.strikers[*striker].place)));
    }
  }
  const bool side_by_side = line.structure().network() == nullptr;  // nodes of a support
  if (!supports.empty()) {
    add_touched(built, "supports", points, supports, line.filter_frequency(), side_by_side);
  }
  if (!strikers.empty()) {
    add_touched(built, "strikers", points, strikers, line.filter_frequency(), side_by_side);
  }
  if (springs.stiffness > 0.0) {
    built.add("supports below, stiffness [N/m]", rounded(springs.stiffness));
    built.add("supports below, drop [m]", rounded(springs.drop));
    built.add("predicted sag of the line through them [m]", rounded(springs.predicted_sag));
  }
}

/// The number of a node in the files of results. @note Collective.
double number_of(const MassPoints& points, const io::FileRows& rows, PetscInt point) {
  double number =
      points.owns(point) ? static_cast<double>(rows.number(static_cast<std::size_t>(point - points.begin()))) : 0.0;
  MPI_Allreduce(MPI_IN_PLACE, &number, 1, MPI_DOUBLE, MPI_SUM, points.comm());
  return number;
}

/// Where things that act at nodes are, and where they were asked for. @note Collective.
void add_places(Description& built, const Case& input, const Structure& structure) {
  const MassPoints& points = structure.points();
  const io::FileRows rows{points, structure.topology()};
  for (const auto& [name, asked, used, in_space, point] : placed_at_nodes(input, points)) {
    const PetscInt at = point >= 0 ? point : points.nearest(asked);
    std::vector<double> values = in_space ? std::vector{asked.x, asked.y, asked.z} : std::vector{asked.x};
    values.push_back(number_of(points, rows, at));
    values.insert(values.end(), {used.x, used.y, used.z});
    values.resize(in_space ? values.size() : 3);
    built.add(name + ", asked [m], node, its place [m]", rounded(values));
  }
  for (std::size_t i = 0; i < input.loads.size() && structure.chain() != nullptr; ++i) {
    if (input.loads[i].width != 0.0) {
      continue;  // on many
    }
    std::vector<double> shares;
    for (const auto& [node, share] : dealt(points, input.loads[i])) {
      shares.insert(shares.end(), {static_cast<double>(node), place_of(points, node).x, share});
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

void print_view(const Case& input, FilteredStructure& line, const std::vector<Mode>& modes,
                const SupportSprings& springs) {
  const MPI_Comm comm = line.points().comm();
  print(comm, "case, as a restart compares it:", describe(input, line.structure()));
  Description built;
  add_structure(built, line);
  add_filter(built, line, input.modal);
  if (line.structure().chain() == nullptr && !input.modal) {
    add_cost(built, line);
  }
  add_supports(built, input, line, springs);
  add_places(built, input, line.structure());
  built.add("initial velocity [m/s], of turning [rad/s]",
            rounded({input.initial.velocity, input.initial.angular_velocity}));
  built.add("output", input.output.directory);
  built.add("interval of rows, of fields [s]", rounded({input.output.interval, input.output.field_interval}));
  print(comm, "as built:", built);
  print_modes(comm, modes);
}

}  // namespace udar::app
