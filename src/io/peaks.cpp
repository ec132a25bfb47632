#include "udar/io/peaks.hpp"

#include <type_traits>

namespace udar::io {

Peak largest_of_all(MPI_Comm comm, const Peak& own) {
  struct {
    double value;
    int rank;
  } most{.value = own.value, .rank = 0};
  MPI_Comm_rank(comm, &most.rank);
  MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_DOUBLE_INT, MPI_MAXLOC, comm);
  static_assert(std::is_trivially_copyable_v<Peak>);
  Peak peak = own;
  MPI_Bcast(&peak, sizeof peak, MPI_BYTE, most.rank, comm);
  return peak;
}

}  // namespace udar::io
