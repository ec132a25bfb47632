#include "tools/batch.hpp"

#include <mpi.h>
#include <petscsys.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <vector>

#include "udar/dynamics/impact_dynamics.hpp"
#include "udar/petsc/error.hpp"

namespace udar::bench {
namespace {

/// One beam of the batch from start to end, without files. @return [seconds, impacts, line solves]
std::array<double, 3> run_beam(MPI_Comm comm, const app::Case& input, PetscInt index, PetscInt beams) {
  constexpr double kSpread = 0.1;  // of the initial height, over the batch
  app::Case own = input;
  own.initial.height *= 1.0 + kSpread * static_cast<double>(index) / static_cast<double>(beams);
  const double begin = MPI_Wtime();
  Model model{comm, own};
  ImpactDynamics dynamics{model};
  dynamics.solve();
  return {MPI_Wtime() - begin, static_cast<double>(dynamics.counts().impacts),
          static_cast<double>(model.line.solves())};
}

}  // namespace

void batch(MPI_Comm comm, const app::Case& input, PetscInt beams, PetscInt group) {
  int rank = 0;
  int ranks = 1;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &ranks);
  if (group > ranks || ranks % group != 0) {
    throw InputError{"option -bench_group: " + std::to_string(group) + " is not allowed, expected a divisor of the " +
                     std::to_string(ranks) + " ranks"};
  }
  const auto groups = static_cast<PetscInt>(ranks) / group;
  const PetscInt mine = rank / group;
  MPI_Comm part = MPI_COMM_NULL;
  MPI_Comm_split(comm, static_cast<int>(mine), rank, &part);
  run_beam(part, input, 0, beams);  // fills caches, opens libraries
  std::vector<double> seconds(static_cast<std::size_t>(beams));
  std::array<double, 2> counts{};
  std::string failure;
  MPI_Barrier(comm);
  const double begin = MPI_Wtime();
  try {
    for (PetscInt index = mine; index < beams; index += groups) {
      const auto [time, impacts, solves] = run_beam(part, input, index, beams);
      if (rank % group == 0) {
        seconds[static_cast<std::size_t>(index)] = time;
        counts[0] += impacts;
        counts[1] += solves;
      }
    }
  } catch (const SolveError& error) {
    failure = error.what();
  }
  throw_together<SolveError>(comm, failure);
  double total = MPI_Wtime() - begin;
  MPI_Comm_free(&part);
  MPI_Allreduce(MPI_IN_PLACE, &total, 1, MPI_DOUBLE, MPI_MAX, comm);
  MPI_Allreduce(MPI_IN_PLACE, seconds.data(), static_cast<int>(beams), MPI_DOUBLE, MPI_SUM, comm);
  MPI_Allreduce(MPI_IN_PLACE, counts.data(), 2, MPI_DOUBLE, MPI_SUM, comm);
  std::ranges::sort(seconds);
  nlohmann::ordered_json result;
  result["elements"] = [&] {
    PetscInt elements = 0;
    for (const BeamSegment& segment : input.beam.segments) {
      elements += segment.elements;
    }
    return elements;
  }();
  result["ranks"] = ranks;
  result["groups"] = groups;
  result["ranks_per_group"] = group;
  result["beams"] = beams;
  result["seconds"] = total;
  result["beams_per_second"] = static_cast<double>(beams) / total;
  result["seconds_per_beam"] = {
      {"low", seconds.front()}, {"median", seconds[seconds.size() / 2]}, {"high", seconds.back()}};
  result["impacts"] = counts[0];
  result["line_solves"] = counts[1];
  UDAR_CALL(PetscPrintf(comm, "%s\n", result.dump(2).c_str()));
}

}  // namespace udar::bench
