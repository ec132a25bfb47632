#include "tools/timing.hpp"

#include <mpi.h>
#include <sys/resource.h>

#include <algorithm>
#include <vector>

namespace udar::bench {

double cpu_seconds(MPI_Comm comm) {
  constexpr double kMicro = 1e-6;
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  double seconds = static_cast<double>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
                   kMicro * static_cast<double>(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
  MPI_Allreduce(MPI_IN_PLACE, &seconds, 1, MPI_DOUBLE, MPI_SUM, comm);
  return seconds;
}

void sample(MPI_Comm comm, const std::vector<Timed*>& all, long repeats, double shortest) {
  for (Timed* timed : all) {
    const double begin = MPI_Wtime();
    timed->body();
    double once = MPI_Wtime() - begin;
    MPI_Allreduce(MPI_IN_PLACE, &once, 1, MPI_DOUBLE, MPI_MAX, comm);
    timed->calls = static_cast<int>(std::clamp(shortest / once, 1.0, 1e4));
    timed->samples.clear();
  }
  for (long repeat = 0; repeat < repeats; ++repeat) {
    for (Timed* timed : all) {
      MPI_Barrier(comm);
      const double begin = MPI_Wtime();
      for (int call = 0; call < timed->calls; ++call) {
        timed->body();
      }
      double seconds = (MPI_Wtime() - begin) / timed->calls;
      MPI_Allreduce(MPI_IN_PLACE, &seconds, 1, MPI_DOUBLE, MPI_MAX, comm);
      timed->samples.push_back(seconds);
    }
  }
}

}  // namespace udar::bench
