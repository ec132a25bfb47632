#pragma once
/// @file
/// What a machine can do on so many ranks at once: memory, messages, reductions, arithmetic.

#include <mpi.h>

#include <nlohmann/json.hpp>
#include <string>

#include "tools/timing.hpp"

namespace udar::bench {

/// Name of the processor, as the kernel gives it.
std::string processor_name();

/// Hosts of a communicator and the processors on which its ranks may run.
struct Places {
  int hosts = 1;
  int most_ranks_on_a_host = 1;
  int fewest_cores_on_a_host = 1;  ///< that the ranks there may use
};

Places places(MPI_Comm comm);

nlohmann::ordered_json spread(const Timed& timed, double unit = 1.0);

/// The operation of a sweep's reduction: maxima, then sums, then minima.
// NOLINTNEXTLINE(readability-non-const-parameter): MPI_User_function
void combine_sweep(void* from, void* into, int* length, MPI_Datatype* /*type*/);

/// Memory bandwidth of all ranks together, for growing footprints.
nlohmann::ordered_json triads(MPI_Comm comm, std::size_t largest, long repeats, double shortest);

/// Messages between neighbouring ranks and reductions over all.
void communication(MPI_Comm comm, long repeats, nlohmann::ordered_json& result);

/// Multiplications and additions of every rank at once, in registers [1/s per rank].
double flops(MPI_Comm comm, long repeats, double shortest);

/// Prints everything as one JSON object.
void machine(MPI_Comm comm, std::size_t largest, long repeats);

}  // namespace udar::bench
