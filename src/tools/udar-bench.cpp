/// @file
/// Measurements of udar's parts; every table in docs/performance.md names the call that printed it.

#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "tools/batch.hpp"
#include "tools/contact_table.hpp"
#include "tools/integrators.hpp"
#include "tools/laws.hpp"
#include "tools/machine.hpp"
#include "tools/networks.hpp"
#include "tools/output.hpp"
#include "tools/quad_line.hpp"
#include "tools/timing.hpp"
#include "udar/app/case.hpp"
#include "udar/app/filter_choice.hpp"
#include "udar/app/program.hpp"
#include "udar/app/run.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/options.hpp"
#include "udar/petsc/session.hpp"

namespace {

using namespace udar;
using bench::sample;
using bench::Timed;
using bench::Triad;
using Numbers = std::vector<double>;
using Options = std::vector<std::pair<std::string, std::string>>;

enum class Kind { solve, accuracy, integrators, machine, batch, contact, laws, network, output };
constexpr std::array kKinds{std::pair<const char*, Kind>{"solve", Kind::solve},
                            std::pair<const char*, Kind>{"accuracy", Kind::accuracy},
                            std::pair<const char*, Kind>{"integrators", Kind::integrators},
                            std::pair<const char*, Kind>{"machine", Kind::machine},
                            std::pair<const char*, Kind>{"batch", Kind::batch},
                            std::pair<const char*, Kind>{"contact", Kind::contact},
                            std::pair<const char*, Kind>{"laws", Kind::laws},
                            std::pair<const char*, Kind>{"network", Kind::network},
                            std::pair<const char*, Kind>{"output", Kind::output}};

constexpr std::array kNetworks{std::pair<const char*, bench::Regular>{"beam", bench::Regular::beam},
                               std::pair<const char*, bench::Regular>{"grillage-10", bench::Regular::grillage_10},
                               std::pair<const char*, bench::Regular>{"grillage-30", bench::Regular::grillage_30},
                               std::pair<const char*, bench::Regular>{"lattice-8", bench::Regular::lattice_8}};

constexpr std::array kPartitions{std::pair<const char*, NetworkPartition>{"metis", NetworkPartition::metis},
                                 std::pair<const char*, NetworkPartition>{"contiguous", NetworkPartition::contiguous}};

/// A way to solve the line: its name, its formulation and its solver options.
struct Form {
  std::string name;
  Formulation formulation = Formulation::mixed;
  Options options{};
  PetscInt most_elements = 1'000'000'000;  // beyond, a solve takes too long to be worth a line in the table
};

enum class Rival { none, block_lu, repeated_lu, mumps, superlu_dist };
constexpr std::array kRivals{std::pair<const char*, Rival>{"none", Rival::none},
                             std::pair<const char*, Rival>{"block-lu", Rival::block_lu},
                             std::pair<const char*, Rival>{"repeated-lu", Rival::repeated_lu},
                             std::pair<const char*, Rival>{"mumps", Rival::mumps},
                             std::pair<const char*, Rival>{"superlu_dist", Rival::superlu_dist}};

/// PETSc's direct solvers, each with one step of refinement.
Form rival_form(Rival rival) {
  const Options lu{{"-filter_pc_type", "lu"}, {"-filter_pc_factor_mat_ordering_type", "natural"}};
  switch (rival) {
    case Rival::none:
      return {};
    case Rival::block_lu:
      return {.name = "block-lu", .options = lu};
    case Rival::repeated_lu:
      return {.name = "repeated-lu",
              .options = {{"-filter_pc_type", "redundant"},
                          {"-filter_redundant_pc_type", "lu"},
                          {"-filter_redundant_pc_factor_mat_ordering_type", "natural"}}};
    case Rival::mumps:
      return {.name = "mumps", .options = {{"-filter_pc_type", "lu"}, {"-filter_pc_factor_mat_solver_type", "mumps"}}};
    case Rival::superlu_dist:
      return {.name = "superlu_dist",
              .options = {{"-filter_pc_type", "lu"},
                          {"-filter_mat_type", "aij"},
                          {"-filter_pc_factor_mat_solver_type", "superlu_dist"},
                          {"-filter_mat_superlu_dist_equil", "0"},
                          {"-filter_mat_superlu_dist_rowperm", "NOROWPERM"},
                          {"-filter_mat_superlu_dist_iterrefine", "1"}}};
  }
  return {};
}

/// A line built under solver options that do not outlive the building.
std::unique_ptr<FilteredStructure> build(const BeamChain& beam, FilterParameters filter, const Form& form) {
  for (const auto& [key, value] : form.options) {
    UDAR_CALL(PetscOptionsSetValue(nullptr, key.c_str(), value.c_str()));
  }
  filter.formulation = form.formulation;
  filter.check_interval = 0;
  auto line = std::make_unique<FilteredStructure>(beam, filter);
  for (const auto& [key, value] : form.options) {
    UDAR_CALL(PetscOptionsClearValue(nullptr, key.c_str()));
  }
  return line;
}

/// The motion to solve for: half a millimetre of each of three gentle shapes, on an offset and a tilt; at rest where an
/// end is fixed.
Numbers displacement(const BeamChain& beam, PetscInt begin, PetscInt end, double offset) {
  Numbers values;
  for (PetscInt node = begin; node < end; ++node) {
    const double s = beam.position(node) / beam.length();
    const double window = (beam.fixed(0) ? s : 1.0) * (beam.fixed(beam.elements()) ? 1.0 - s : 1.0);
    values.push_back(beam.fixed(node) ? 0.0
                                      : window * (offset * (1.0 + 0.3 * s) +
                                                  5e-4 * (std::cos(3.0 * s) + std::sin(7.0 * s) + s * s)));
  }
  return values;
}

/// Largest error of the acceleration relative to its largest value.
double error_of(FilteredStructure& line, double offset) {
  const BeamChain& beam = *line.structure().chain();
  const Numbers exact =
      tools::quad_line(beam, line.filter_frequency(), displacement(beam, 0, beam.nodes(), offset), {}).stretch;
  Numbers stretch(static_cast<std::size_t>(beam.local_nodes()));
  line.solve(displacement(beam, beam.begin(), beam.end(), offset), {}, stretch, {});
  return tools::relative_error(beam, stretch, exact);
}

/// Gives every node of a uniform beam a mass of its own, spread over the given number of decades around its share.
void spread_masses(BeamParameters& beam, double decades) {
  std::mt19937 generator{7};
  std::uniform_real_distribution<double> exponent{-0.5 * decades, 0.5 * decades};
  const BeamSegment& segment = beam.segments.front();
  const double h = segment.length / static_cast<double>(segment.elements);
  for (PetscInt node = 0; node <= segment.elements; ++node) {
    beam.point_masses.push_back({.position = std::min(h * static_cast<double>(node), segment.length),
                                 .mass = segment.mass_per_length * h * std::pow(10.0, exponent(generator))});
  }
}

/// The chain solver's measurements, with which others are compared in turn.
struct ChainTimes {
  MPI_Comm comm;
  const BeamChain& beam;
  const FilterParameters& filter;
  PetscInt repeats;
  const Numbers& given;
  Vec right;  // of the operator's system
  Vec found;
  Timed& one;  // solve
  Timed& ksp;  // of the system
};

/// Of a triad beyond any cache: 64 MB a vector over all ranks [bytes/s].
double memory_bandwidth(const ChainTimes& chain) {
  int ranks = 1;
  MPI_Comm_size(chain.comm, &ranks);
  Triad memory{static_cast<std::size_t>(8'000'000 / ranks)};
  sample(chain.comm, {&chain.one, &memory.timed}, std::min<PetscInt>(chain.repeats, 20));
  return memory.bandwidth(chain.comm);
}

/// How much longer than all ranks rank 0 alone takes for the whole line, in turn.
double one_rank_over_these(const ChainTimes& chain) {
  int rank = 0;
  MPI_Comm_rank(chain.comm, &rank);
  std::optional<BeamChain> beam;
  std::unique_ptr<FilteredStructure> line;
  Numbers given;
  Numbers stretch;
  if (rank == 0) {
    beam.emplace(PETSC_COMM_SELF, chain.beam.parameters());
    line = build(*beam, chain.filter, {.name = "chain"});
    given = displacement(*beam, 0, beam->nodes(), 0.0);
    stretch.resize(given.size());
  }
  Timed alone{.body = [&] {
    if (line) {
      line->solve(given, {}, stretch, {});
    }
  }};
  sample(chain.comm, {&chain.one, &alone}, chain.repeats);
  return alone.best() / chain.one.best();
}

/// One of PETSc's solvers beside the chain solver.
nlohmann::ordered_json compare(const ChainTimes& chain, const Form& form) {
  const auto nodes = static_cast<double>(chain.beam.nodes());
  const double begin = MPI_Wtime();
  const auto other = build(chain.beam, chain.filter, form);
  const double set_up = MPI_Wtime() - begin;
  Numbers stretch(chain.given.size());
  Timed solve_it{.body = [&] { other->solve(chain.given, {}, stretch, {}); }};
  Timed solve_ksp{.body = [&] { UDAR_CALL(KSPSolve(other->solver(), chain.right, chain.found)); }};
  try {
    sample(chain.comm, {&chain.one, &solve_it, &chain.ksp, &solve_ksp}, std::min<PetscInt>(chain.repeats, 10));
    return {{"nanoseconds_per_node", solve_it.best() * 1e9 / nodes},
            {"over_chain", solve_it.best() / chain.one.best()},
            {"ksp_solve_over_chain", solve_ksp.best() / chain.ksp.best()},
            {"setup_nanoseconds_per_node", set_up * 1e9 / nodes},
            {"error", error_of(*other, 0.0)}};
  } catch (const SolveError& failure) {
    return {{"failed", petsc::with_option_keys(failure.what())}};
  }
}

/// PETSc's solvers beside the chain solver, and which of those that are accurate is fastest.
void compare_all(const ChainTimes& chain, const std::vector<Rival>& rivals, nlohmann::ordered_json& result) {
  constexpr double kAccurate = 1e-11;
  double best = 0.0;
  for (const Rival rival : rivals) {
    if (rival == Rival::none) {
      continue;
    }
    const Form form = rival_form(rival);
    const nlohmann::ordered_json entry = compare(chain, form);
    if (!entry.contains("failed") && entry["error"] <= kAccurate &&
        (best == 0.0 || entry["nanoseconds_per_node"] < best)) {
      best = entry["nanoseconds_per_node"];
      result["petsc_best"] = best;
      result["petsc_best_name"] = form.name;
      result["petsc_over_chain"] = entry["over_chain"];
    }
    result["petsc"][form.name] = entry;
  }
}

/// The line solve, as the program calls it and through PETSc, against the memory and against PETSc's direct solvers.
void solve(MPI_Comm comm, const BeamParameters& parameters, const FilterParameters& filter, PetscInt repeats,
           const std::vector<Rival>& rivals) {
  int ranks = 1;
  MPI_Comm_size(comm, &ranks);
  const BeamChain beam{comm, parameters};
  const auto count = static_cast<std::size_t>(beam.local_nodes());
  const auto nodes = static_cast<double>(beam.nodes());
  MPI_Barrier(comm);
  const double begin = MPI_Wtime();
  const auto line = build(beam, filter, {.name = "chain"});
  const double set_up = MPI_Wtime() - begin;
  if (line->chain() == nullptr) {
    throw InputError{"option -bench_kind: solve measures the chain solver, which does not serve this line (" +
                     line->filter_operator().block_form_reason() + ")"};
  }

  const Numbers given = displacement(beam, beam.begin(), beam.end(), 0.0);
  const Numbers force(count, 1.0);
  std::array<Numbers, 4> stretch;
  stretch.fill(Numbers(count));
  const std::array<Numbers, 4> batch_given{given, given, given, given};
  std::vector<FilterColumn> batch;
  batch.reserve(batch_given.size());
  for (std::size_t c = 0; c < batch_given.size(); ++c) {
    batch.push_back({.displacement = batch_given[c].data(), .stretch = stretch[c].data()});
  }
  petsc::Vector right;
  petsc::Vector found;
  UDAR_CALL(MatCreateVecs(line->op(), found.put(), right.put()));
  UDAR_CALL(VecSet(right, 1.0));
  PC pc = nullptr;
  UDAR_CALL(KSPGetPC(line->solver(), &pc));

  Timed one{.body = [&] { line->solve(given, {}, stretch[0], {}); }};
  Timed loaded{.body = [&] { line->solve(given, force, stretch[0], {}); }};
  Timed four{.body = [&] { line->solve(batch); }};
  Timed apply{.body = [&] { UDAR_CALL(PCApply(pc, right, found)); }};
  Timed ksp{.body = [&] { UDAR_CALL(KSPSolve(line->solver(), right, found)); }};
  Triad triad{count};
  sample(comm, {&one, &loaded, &four, &apply, &ksp, &triad.timed}, repeats);
  const double bandwidth = triad.bandwidth(comm);

  nlohmann::ordered_json result;
  result["elements"] = beam.elements();
  result["ranks"] = ranks;
  result["lanes"] = line->chain()->report().lanes;
  const auto total = [comm](double local) {
    MPI_Allreduce(MPI_IN_PLACE, &local, 1, MPI_DOUBLE, MPI_SUM, comm);
    return local;
  };
  const auto per_node = [nodes](double seconds) { return seconds * 1e9 / nodes; };
  const auto put = [&](const std::string& name, const Timed& timed, const FilterColumn& kind) {
    const double bytes = total(line->chain()->bytes_per_solve(kind));
    result[name + "nanoseconds_per_node"] = per_node(timed.best());
    result[name + "bytes_per_node"] = bytes / nodes;
    result[name + "ratio_to_stream"] = timed.best() / (bytes / bandwidth);
  };
  put("", one, batch[0]);
  result["triad_bandwidth"] = bandwidth;
  result["triad_nanoseconds_per_node"] = per_node(triad.timed.best());
  const double number = 0.0;
  put("loaded_", loaded, {.displacement = &number, .force = &number});
  put("pc_apply_", apply, {.right_hand_side = &number});
  result["ksp_solve_nanoseconds_per_node"] = per_node(ksp.best());
  result["batch_of_4_over_single"] = four.best() / (4.0 * one.best());
  result["setup_nanoseconds_per_node"] = per_node(set_up);
  const ChainSolver::Report& report = line->chain()->report();
  result["factor_bytes_per_node"] = total(static_cast<double>(report.factor_bytes)) / nodes;
  result["work_bytes_per_node"] = total(static_cast<double>(report.work_bytes)) / nodes;

  const ChainTimes chain{comm, beam, filter, repeats, given, right, found, one, ksp};
  result["memory_triad_bandwidth"] = memory_bandwidth(chain);
  if (ranks > 1) {
    result["one_rank_over_these"] = one_rank_over_these(chain);
  }
  compare_all(chain, rivals, result);
  result["error"] = error_of(*line, 0.0);
  result["error_offset_and_tilt"] = error_of(*line, 1.0);
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  result["peak_memory_bytes"] = total(static_cast<double>(usage.ru_maxrss) * 1024.0);
  UDAR_CALL(PetscPrintf(comm, "%s\n", result.dump(2).c_str()));
}

/// Prints, for each form and N, the largest error of the acceleration relative to its largest value, and the time of a
/// solve per node (best of the repeats).
void accuracy(MPI_Comm comm, BeamParameters parameters, const FilterParameters& filter,
              const std::vector<PetscInt>& sizes, PetscInt repeats, bool given) {
  int ranks = 1;
  MPI_Comm_size(comm, &ranks);
  std::vector<Form> forms;
  if (given) {
    forms = {{.name = "solver as given", .formulation = filter.formulation}};
  } else {
    forms = {{.name = "hermite, BAIJ LU + refinement",
              .formulation = Formulation::hermite,
              .options = {{"-filter_pc_type", "lu"}}},
             {.name = "mixed, AIJ LU (pointwise)",
              .options = {{"-filter_pc_type", "lu"}, {"-filter_mat_type", "aij"}, {"-filter_ksp_max_it", "1"}}},
             {.name = "mixed, MUMPS LU",
              .options = {{"-filter_pc_type", "lu"},
                          {"-filter_pc_factor_mat_solver_type", "mumps"},
                          {"-filter_ksp_max_it", "1"}},
              .most_elements = 100'000},
             {.name = "mixed, BAIJ LU", .options = {{"-filter_pc_type", "lu"}, {"-filter_ksp_max_it", "1"}}},
             {.name = "mixed, BAIJ LU + refinement", .options = {{"-filter_pc_type", "lu"}}},
             {.name = "chain (default)"}};
  }
  UDAR_CALL(PetscPrintf(comm, "wf %.6g rad/s, %d rank(s): error of the acceleration / nanoseconds per node and solve\n",
                        filter.filter_frequency, ranks));
  UDAR_CALL(PetscPrintf(comm, "%-34s", "form"));
  for (const PetscInt size : sizes) {
    UDAR_CALL(PetscPrintf(comm, " %18lld", static_cast<long long>(size)));
  }
  UDAR_CALL(PetscPrintf(comm, "\n"));
  for (const Form& form : forms) {
    UDAR_CALL(PetscPrintf(comm, "%-34s", form.name.c_str()));
    for (const PetscInt size : sizes) {
      if (size > form.most_elements) {
        UDAR_CALL(PetscPrintf(comm, " %18s", "-"));
        continue;
      }
      parameters.segments[0].elements = size;
      const BeamChain beam{comm, parameters};
      const auto line = build(beam, filter, form);
      const Numbers motion = displacement(beam, beam.begin(), beam.end(), 0.0);
      Numbers stretch(motion.size());
      Timed timed{.body = [&] { line->solve(motion, {}, stretch, {}); }};
      sample(comm, {&timed}, repeats);
      UDAR_CALL(PetscPrintf(comm, "    %7.0e /%6.3g", error_of(*line, 0.0),
                            timed.best() * 1e9 / static_cast<double>(beam.nodes())));
    }
    UDAR_CALL(PetscPrintf(comm, "\n"));
  }
}

void refuse_correction(const app::ModeChoice& exact) {
  if (exact.any()) {
    throw InputError{"options -filter_correct_modes and -filter_correct_mode are not for measurements"};
  }
}

/// For what has no filter, or takes its own.
void forget_frequency(PetscBool given) {
  if (given == PETSC_FALSE) {
    UDAR_CALL(PetscOptionsClearValue(nullptr, "-filter_frequency"));
  }
}

void measure_batch(MPI_Comm comm, PetscInt beams, PetscInt ranks_per_beam) {
  const app::CaseInput input = app::read_case(comm);
  if (!petsc::Session::help_requested()) {
    refuse_correction(input.filter.exact);
    const app::Case settled = app::resolve(comm, input);
    petsc::check_unknown_options(comm);
    bench::batch(comm, settled, beams, ranks_per_beam);
  }
}

/// Which networks, and how long their members are.
bench::NetworkBench read_networks(petsc::OptionGroup& group) {
  bench::NetworkBench networks;
  std::vector<PetscInt> elements(networks.elements.begin(), networks.elements.end());
  auto most = static_cast<PetscInt>(networks.most);
  group.choices<bench::Regular>("-bench_networks", networks.structures, kNetworks,
                                "network: equal members, one alone, along the sides of squares or cubes");
  group.integers("-bench_member_elements", elements, petsc::at_least(1), "network: elements of a member");
  group.real("-bench_member_length", networks.member_length, "m", petsc::positive(), "network: length of a member");
  group.real("-bench_grading", networks.grading, "-", petsc::positive(),
             "network: measures elements that grow so many times along a member, too; 1: equal ones alone");
  group.boolean("-bench_rotary_inertia", networks.rotary_inertia,
                "network: measures members with rotary inertia, too, as -rotary_inertia");
  group.choice<NetworkPartition>("-bench_partition", networks.partition, kPartitions,
                                 "network: how junctions are dealt to the ranks, as -network_partition");
  group.integer("-bench_largest_frame", most, petsc::at_least(0),
                "network: assembled frames are solved up to so many nodes");
  networks.elements.assign(elements.begin(), elements.end());
  networks.most = most;
  return networks;
}

/// At the filter frequency of the options if one is given.
void measure_networks(MPI_Comm comm, bool frequency_given, bench::NetworkBench bench) {
  if (frequency_given) {
    bench.filter_frequency = app::read_filter(comm, Formulation::mixed).parameters.filter_frequency;
  }
  UDAR_CALL(PetscOptionsClearValue(nullptr, "-filter_frequency"));
  petsc::check_unknown_options(comm);
  bench::networks(comm, bench);
}

/// Whether the options give a filter frequency; if not they do from now on.
PetscBool given_or_default_frequency() {
  PetscBool given = PETSC_FALSE;
  UDAR_CALL(PetscOptionsHasName(nullptr, nullptr, "-filter_frequency", &given));
  if (given == PETSC_FALSE) {
    UDAR_CALL(PetscOptionsSetValue(nullptr, "-filter_frequency", "50"));
  }
  return given;
}

/// What knows no structure. @param largest footprint of the triad [bytes per rank]
void measure_parts(MPI_Comm comm, Kind kind, PetscInt largest, PetscInt repeats) {
  if (kind == Kind::machine) {
    bench::machine(comm, static_cast<std::size_t>(largest), repeats);
  } else {
    bench::laws(comm, repeats);
  }
}

int run_bench(MPI_Comm comm) {
  app::register_types();
  petsc::check_petsc_options();
  const PetscBool frequency_given = given_or_default_frequency();
  int ranks = 1;
  MPI_Comm_size(comm, &ranks);
  Kind kind = Kind::solve;
  std::vector<PetscInt> sizes{100, 1000, 10000, 100000, 1000000};
  PetscInt repeats = 50;
  bool given = false;
  bool quick = false;
  double decades = 0.0;
  PetscInt largest = PetscInt{1} << 28;
  PetscInt beams = 100;
  std::string directory = ".";
  PetscInt ranks_per_beam = 1;
  bench::ContactLists lists;
  bench::NetworkBench networks;
  std::vector<Rival> rivals{ranks > 1 ? Rival::repeated_lu : Rival::block_lu};
  {
    petsc::OptionGroup group{comm, "Benchmark (of the beam and filter below; -filter_frequency is 50 unless given)"};
    group.choice<Kind>(
        "-bench_kind", kind, kKinds,
        "solve: time of a line solve against memory and PETSc, as JSON, of -beam_elements; accuracy: "
        "table of error and time by form and size; integrators: tables of error and work of -ts_type "
        "chebyshev, impact, rk and a leapfrog on the steel beam of example 01; machine: what the ranks can do "
        "together [bytes/s, s, 1/s], as JSON; batch: whole motions of many beams at once, without files, as JSON; "
        "contact: tables of error and work of all methods on the beam of example 02, or on the case of the options, "
        "and contact.csv, contact.json; "
        "laws: time of a mass and sweep that passes through a contact, by what it meets [ns], as JSON; "
        "network: time of a solve of -bench_networks by their members, of -bench_repeats, beside CHOLMOD and "
        "MUMPS up to -bench_largest_frame, as JSON; "
        "output: rows of fields into results.h5 against plain writes of as many bytes, as JSON");
    group.boolean("-bench_quick", quick, "integrators: the first tables only");
    group.integers("-bench_elements", sizes, petsc::at_least(2), "sizes of the accuracy table");
    group.integer("-bench_repeats", repeats, petsc::at_least(1),
                  "samples of each time; the best counts, of the machine the median");
    group.boolean("-bench_given", given, "accuracy of the solver that the options name only (-filter_ksp_*, ...)");
    group.real("-bench_mass_decades", decades, "-", petsc::non_negative(),
               "> 0: every node of a beam of one segment gets a point mass, spread over so many decades");
    group.integer("-bench_largest", largest, petsc::between(32768, 1e12),
                  "machine: largest footprint of the triad [bytes per rank]");
    networks = read_networks(group);
    group.integer("-bench_beams", beams, petsc::between(1, 1e8),
                  "batch: beams; the initial height rises by a tenth from the first to the last");
    group.integer("-bench_group", ranks_per_beam, petsc::at_least(1),
                  "batch: ranks that share a beam, a divisor of all");
    group.string("-bench_directory", directory,
                 "existing folder; output: for the two files, which are removed; contact: for contact.csv and "
                 "contact.json");
    group.choices<Rival>("-bench_petsc", rivals, kRivals, "PETSc's solvers that -bench_kind solve compares with");
    lists.read(group);
  }
  if ((kind == Kind::machine || kind == Kind::contact || kind == Kind::laws) && !petsc::Session::help_requested()) {
    forget_frequency(frequency_given);
    if (kind == Kind::contact) {
      bench::contact(comm, lists, directory, repeats);
    } else {
      measure_parts(comm, kind, largest, repeats);
    }
    petsc::check_unknown_options(comm);
    return 0;
  }
  if (kind == Kind::batch) {
    measure_batch(comm, beams, ranks_per_beam);
    return 0;
  }
  if (kind == Kind::network && !petsc::Session::help_requested()) {
    networks.repeats = repeats;
    measure_networks(comm, frequency_given == PETSC_TRUE, networks);
    return 0;
  }
  auto [beam, formulation] = app::read_beam(comm);
  const app::FilterInput asked = app::read_filter(comm, formulation);
  if (petsc::Session::help_requested()) {
    return 0;
  }
  refuse_correction(asked.exact);
  const FilterParameters filter = app::choose_filter(comm, {.beam = beam}, asked);
  if (beam.segments.size() > 1 && (kind != Kind::solve || decades > 0.0)) {
    throw InputError{"option -beam_length: the tables and -bench_mass_decades are for one segment"};
  }
  if (kind == Kind::output) {
    petsc::check_unknown_options(comm);
    bench::output(BeamChain{comm, beam}, directory, repeats);
    return 0;
  }
  if (kind == Kind::solve) {
    if (decades > 0.0) {
      spread_masses(beam, decades);
    }
    solve(comm, beam, filter, repeats, rivals);
  } else if (kind == Kind::integrators) {
    udar::bench::integrators({.comm = comm, .beam = beam}, quick);
  } else {
    accuracy(comm, beam, filter, sizes, repeats, given);
  }
  petsc::check_unknown_options(comm);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return udar::app::guarded_main(argc, argv, "udar-bench: measurements of udar's parts\n", run_bench);
}
