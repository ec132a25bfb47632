#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "io/event_order.hpp"
#include "udar/io/hdf5_file.hpp"

// Tables of records, which grow by any number of rows.
//
// A compressed chunk is written once, when all its rows are there: those of the last one wait on rank 0, until the file
// is closed at the latest. Chunks whose rows one rank has are written by it, a part at a time; those that lie across
// ranks follow together.

namespace udar::io {
namespace {

/// Records a rank writes in one call: 1 MiB of impacts.
constexpr hsize_t kRecordsAtATime = hsize_t{1} << 14;

hsize_t rounded_down(hsize_t row, hsize_t chunk) { return row / chunk * chunk; }
hsize_t rounded_up(hsize_t row, hsize_t chunk) { return rounded_down(row + chunk - 1, chunk); }

PetscInt index(std::uint64_t row) { return static_cast<PetscInt>(row); }

std::uint64_t largest(MPI_Comm comm, std::uint64_t own) {
  MPI_Allreduce(MPI_IN_PLACE, &own, 1, MPI_UINT64_T, MPI_MAX, comm);
  return own;
}

/// Rows of a rank: where they begin, how far its whole chunks go, and where they end.
struct Share {
  hsize_t begin = 0;
  hsize_t whole = 0;  ///< first row of these
  hsize_t rest = 0;   ///< first behind them
  hsize_t end = 0;

  Share(hsize_t first, hsize_t count, hsize_t chunk)
      : begin{first},
        whole{std::min(rounded_up(first, chunk), first + count)},
        rest{std::max(whole, rounded_down(first + count, chunk))},
        end{first + count} {}
};

}  // namespace

void Hdf5File::append_records(const std::string& name, const void* records, std::size_t count) {
  const auto* rest = static_cast<const std::byte*>(records);
  append_records(name, count, [&, size = growing_.at(name).size](std::size_t some) {
    return std::exchange(rest, some > 0 ? rest + some * size : rest);
  });
}

void Hdf5File::append_records(const std::string& name, std::size_t count, const NextRecords& next) {
  Growing& data = growing_.at(name);
  const std::uint64_t own = count + data.waiting.size() / data.size;
  std::uint64_t first = 0;
  std::uint64_t all = own;
  MPI_Exscan(&own, &first, 1, MPI_UINT64_T, MPI_SUM, comm_);
  MPI_Allreduce(MPI_IN_PLACE, &all, 1, MPI_UINT64_T, MPI_SUM, comm_);
  first = rank_ == 0 ? 0 : first;
  if (all == 0) {
    return;
  }
  if (data.packed) {
    append_chunks(name, {.begin = index(first), .end = index(first + own), .total = index(all)}, next);
    return;
  }
  spend_on_growth(growth(name, all));
  extend(data, all);
  // All ranks take part in each write.
  write_parts(data, data.rows + first, own, all > kRecordsAtATime ? largest(comm_, own) : 1, next);
  data.rows += all;
}

/// A part at a time: HDF5 and MPI make copies of what they are given. @param most largest count of all ranks
void Hdf5File::write_parts(const Growing& data, hsize_t row, hsize_t count, hsize_t most, const NextRecords& next) {
  for (hsize_t done = 0; done < most; done += kRecordsAtATime) {
    const hsize_t now = std::min(count - std::min(count, done), kRecordsAtATime);
    write_block(data, row + done, now, 0, 1, next(now));
  }
}

/// @param rows where those of this rank stand among all that come or wait
void Hdf5File::append_chunks(const std::string& name, const NodeRange& rows, const NextRecords& next) {
  Growing& data = growing_.at(name);
  const auto total = static_cast<hsize_t>(rows.total);
  const hsize_t stop = data.rows + rounded_down(total, data.chunk_rows);  // what follows waits
  const Share own{data.rows + static_cast<hsize_t>(rows.begin), static_cast<hsize_t>(rows.count()), data.chunk_rows};
  std::vector<std::byte> part;
  const NextRecords take = [&](std::size_t count) -> const void* {  // what waits first
    const auto old = static_cast<std::ptrdiff_t>(std::min<std::size_t>(data.waiting.size(), count * data.size));
    part.assign(data.waiting.begin(), data.waiting.begin() + old);
    data.waiting.erase(data.waiting.begin(), data.waiting.begin() + old);
    const std::size_t more = count * static_cast<std::size_t>(data.size) - part.size();
    const auto* const come = static_cast<const std::byte*>(next(more / data.size));
    part.insert(part.end(), come, come + more);
    return part.data();
  };
  std::vector<std::byte> edges;  // rows of chunks that this rank shares with others
  const auto keep = [&](hsize_t count) {
    const auto* const shared = static_cast<const std::byte*>(take(count));
    edges.insert(edges.end(), shared, shared + count * data.size);
  };
  if (stop > data.rows) {
    spend_on_growth(growth(name, stop - data.rows));
    extend(data, stop - data.rows);
  }
  keep(own.whole - own.begin);
  write_parts(data, own.whole, own.rest - own.whole, largest(comm_, own.rest - own.whole), take);
  keep(own.end - own.rest);
  const hsize_t before = std::min(own.whole, stop) - std::min(own.begin, stop);
  const hsize_t behind = std::min(own.end, stop) - std::min(own.rest, stop);
  if (largest(comm_, before + behind) > 0) {
    write_two(data, {own.begin, before}, {own.rest, behind}, edges.data());
  }
  edges.erase(edges.begin(), edges.begin() + static_cast<std::ptrdiff_t>((before + behind) * data.size));
  data.waiting = gathered(comm_, edges);
  data.rows = stop;
}

/// Two runs of rows in one call. @param one, other first row, and how many
void Hdf5File::write_two(const Growing& data, std::array<hsize_t, 2> one, std::array<hsize_t, 2> other,
                         const void* values) {
  const hsize_t memory = std::max<hsize_t>(one[1] + other[1], 1);
  const Hdf5Id space{H5Dget_space(data.id), H5Sclose};
  const Hdf5Id memory_space{H5Screate_simple(1, &memory, nullptr), H5Sclose};
  bool ok = H5Sselect_none(space) >= 0;
  if (one[1] + other[1] == 0) {
    ok = H5Sselect_none(memory_space) >= 0 && ok;
  }
  for (const auto& [first, count] : {one, other}) {
    ok = (count == 0 || H5Sselect_hyperslab(space, H5S_SELECT_OR, &first, nullptr, &count, nullptr) >= 0) && ok;
  }
  ok = H5Dwrite(data.id, data.type, memory_space, space, transfer_, values) >= 0 && ok;
  agree(ok);
}

void Hdf5File::write_waiting() {
  for (auto& [name, data] : growing_) {
    if (data.packed && data.columns == 0) {
      std::uint64_t count = data.waiting.size() / data.size;
      MPI_Bcast(&count, 1, MPI_UINT64_T, 0, comm_);
      if (count > 0) {
        spend_on_growth(growth(name, count));
        extend(data, count);
        write_block(data, data.rows, rank_ == 0 ? count : 0, 0, 1, data.waiting.data());
        data.waiting.clear();
        data.rows += count;
      }
    }
  }
}

std::map<std::string, std::string> Hdf5File::waiting() const {
  std::map<std::string, std::string> all;
  for (const auto& [name, data] : growing_) {
    if (data.packed && data.columns == 0) {
      all[name].assign(reinterpret_cast<const char*>(data.waiting.data()), data.waiting.size());
    }
  }
  return all;
}

void Hdf5File::set_waiting(const std::string& name, const std::string& records) {
  const auto* const bytes = reinterpret_cast<const std::byte*>(records.data());
  growing_.at(name).waiting.assign(bytes, bytes + (rank_ == 0 ? records.size() : 0));
}

}  // namespace udar::io
