#include "udar/petsc/memory.hpp"

#include <algorithm>
#include <fstream>
#include <limits>
#include <string>
#include <string_view>

namespace udar::petsc {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::infinity();

/// What /proc/meminfo says is available [bytes].
double available_here() {
  constexpr double kKibibyte = 1024.0;
  std::ifstream file{"/proc/meminfo"};
  for (std::string line; std::getline(file, line);) {
    constexpr std::string_view kKey = "MemAvailable:";
    if (line.starts_with(kKey)) {
      return std::stod(line.substr(kKey.size())) * kKibibyte;
    }
  }
  return kUnknown;
}

/// What the control group of this process, version 2, may have in all [bytes].
double allowed_here() {
  std::ifstream groups{"/proc/self/cgroup"};
  for (std::string line; std::getline(groups, line);) {
    constexpr std::string_view kVersion2 = "0::";
    if (line.starts_with(kVersion2)) {
      std::ifstream file{"/sys/fs/cgroup" + line.substr(kVersion2.size()) + "/memory.max"};
      double most = 0.0;
      return file >> most ? most : kUnknown;  // a number, or the word max
    }
  }
  return kUnknown;
}

}  // namespace

double available_memory(MPI_Comm comm) {
  MPI_Comm machine = MPI_COMM_NULL;
  MPI_Comm_split_type(comm, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine);
  int rank = 0;
  MPI_Comm_rank(machine, &rank);
  MPI_Comm_free(&machine);
  double bytes = rank == 0 ? std::min(available_here(), allowed_here()) : 0.0;
  MPI_Allreduce(MPI_IN_PLACE, &bytes, 1, MPI_DOUBLE, MPI_SUM, comm);
  return bytes;
}

}  // namespace udar::petsc
