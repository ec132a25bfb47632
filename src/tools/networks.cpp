#include "tools/networks.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tools/timing.hpp"
#include "udar/filter/filtered_structure.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/scoped_options.hpp"
#include "udar/structure/member_shape.hpp"

namespace udar::bench {
namespace {

constexpr std::size_t kColumns = 4;

struct NetShape {
  Regular kind;
  const char* name;
  std::array<std::size_t, 3> junctions;
};
constexpr std::array kStructures{NetShape{Regular::beam, "beam", {2, 1, 1}},
                                 NetShape{Regular::grillage_10, "grillage 10 x 10", {10, 1, 10}},
                                 NetShape{Regular::grillage_30, "grillage 30 x 30", {30, 1, 30}},
                                 NetShape{Regular::lattice_8, "lattice 8 x 8 x 8", {8, 8, 8}}};

/// Steel, rectangles of 0.1 by 0.05 m.
NetworkParameters network_of(const NetShape& kind, std::size_t elements, const NetworkBench& bench,
                             double grading = 1.0) {
  MemberSection section{.name = "bar", .youngs_modulus = 2.1e11, .shear_modulus = 8.1e10, .density = 7850.0};
  give_shape(section, {.kind = MemberShape::Kind::rectangle, .width = 0.05, .height = 0.1}, false);
  const double length = bench.member_length;
  NetworkParameters network = regular_network({.junctions = kind.junctions,
                                               .spacing = {length, length, length},
                                               .elements = elements,
                                               .grading = grading,
                                               .section = section});
  network.partition = bench.partition;
  return network;
}

/// Smooth, of half a millimetre.
std::vector<double> motion_of(const MassPoints& points) {
  std::vector<double> motion;
  for (std::size_t i = 0; i < points.points(); ++i) {
    const Place at = points.place(i);
    const auto phase = static_cast<double>(points.direction(i));
    motion.push_back(5e-4 * std::sin(1.3 * at.x + 0.7 * at.y + 2.0 * at.z + phase));
  }
  return motion;
}

/// A network under solver options that do not outlive the building, and what it is asked.
class Solved {
 public:
  Solved(MPI_Comm comm, const NetworkParameters& parameters, double filter_frequency, const petsc::Options& options)
      : network_{comm, parameters} {
    const petsc::ScopedOptions scoped{options};
    line_ = std::make_unique<FilteredStructure>(
        network_, FilterParameters{.filter_frequency = filter_frequency, .check_interval = 0});
    motion_ = motion_of(network_.points());
    stretch_.assign(kColumns, std::vector<double>(motion_.size()));
    for (std::vector<double>& stretch : stretch_) {
      columns_.push_back({.displacement = motion_.data(), .stretch = stretch.data()});
    }
  }

  [[nodiscard]] const Network& network() const noexcept { return network_; }
  [[nodiscard]] const FilteredStructure& line() const noexcept { return *line_; }
  [[nodiscard]] Timed solving(std::size_t columns) {
    return {.body = [this, columns] { line_->solve({columns_.data(), columns}); }};
  }

 private:
  Network network_;
  std::unique_ptr<FilteredStructure> line_;
  std::vector<double> motion_;
  std::vector<std::vector<double>> stretch_;
  std::vector<FilterColumn> columns_;
};

/// How much longer than the members another solver takes, in turn.
nlohmann::ordered_json beside(MPI_Comm comm, Solved& members, Solved& other, long repeats) {
  nlohmann::ordered_json ratios;
  for (const std::size_t columns : {std::size_t{1}, kColumns}) {
    Timed own = members.solving(columns);
    Timed its = other.solving(columns);
    sample(comm, {&own, &its}, repeats);
    ratios[columns == 1 ? "one_column" : "four_columns"] = its.best() / own.best();
  }
  return ratios;
}

nlohmann::ordered_json measured_network(MPI_Comm comm, const NetShape& kind, std::size_t elements,
                                        const NetworkBench& bench) {
  const double filter_frequency = bench.filter_frequency;
  const long repeats = bench.repeats;
  int rank = 0;
  int ranks = 1;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &ranks);
  const NetworkParameters parameters = network_of(kind, elements, bench);
  const double begin = MPI_Wtime();
  Solved members{comm, parameters, filter_frequency, {}};
  nlohmann::ordered_json entry{{"structure", kind.name}, {"elements", elements}};
  const auto nodes = static_cast<double>(members.network().total_nodes());
  entry["nodes"] = members.network().total_nodes();
  entry["junctions"] = parameters.junctions.size();
  entry["setup_seconds"] = MPI_Wtime() - begin;
  const NetworkSolver::Report& report = members.line().network()->report();
  entry["interface_junctions"] = report.interface;
  auto most = static_cast<double>(members.network().nodes());
  MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_DOUBLE, MPI_MAX, comm);
  entry["most_nodes_over_mean"] = most * ranks / nodes;
  entry["spans_first_rank"] = report.members.spans;
  entry["table_bytes_first_rank"] = report.members.table_bytes;
  entry["factor_bytes_first_rank"] = report.factor_bytes;
  Timed one = members.solving(1);
  Timed four = members.solving(kColumns);
  sample(comm, {&one, &four}, repeats);
  entry["nanoseconds_per_node"] = one.best() * 1e9 / nodes;
  entry["nanoseconds_per_node_of_four"] = four.best() * 1e9 / nodes / static_cast<double>(kColumns);
  if (bench.grading != 1.0) {
    Solved graded{comm, network_of(kind, elements, bench, bench.grading), filter_frequency, {}};
    entry["graded_over_equal"] = beside(comm, members, graded, repeats);
  }
  if (bench.rotary_inertia) {
    NetworkParameters turning = parameters;
    turning.rotary_inertia = true;
    Solved rotary{comm, turning, filter_frequency, {}};
    entry["rotary_over_plain"] = beside(comm, members, rotary, repeats);
    entry["rotary_table_bytes_first_rank"] = rotary.line().network()->report().members.table_bytes;
  }
  if (nodes <= static_cast<double>(bench.most)) {
    if (ranks == 1) {
      Solved cholmod{comm, parameters, filter_frequency, {{"-filter_pc_type", "cholesky"}}};
      entry["cholmod_over_members"] = beside(comm, members, cholmod, std::min(repeats, 10L));
    }
    Solved mumps{comm,
                 parameters,
                 filter_frequency,
                 {{"-filter_pc_type", "cholesky"}, {"-filter_pc_factor_mat_solver_type", "mumps"}}};
    entry["mumps_over_members"] = beside(comm, members, mumps, std::min(repeats, 5L));
  }
  if (ranks > 1) {
    std::optional<Solved> alone;
    if (rank == 0) {
      alone.emplace(PETSC_COMM_SELF, parameters, filter_frequency, petsc::Options{});
    }
    Timed all = members.solving(1);
    Timed single = rank == 0 ? alone->solving(1) : Timed{.body = [] {}};
    sample(comm, {&all, &single}, repeats);
    entry["one_rank_over_these"] = single.best() / all.best();
  }
  return entry;
}

}  // namespace

void networks(MPI_Comm comm, const NetworkBench& bench) {
  nlohmann::ordered_json result;
  for (const Regular kind : bench.structures) {
    for (const std::size_t elements : bench.elements) {
      result.push_back(measured_network(comm, *std::ranges::find(kStructures, kind, &NetShape::kind), elements, bench));
    }
  }
  UDAR_CALL(PetscPrintf(comm, "%s\n", result.dump(2).c_str()));
}

}  // namespace udar::bench
