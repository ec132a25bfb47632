#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <iterator>
#include <string_view>

#include "io/file_checksum.hpp"
#include "io/text_file.hpp"
#include "udar/io/hdf5_file.hpp"

// Where a file stands, and how it is put back there.

namespace udar::io {
void Hdf5File::put_back(const Mark& mark) {
  const auto size = static_cast<std::uint64_t>(mark.extents.front());
  std::string reason;
  if (rank_ == 0) {
    descriptor_ = ::open(path_.c_str(), O_RDWR | O_CLOEXEC);
    if (descriptor_ < 0) {
      reason = system_reason(errno);
    } else if (size_of_file(descriptor_) < size) {
      reason = "it is shorter than when the restart file was written: has it been changed?";
    }
  }
  agree(reason.empty(), reason);
  int error = 0;
  std::string_view rest{mark.pieces};
  for (std::size_t i = 1; rank_ == 0 && i + 1 < mark.extents.size() && error == 0; i += 2) {
    const auto length = static_cast<std::size_t>(mark.extents[i + 1]);
    error = write_fully(descriptor_, rest.substr(0, length), static_cast<std::int64_t>(mark.extents[i]));
    rest.remove_prefix(length);
  }
  if (rank_ == 0 && error == 0 && ftruncate(descriptor_, static_cast<off_t>(size)) != 0) {
    error = errno;
  }
  agree(error == 0, system_reason(error));
  flushed_end_ = size;
  haddr_t end = 0;  // values stand between the pieces
  for (std::size_t i = 1; i + 1 < mark.extents.size(); i += 2) {
    note_values(end, static_cast<haddr_t>(mark.extents[i]) - end);
    end = static_cast<haddr_t>(mark.extents[i] + mark.extents[i + 1]);
  }
  note_values(end, size - end);
}

/// Joined with what ends where it begins: there are then no more pieces than HDF5 put other things between.
void Hdf5File::note_values(haddr_t begin, hsize_t bytes) {
  if (bytes == 0) {
    return;
  }
  const auto after = values_.lower_bound(begin);
  if (after != values_.begin() && std::prev(after)->second == begin) {
    std::prev(after)->second = begin + bytes;
  } else {
    values_[begin] = begin + bytes;
  }
}

/// Those that are new since the last call: chunks are never moved, and come in the order of their rows.
void Hdf5File::find_chunks(Growing& data) {
  const hsize_t count = (data.rows + data.chunk_rows - 1) / data.chunk_rows * data.chunks;
  for (; data.chunks_known < count; ++data.chunks_known) {
    const std::array<hsize_t, 3> first{data.chunks_known / data.chunks * data.chunk_rows,
                                       data.chunks_known % data.chunks * data.chunk_columns, 0};
    unsigned filters = 0;
    haddr_t begin = HADDR_UNDEF;
    hsize_t bytes = 0;
    agree(H5Dget_chunk_info_by_coord(data.id, first.data(), &filters, &begin, &bytes) >= 0);
    note_values(begin, bytes);
  }
}

Hdf5File::Mark Hdf5File::mark() {
  flush();
  for (auto& [name, data] : growing_) {
    find_chunks(data);
  }
  Mark mark;
  int error = 0;
  if (rank_ == 0) {
    const std::uint64_t size = size_of_file(descriptor_);
    mark.extents.push_back(static_cast<double>(size));
    const auto keep = [&](haddr_t begin, haddr_t end) {
      if (begin < end) {
        mark.extents.insert(mark.extents.end(), {static_cast<double>(begin), static_cast<double>(end - begin)});
        const std::size_t before = mark.pieces.size();
        mark.pieces.resize(before + (end - begin));
        error = error != 0 ? error : read_fully(descriptor_, mark.pieces.data() + before, end - begin, begin);
      }
    };
    haddr_t done = 0;
    for (const auto& [begin, end] : values_) {
      keep(done, begin);
      done = std::max(done, end);
    }
    keep(done, size);
  }
  agree(error == 0, system_reason(error));
  auto count = static_cast<std::uint64_t>(mark.extents.size());
  MPI_Bcast(&count, 1, MPI_UINT64_T, 0, comm_);
  mark.extents.resize(count);
  MPI_Bcast(mark.extents.data(), static_cast<int>(count), MPI_DOUBLE, 0, comm_);
  return mark;
}

/// One that is there, with the rows it has.
void Hdf5File::open_growing(Growing& data, const std::string& name, int rank) {
  data.id = Hdf5Id{H5Dopen2(file_, name.c_str(), H5P_DEFAULT), H5Dclose};
  agree(data.id.valid());
  const Hdf5Id space{H5Dget_space(data.id), H5Sclose};
  std::array<hsize_t, 3> extent{0, data.columns, data.components};
  const bool alike = H5Sget_simple_extent_ndims(space) == rank &&
                     H5Sget_simple_extent_dims(space, extent.data(), nullptr) == rank &&
                     (rank < 2 || extent[1] == data.columns) && (rank < 3 || extent[2] == data.components);
  agree(alike, name + " has other columns than this run");
  data.rows = extent[0];
  const Hdf5Id creation{H5Dget_create_plist(data.id), H5Pclose};
  std::array<hsize_t, 3> chunk{1, 1, 1};
  agree(creation.valid() && H5Pget_chunk(creation, rank, chunk.data()) == rank);
  data.set_chunk(chunk[0], chunk[1], H5Pget_nfilters(creation) > 0);
  data.chunks_known = (data.rows + data.chunk_rows - 1) / data.chunk_rows * data.chunks;  // the mark knows them
}

}  // namespace udar::io
