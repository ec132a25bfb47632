#include "tools/machine.hpp"

#include <mpi.h>
#include <petscsys.h>
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/timing.hpp"
#include "udar/petsc/error.hpp"

namespace udar::bench {

std::string processor_name() {
  std::ifstream file{"/proc/cpuinfo"};
  for (std::string line; std::getline(file, line);) {
    const std::size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) {
      return line.substr(colon + 2);
    }
  }
  return "unknown";
}

Places places(MPI_Comm comm) {
  MPI_Comm host = MPI_COMM_NULL;
  MPI_Comm_split_type(comm, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &host);
  int rank_on_host = 0;
  int ranks_on_host = 1;
  MPI_Comm_rank(host, &rank_on_host);
  MPI_Comm_size(host, &ranks_on_host);
  cpu_set_t usable;
  CPU_ZERO(&usable);
  const bool known = sched_getaffinity(0, sizeof usable, &usable) == 0;
  MPI_Allreduce(MPI_IN_PLACE, &usable, static_cast<int>(sizeof usable), MPI_BYTE, MPI_BOR, host);
  const int cores = known ? CPU_COUNT(&usable) : static_cast<int>(sysconf(_SC_NPROCESSORS_ONLN));
  Places found;
  found.hosts = rank_on_host == 0 ? 1 : 0;
  MPI_Allreduce(MPI_IN_PLACE, &found.hosts, 1, MPI_INT, MPI_SUM, comm);
  std::array<int, 2> most{ranks_on_host, -cores};
  MPI_Allreduce(MPI_IN_PLACE, most.data(), 2, MPI_INT, MPI_MAX, comm);
  found.most_ranks_on_a_host = most[0];
  found.fewest_cores_on_a_host = -most[1];
  MPI_Comm_free(&host);
  return found;
}

nlohmann::ordered_json spread(const Timed& timed, double unit) {
  return {{"median", timed.median() * unit}, {"low", timed.best() * unit}, {"high", timed.worst() * unit}};
}

// NOLINTNEXTLINE(readability-non-const-parameter): MPI_User_function has it so
void combine_sweep(void* from, void* into, int* length, MPI_Datatype* /*type*/) {
  constexpr int kCount = 21;
  for (int i = 0; i < *length; ++i) {
    const double* a = static_cast<const double*>(from) + i * kCount;
    double* b = static_cast<double*>(into) + i * kCount;
    for (int k = 0; k < kCount; ++k) {
      b[k] = k < 5 ? std::max(a[k], b[k]) : (k < 13 ? a[k] + b[k] : std::min(a[k], b[k]));
    }
  }
}

nlohmann::ordered_json triads(MPI_Comm comm, std::size_t largest, long repeats, double shortest) {
  nlohmann::ordered_json table = nlohmann::ordered_json::array();
  for (std::size_t bytes = std::size_t{1} << 15; bytes <= largest; bytes *= 2) {
    Triad triad{bytes / 24};
    sample(comm, {&triad.timed}, repeats, shortest);
    const double moved = triad.bytes(comm);
    table.push_back({{"bytes_per_rank", bytes},
                     {"bandwidth", moved / triad.timed.median()},
                     {"low", moved / triad.timed.worst()},
                     {"high", moved / triad.timed.best()}});
  }
  return table;
}

void communication(MPI_Comm comm, long repeats, nlohmann::ordered_json& result) {
  int rank = 0;
  int ranks = 1;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &ranks);
  if (ranks == 1) {
    result["message"] = nullptr;
    result["exchange_seconds"] = nullptr;
    result["gather_seconds"] = nullptr;
    result["reduction_seconds"] = nullptr;
    return;
  }
  constexpr int kSmall = 16;       // numbers: what a joint of four columns sends
  constexpr int kLarge = 1 << 17;  // numbers: one megabyte
  std::vector<double> buffer(kLarge);
  const int partner = rank % 2 == 0 ? rank + 1 : rank - 1;
  const auto ping_pong = [&](int count) {
    if (partner >= ranks) {
      return;
    }
    for (const bool sends : {rank % 2 == 0, rank % 2 != 0}) {
      if (sends) {
        MPI_Send(buffer.data(), count, MPI_DOUBLE, partner, 0, comm);
      } else {
        MPI_Recv(buffer.data(), count, MPI_DOUBLE, partner, 0, comm, MPI_STATUS_IGNORE);
      }
    }
  };
  std::array<double, 4L * kSmall> near{};
  const auto exchange = [&] {
    std::array<MPI_Request, 4> requests{MPI_REQUEST_NULL, MPI_REQUEST_NULL, MPI_REQUEST_NULL, MPI_REQUEST_NULL};
    if (rank > 0) {
      MPI_Irecv(near.data(), kSmall, MPI_DOUBLE, rank - 1, 1, comm, requests.data());
      MPI_Isend(near.data() + kSmall, kSmall, MPI_DOUBLE, rank - 1, 1, comm, &requests[1]);
    }
    if (rank + 1 < ranks) {
      MPI_Irecv(near.data() + 2L * kSmall, kSmall, MPI_DOUBLE, rank + 1, 1, comm, &requests[2]);
      MPI_Isend(near.data() + 3L * kSmall, kSmall, MPI_DOUBLE, rank + 1, 1, comm, &requests[3]);
    }
    MPI_Waitall(4, requests.data(), MPI_STATUSES_IGNORE);
  };
  std::vector<double> all(static_cast<std::size_t>(kSmall * ranks));
  MPI_Datatype type = MPI_DATATYPE_NULL;
  MPI_Op operation = MPI_OP_NULL;
  constexpr int kTally = 21;
  MPI_Type_contiguous(kTally, MPI_DOUBLE, &type);
  MPI_Type_commit(&type);
  MPI_Op_create(combine_sweep, 1, &operation);
  std::array<double, kTally> tally{};
  std::array<double, 8> sums{};

  Timed small{.body = [&] { ping_pong(kSmall); }};
  Timed large{.body = [&] { ping_pong(kLarge); }};
  Timed both{.body = exchange};
  Timed gather{.body = [&] { MPI_Allgather(near.data(), kSmall, MPI_DOUBLE, all.data(), kSmall, MPI_DOUBLE, comm); }};
  Timed sweep{.body = [&] { MPI_Allreduce(MPI_IN_PLACE, tally.data(), 1, type, operation, comm); }};
  Timed step{.body = [&] { MPI_Allreduce(MPI_IN_PLACE, sums.data(), 8, MPI_DOUBLE, MPI_SUM, comm); }};
  sample(comm, {&small, &large, &both, &gather, &sweep, &step}, repeats);
  MPI_Op_free(&operation);
  MPI_Type_free(&type);
  result["message"] = {
      {"latency", spread(small, 0.5)},
      {"bandwidth", 8.0 * (kLarge - kSmall) / std::max(0.5 * (large.median() - small.median()), 1e-9)}};
  result["exchange_seconds"] = spread(both);
  result["gather_seconds"] = spread(gather);
  result["reduction_seconds"] = {{"sweep", spread(sweep)}, {"step", spread(step)}};
}

double flops(MPI_Comm comm, long repeats, double shortest) {
  constexpr int kLanes = 64;
  constexpr int kRounds = 20000;
  std::array<double, kLanes> x{};
  x.fill(1.0);
  volatile double sink = 0.0;
  Timed timed{.body = [&] {
    const double factor = 1.0 - 1e-9 * x[1];
    for (int round = 0; round < kRounds; ++round) {
      for (double& value : x) {
        value = value * factor + 1e-9;
      }
    }
    sink = x[0];
  }};
  sample(comm, {&timed}, repeats, shortest);
  return 2.0 * kLanes * kRounds / timed.median();
}

void machine(MPI_Comm comm, std::size_t largest, long repeats) {
  int ranks = 1;
  MPI_Comm_size(comm, &ranks);
  const Places where = places(comm);
  nlohmann::ordered_json result;
  result["processor"] = processor_name();
  result["hosts"] = where.hosts;
  result["ranks"] = ranks;
  result["ranks_per_host"] = where.most_ranks_on_a_host;
  result["cores_per_host"] = where.fewest_cores_on_a_host;
  const bool shared = where.most_ranks_on_a_host > where.fewest_cores_on_a_host;
  const double shortest = shared ? 3e-2 : 1e-3;
  // Ranks that share cores share the memory too.
  const auto turns = static_cast<std::size_t>((where.most_ranks_on_a_host + where.fewest_cores_on_a_host - 1) /
                                              where.fewest_cores_on_a_host);
  const long triad_repeats = shared ? std::min(repeats, 5L) : repeats;
  result["triad"] = triads(comm, std::max(largest / turns, std::size_t{1} << 15), triad_repeats, shortest);
  communication(comm, repeats, result);
  result["flops_per_rank"] = flops(comm, repeats, shortest);
  UDAR_CALL(PetscPrintf(comm, "%s\n", result.dump(2).c_str()));
}

}  // namespace udar::bench
