#pragma once
/// @file
/// Brings the events of all ranks into one order, on rank 0, a bounded part at a time.

#include <mpi.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>
#include <type_traits>
#include <vector>

namespace udar::io {

/// Events rank 0 takes from all ranks at a time, as long as each may give at least `kEventsPerRankMin`.
inline constexpr int kEventsAtATime = 1 << 16;
inline constexpr int kEventsPerRankMin = 64;

/// @brief Hands the records of all ranks to rank 0 in order of time, then node, and empties `records`.
/// @param[in,out] records this rank's, in any order; `Record` has `time` and `node`
/// @param[in] consume     `void(std::span<const Record> rows, std::size_t count)`, called on every rank for each part:
///                        `count` rows, which only rank 0 has; may be collective
/// @note Collective. No rank holds more than `kEventsAtATime` of the others' records (more on over a thousand ranks).
template <class Record, class Consume>
void in_order(MPI_Comm comm, std::vector<Record>& records, Consume&& consume) {
  static_assert(std::is_trivially_copyable_v<Record>);
  const auto before = [](const Record& a, const Record& b) {
    return a.time < b.time || (a.time == b.time && a.node < b.node);
  };
  int rank = 0;
  int size = 1;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &size);
  MPI_Datatype type = MPI_DATATYPE_NULL;
  MPI_Type_contiguous(static_cast<int>(sizeof(Record)), MPI_BYTE, &type);
  MPI_Type_commit(&type);

  std::stable_sort(records.begin(), records.end(), before);
  const auto most = static_cast<std::size_t>(std::max(kEventsAtATime / size, kEventsPerRankMin));
  std::size_t done = 0;
  std::vector<Record> gathered;
  std::vector<int> counts(static_cast<std::size_t>(size));
  std::vector<int> offsets(static_cast<std::size_t>(size));
  std::int64_t left = 1;
  while (left > 0) {
    // Each rank offers its next records. Sure to be complete is only what comes before the last offer of any rank that
    // has still more: the cut.
    const std::size_t offered = std::min(most, records.size() - done);
    const bool has_more = done + offered < records.size();
    Record cut{};
    cut.time = has_more ? records[done + offered - 1].time : std::numeric_limits<double>::infinity();
    const double own_time = cut.time;
    MPI_Allreduce(MPI_IN_PLACE, &cut.time, 1, MPI_DOUBLE, MPI_MIN, comm);
    std::int64_t node = std::numeric_limits<decltype(cut.node)>::max();
    if (has_more && own_time == cut.time) {
      node = records[done + offered - 1].node;
    }
    MPI_Allreduce(MPI_IN_PLACE, &node, 1, MPI_INT64_T, MPI_MIN, comm);
    cut.node = static_cast<decltype(cut.node)>(node);

    const auto first = records.begin() + static_cast<std::ptrdiff_t>(done);
    const auto last = std::upper_bound(first, first + static_cast<std::ptrdiff_t>(offered), cut, before);
    const auto sent = static_cast<std::size_t>(last - first);
    std::int64_t sums[2] = {static_cast<std::int64_t>(sent), static_cast<std::int64_t>(records.size() - done - sent)};
    MPI_Allreduce(MPI_IN_PLACE, sums, 2, MPI_INT64_T, MPI_SUM, comm);
    left = sums[1];
    if (sums[0] == 0) {
      continue;  // only if there are no events at all: a rank with more always sends
    }
    const int own = static_cast<int>(sent);
    MPI_Gather(&own, 1, MPI_INT, counts.data(), 1, MPI_INT, 0, comm);
    if (rank == 0) {
      gathered.resize(static_cast<std::size_t>(sums[0]));
      for (std::size_t i = 1; i < offsets.size(); ++i) {
        offsets[i] = offsets[i - 1] + counts[i - 1];
      }
    }
    MPI_Gatherv(records.data() + done, own, type, gathered.data(), counts.data(), offsets.data(), type, 0, comm);
    std::stable_sort(gathered.begin(), gathered.end(), before);
    done += sent;
    consume(std::span<const Record>{gathered}, static_cast<std::size_t>(sums[0]));
  }
  MPI_Type_free(&type);
  records.clear();
}

}  // namespace udar::io
