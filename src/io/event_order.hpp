#pragma once
/// @file
/// Brings events of all ranks into one order.

#include <mpi.h>

#include <algorithm>
#include <numeric>
#include <type_traits>
#include <vector>

#include "io/input_file.hpp"
#include "udar/io/file_rows.hpp"
#include "udar/structure/mass_points.hpp"

namespace udar::io {

/// @brief The records of all ranks, one rank's behind the other's, on rank 0; nothing on the others.
/// @note Collective. Rank 0 holds them all: for some 1e5 of them at most.
template <class Record>
[[nodiscard]] std::vector<Record> gathered(MPI_Comm comm, const std::vector<Record>& records) {
  static_assert(std::is_trivially_copyable_v<Record>);
  int rank = 0;
  int size = 1;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &size);
  MPI_Datatype type = MPI_DATATYPE_NULL;
  MPI_Type_contiguous(static_cast<int>(sizeof(Record)), MPI_BYTE, &type);
  MPI_Type_commit(&type);
  const int own = static_cast<int>(records.size());
  std::vector<int> counts(rank == 0 ? static_cast<std::size_t>(size) : 0);
  MPI_Gather(&own, 1, MPI_INT, counts.data(), 1, MPI_INT, 0, comm);
  std::vector<int> offsets(counts.size());
  std::exclusive_scan(counts.begin(), counts.end(), offsets.begin(), 0);
  std::vector<Record> all(rank == 0 ? static_cast<std::size_t>(offsets.back() + counts.back()) : 0);
  MPI_Gatherv(records.data(), own, type, all.data(), counts.data(), offsets.data(), type, 0, comm);
  MPI_Type_free(&type);
  return all;
}

/// @brief The same in order of time, then node.
/// @param[in] records this rank's, those of a node in order of time; `Record` has `time` and `node`
template <class Record>
[[nodiscard]] std::vector<Record> on_first_rank(MPI_Comm comm, const std::vector<Record>& records) {
  std::vector<Record> all = gathered(comm, records);
  std::ranges::stable_sort(
      all, [](const Record& a, const Record& b) { return a.time < b.time || (a.time == b.time && a.node < b.node); });
  return all;
}

/// @brief Rank 0's records on every rank. @note Collective.
template <class Record>
[[nodiscard]] std::vector<Record> shared(MPI_Comm comm, std::vector<Record> records) {
  static_assert(std::is_trivially_copyable_v<Record>);
  auto count = static_cast<unsigned long long>(records.size());
  MPI_Bcast(&count, 1, MPI_UNSIGNED_LONG_LONG, 0, comm);
  records.resize(count);
  broadcast(comm, records.data(), records.size() * sizeof(Record));
  return records;
}

/// A record of this rank with the number that its node has in the user's model.
template <class Record>
[[nodiscard]] Record in_user_numbers(Record record, const MassPoints& points, const FileRows& rows) {
  record.node = static_cast<PetscInt>(rows.number(static_cast<std::size_t>(record.node - points.begin())));
  return record;
}

}  // namespace udar::io
