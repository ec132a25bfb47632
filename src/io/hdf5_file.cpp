#include "udar/io/hdf5_file.hpp"

#include <fcntl.h>
#include <semaphore.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <thread>
#include <tuple>
#include <utility>

#include "io/file_checksum.hpp"
#include "io/hdf5_types.hpp"
#include "io/text_file.hpp"
#include "udar/petsc/error.hpp"

namespace udar::io {
namespace {

/// Size of a chunk of a dataset that grows: what one request to a parallel file system should at least carry.
constexpr hsize_t kChunkBytes = hsize_t{1} << 20;
/// At most so many rows of a short beam share a chunk, or a short run would be mostly empty space.
constexpr hsize_t kChunkRowsMax = 64;
/// Compressed rows of at least so many bytes are chunks: shorter ones would have more of an index than they save.
constexpr hsize_t kPackedRowBytes = 4096;
/// Records in a chunk: some 64 KiB.
constexpr hsize_t kChunkRecords = 1024;
/// Space an index entry of a chunk takes at most, half-filled tree nodes and their parents included.
constexpr hsize_t kIndexBytesPerChunk = 256;
/// Space for what HDF5 adds by itself when it makes an object or extends one: headers, heaps, tree nodes.
constexpr std::uint64_t kMetadataBytesPerCall = std::uint64_t{1} << 13;
/// Space always kept behind that, so that nothing in HDF5 ever meets the end of the disk.
constexpr std::uint64_t kMetadataBytes = std::uint64_t{1} << 16;
/// How long what was written may wait for the disk: flushing after each of the rows that a small run writes in
/// milliseconds took most of its time, and who watches a run does not see less than a second.
constexpr std::chrono::seconds kFlushInterval{1};
/// How long a rank whose HDF5 call failed waits for the others to come out of theirs before they count as stuck.
constexpr std::chrono::seconds kLongestWait{60};

/// Open MPI guards a shared file pointer, which nobody uses here, by a semaphore that is named after the file without
/// its folder. A run that is killed while it opens one leaves it locked, and the first rank of every later run that
/// opens a file of that name would wait for it for ever. One at work loses no more than its name.
void drop_semaphore(const std::string& path) {
  sem_unlink(("/OMPIO_" + std::filesystem::path{path}.filename().string()).c_str());
}

herr_t keep_innermost(unsigned position, const H5E_error2_t* error, void* text) {
  if (position == 0 && error->desc != nullptr) {
    *static_cast<std::string*>(text) = error->desc;
  }
  return 0;
}

bool disk_is_full(const std::string& path) {
  struct statvfs disk{};
  return statvfs(path.c_str(), &disk) == 0 &&
         static_cast<std::uint64_t>(disk.f_bavail) * disk.f_frsize < kMetadataBytes;
}

/// What HDF5 says about its last call; it does not pass on the system's reason, but a full disk can be seen.
std::string hdf5_reason(const std::string& path) {
  std::string text;
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, keep_innermost, &text);
  text = text.empty() ? "an HDF5 call failed" : "HDF5: " + text;
  return disk_is_full(path) ? system_reason(ENOSPC) + " (" + text + ")" : text;
}

/// Reserves `[begin, begin + bytes)` of a file without changing its size; returns errno, 0 if all went well.
int reserve_space(int descriptor, std::uint64_t begin, std::uint64_t bytes) {
  rlimit limit{};
  if (getrlimit(RLIMIT_FSIZE, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY && begin + bytes > limit.rlim_cur) {
    return EFBIG;
  }
#ifdef FALLOC_FL_KEEP_SIZE
  int result = -1;
  do {
    result = fallocate(descriptor, FALLOC_FL_KEEP_SIZE, static_cast<off_t>(begin), static_cast<off_t>(bytes));
  } while (result != 0 && errno == EINTR);
  if (result == 0) {
    return 0;
  }
  if (errno != EOPNOTSUPP && errno != ENOSYS) {
    return errno;
  }
#endif
  struct statvfs disk{};
  const bool full =
      fstatvfs(descriptor, &disk) == 0 && static_cast<std::uint64_t>(disk.f_bavail) * disk.f_frsize < bytes;
  return full ? ENOSPC : 0;
}

/// Returns when all ranks take part in `request`; ends the program if they do not.
void wait_for_others(MPI_Comm comm, MPI_Request* request, const std::string& text) {
  const auto start = std::chrono::steady_clock::now();
  int arrived = 0;
  for (MPI_Test(request, &arrived, MPI_STATUS_IGNORE); arrived == 0; MPI_Test(request, &arrived, MPI_STATUS_IGNORE)) {
    if (std::chrono::steady_clock::now() - start > kLongestWait) {
      std::fprintf(stderr, "udar: %s\n", text.c_str());
      MPI_Abort(comm, 1);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds{1});
  }
}

}  // namespace

void start_hdf5() {
  H5dont_atexit();
  H5open();
}

Hdf5File::Hdf5File(MPI_Comm comm, std::string path, Access access, std::string quantity)
    : comm_{comm},
      path_{std::move(path)},
      quantity_{std::move(quantity)},
      access_{access},
      exceptions_{std::uncaught_exceptions()} {
  MPI_Comm_rank(comm_, &rank_);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  try {
    if (access_ == Access::create) {
      create();
    } else {
      open();
    }
  } catch (...) {
    abandon();
    throw;
  }
}

Hdf5File::Hdf5File(MPI_Comm comm, std::string path, const Mark& mark)
    : comm_{comm},
      path_{std::move(path)},
      quantity_{"output directory"},
      access_{Access::go_on},
      exceptions_{std::uncaught_exceptions()} {
  MPI_Comm_rank(comm_, &rank_);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  try {
    put_back(mark);
    open();
  } catch (...) {
    abandon();
    throw;
  }
}

Hdf5File::~Hdf5File() {
  int finalized = 0;
  MPI_Finalized(&finalized);
  if (!failed_ && finalized == 0 && std::uncaught_exceptions() == exceptions_) {
    try {
      close();
      return;
    } catch (const FileError&) {
      // Whoever wants to know calls close() or flush() before.
    }
  }
  abandon();
}

void Hdf5File::abandon() noexcept {
  for (auto& [name, data] : growing_) {
    data.id.release();
    data.type.release();
  }
  file_.release();
  transfer_.release();
  if (descriptor_ >= 0) {
    ::close(std::exchange(descriptor_, -1));
  }
}

std::string Hdf5File::message(const std::string& reason) const {
  return quantity_ + (access_ == Access::read ? ": cannot read '" : ": cannot write '") + path_ + "': " + reason;
}

void Hdf5File::agree(bool ok, const std::string& reason) {
  std::string text;
  int flag = 0;
  if (!ok) {
    text = message(reason.empty() ? hdf5_reason(path_) : reason);
    flag = reason.empty() ? 2 : 1;
  }
  int flags = 0;
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Iallreduce(&flag, &flags, 1, MPI_INT, MPI_BOR, comm_, &request);
  if (!ok) {
    wait_for_others(comm_, &request, text);
  }
  MPI_Wait(&request, MPI_STATUS_IGNORE);
  if (flags != 0) {
    failed_ = failed_ || (flags & 2) != 0;
    throw_together<FileError>(comm_, text);
  }
}

void Hdf5File::create() {
  // The system's own call first: it tells why there can be no such file.
  if (rank_ == 0) {
    descriptor_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  }
  agree(rank_ != 0 || descriptor_ >= 0, system_reason(errno));
  const int error = rank_ == 0 ? reserve_space(descriptor_, 0, kMetadataBytes) : 0;
  agree(error == 0, system_reason(error));

  file_ = Hdf5Id{H5Fcreate(path_.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access_together()), H5Fclose};
  agree(file_.valid());
  set_transfer();
}

void Hdf5File::open() {
  std::string reason;
  if (rank_ == 0) {
    const int descriptor = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC);
    if (descriptor < 0) {
      reason = system_reason(errno);
    } else {
      ::close(descriptor);
      if (H5Fis_hdf5(path_.c_str()) <= 0) {
        reason = "not an HDF5 file";
      }
    }
  }
  agree(reason.empty(), reason);

  const unsigned writing = access_ == Access::go_on ? H5F_ACC_RDWR : H5F_ACC_RDONLY;
  file_ = Hdf5Id{H5Fopen(path_.c_str(), writing, access_together()), H5Fclose};
  agree(file_.valid());
  set_transfer();
}

/// Metadata are the business of all ranks at once.
Hdf5Id Hdf5File::access_together() {
  if (rank_ == 0) {
    drop_semaphore(path_);
  }
  Hdf5Id access{H5Pcreate(H5P_FILE_ACCESS), H5Pclose};
  bool ok = H5Pset_fapl_mpio(access, comm_, MPI_INFO_NULL) >= 0;
  ok = ok && H5Pset_coll_metadata_write(access, true) >= 0;
  ok = ok && H5Pset_all_coll_metadata_ops(access, true) >= 0;
  agree(ok);
  return access;
}

void Hdf5File::set_transfer() {
  // All ranks enter each transfer together, but inside each writes its own block, which is contiguous: gathering the
  // blocks first would gain nothing, and Open MPI's gathering writes lose errors on the way.
  transfer_ = Hdf5Id{H5Pcreate(H5P_DATASET_XFER), H5Pclose};
  agree(H5Pset_dxpl_mpio(transfer_, H5FD_MPIO_COLLECTIVE) >= 0 &&
        H5Pset_dxpl_mpio_collective_opt(transfer_, H5FD_MPIO_INDIVIDUAL_IO) >= 0);
}

void Hdf5File::reserve(std::uint64_t bytes) {
  if (bytes > 0) {
    claim(bytes);
  }
}

void Hdf5File::claim(std::uint64_t bytes) {
  require_usable();
  const std::uint64_t wanted = pending_ + bytes + kMetadataBytesPerCall;
  // Behind the end of the file at the last flush, which is where HDF5 adds.
  int error = rank_ == 0 ? reserve_space(descriptor_, flushed_end_, wanted + kMetadataBytes) : 0;
  MPI_Bcast(&error, 1, MPI_INT, 0, comm_);
  if (error != 0) {
    flush();  // what was written before has its space
  }
  agree(error == 0, system_reason(error));
  pending_ = wanted;
  credit_ += bytes;
}

void Hdf5File::spend(std::uint64_t bytes) {
  require_usable();
  if (credit_ < bytes || bytes == 0) {
    claim(bytes);
  }
  credit_ -= bytes;
}

/// Space for new chunks. Rows in those there are need none, nor do their dataset's headers, which are written over.
void Hdf5File::spend_on_growth(std::uint64_t bytes) {
  require_usable();
  if (bytes > 0) {
    spend(bytes);
  }
}

void Hdf5File::require_usable() const {
  if (failed_ || !file_.valid()) {
    throw FileError{message("given up after an earlier error")};
  }
}

void Hdf5File::flush() {
  require_usable();
  const std::uint64_t before = rank_ == 0 ? size_of_file(descriptor_) : 0;
  // HDF5 writes where the file ends before it sets its size: readers refuse what a kill leaves between the two. So the
  // file first grows beyond any end it may get, here of empty space, and HDF5 cuts it where it ends.
  const std::uint64_t grown = std::max(before, flushed_end_ + pending_ + kMetadataBytes + 1);
  const bool grows = rank_ == 0 && pending_ > 0 && ftruncate(descriptor_, static_cast<off_t>(grown)) == 0;
  MPI_Barrier(comm_);
  agree(H5Fflush(file_, H5F_SCOPE_GLOBAL) >= 0);
  if (rank_ == 0) {
    if (grows && size_of_file(descriptor_) == grown) {  // HDF5 cuts where its end has moved only
      std::ignore = ftruncate(descriptor_, static_cast<off_t>(before));
    }
    const std::uint64_t end = size_of_file(descriptor_);
    assert(end <= flushed_end_ + pending_ + kMetadataBytes);  // else too little was reserved
    flushed_end_ = std::max(flushed_end_, end);
  }
  pending_ = 0;
  credit_ = 0;
  flushed_at_ = std::chrono::steady_clock::now();
}

bool Hdf5File::flush_if_due() {
  int due = std::chrono::steady_clock::now() - flushed_at_ >= kFlushInterval ? 1 : 0;
  MPI_Bcast(&due, 1, MPI_INT, 0, comm_);
  if (due != 0) {
    flush();
  }
  return due != 0;
}

void Hdf5File::close() {
  if (!file_.valid()) {
    return;
  }
  if (access_ != Access::read) {
    write_waiting();
    flush();
  }
  growing_.clear();
  transfer_.reset();
  agree(H5Fclose(file_.release()) >= 0);
  if (descriptor_ >= 0) {
    ::close(std::exchange(descriptor_, -1));
  }
}

// Writing

void Hdf5File::add_group(const std::string& name) {
  spend(0);
  const Hdf5Id creation{H5Pcreate(H5P_GROUP_CREATE), H5Pclose};
  agree(H5Pset_link_creation_order(creation, H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED) >= 0);
  const Hdf5Id group{H5Gcreate2(file_, name.c_str(), H5P_DEFAULT, creation, H5P_DEFAULT), H5Gclose};
  agree(group.valid());
}

void Hdf5File::add_attribute_of(const std::string& object, const std::string& name, hid_t type, const void* value) {
  spend(2 * H5Tget_size(type));  // it may move once
  const Hdf5Id space{H5Screate(H5S_SCALAR), H5Sclose};
  const Hdf5Id attribute{
      H5Acreate_by_name(file_, object.c_str(), name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
      H5Aclose};
  agree(attribute.valid());
  agree(H5Awrite(attribute, type, value) >= 0);
}

void Hdf5File::add_attribute(const std::string& object, const std::string& name, const std::string& value) {
  std::string text = value.substr(0, kAttributeBytesMax);
  text.resize(std::max<std::size_t>(text.size(), 1), '\0');
  add_attribute_of(object, name, text_type(text.size()), text.data());
}

void Hdf5File::add_attribute(const std::string& object, const std::string& name, double value) {
  add_attribute_of(object, name, H5T_NATIVE_DOUBLE, &value);
}

void Hdf5File::add_attribute(const std::string& object, const std::string& name, std::int64_t value) {
  add_attribute_of(object, name, H5T_NATIVE_INT64, &value);
}

void Hdf5File::add_attribute(const std::string& object, const std::string& name, std::uint64_t value) {
  add_attribute_of(object, name, H5T_NATIVE_UINT64, &value);
}

void Hdf5File::remove_attribute(const std::string& object, const std::string& name) {
  if (has(object, name)) {
    spend(0);
    agree(H5Adelete_by_name(file_, object.c_str(), name.c_str(), H5P_DEFAULT) >= 0);
  }
}

void Hdf5File::add_dataset(const std::string& name, hid_t type, const NodeRange& range, const void* values,
                           int components) {
  using Extent = std::array<hsize_t, 2>;
  const auto width = static_cast<hsize_t>(components);
  const int dimensions = components > 1 ? 2 : 1;
  const Extent total{count_of(range.total), width};
  const Extent begin{count_of(range.begin), 0};
  const Extent count{count_of(range.count()), width};
  const Extent memory{std::max<hsize_t>(count[0], 1), width};
  spend(total[0] * width * H5Tget_size(type));
  const Hdf5Id creation{H5Pcreate(H5P_DATASET_CREATE), H5Pclose};
  const Hdf5Id space{H5Screate_simple(dimensions, total.data(), nullptr), H5Sclose};
  const Hdf5Id memory_space{H5Screate_simple(dimensions, memory.data(), nullptr), H5Sclose};
  bool ok = H5Pset_fill_time(creation, H5D_FILL_TIME_NEVER) >= 0;
  if (count[0] > 0) {
    ok = ok && H5Sselect_hyperslab(space, H5S_SELECT_SET, begin.data(), nullptr, count.data(), nullptr) >= 0;
  } else {
    ok = ok && H5Sselect_none(space) >= 0 && H5Sselect_none(memory_space) >= 0;
  }
  agree(ok);
  const Hdf5Id data{H5Dcreate2(file_, name.c_str(), type, space, H5P_DEFAULT, creation, H5P_DEFAULT), H5Dclose};
  agree(data.valid());
  if (range.total > 0) {
    agree(H5Dwrite(data, type, memory_space, space, transfer_, values) >= 0);
    note_values(H5Dget_offset(data), total[0] * width * H5Tget_size(type));
  }
}

/// All of a short dataset, which rank 0 writes.
NodeRange Hdf5File::on_first(std::size_t size) const {
  const auto all = static_cast<PetscInt>(size);
  return {.begin = rank_ == 0 ? 0 : all, .end = all, .total = all};
}

void Hdf5File::add_small(const std::string& name, std::span<const double> values) {
  add_dataset(name, H5T_NATIVE_DOUBLE, on_first(values.size()), values.data());
}

void Hdf5File::add_small(const std::string& name, std::span<const std::int64_t> values) {
  add_dataset(name, H5T_NATIVE_INT64, on_first(values.size()), values.data());
}

void Hdf5File::add_bytes(const std::string& name, const std::string& bytes) {
  auto size = static_cast<std::uint64_t>(bytes.size());
  MPI_Bcast(&size, 1, MPI_UINT64_T, 0, comm_);
  add_dataset(name, H5T_NATIVE_UINT8, on_first(size), bytes.data());
}

void Hdf5File::add_node_values(const std::string& name, const NodeRange& nodes, std::span<const double> values) {
  assert(values.size() == count_of(nodes.count()));
  add_dataset(name, H5T_NATIVE_DOUBLE, nodes, values.data());
}

void Hdf5File::add_node_values(const std::string& name, const NodeRange& nodes, std::span<const std::int64_t> values,
                               int components) {
  assert(values.size() == count_of(nodes.count()) * static_cast<std::size_t>(components));
  add_dataset(name, H5T_NATIVE_INT64, nodes, values.data(), components);
}

void Hdf5File::add_rows(const std::string& name, hid_t type, PetscInt nodes, int components, int compression) {
  add_growing(name, type, count_of(nodes), static_cast<hsize_t>(components), compression);
}

void Hdf5File::add_records(const std::string& name, hid_t type, int compression) {
  add_growing(name, type, 0, 1, compression);
}

void Hdf5File::add_growing(const std::string& name, hid_t type, hsize_t columns, hsize_t components, int compression) {
  Growing data;
  data.type = Hdf5Id{H5Tcopy(type), H5Tclose};
  data.size = H5Tget_size(type);
  data.columns = columns;
  data.components = components;
  const int rank = columns == 0 ? 1 : (components == 1 ? 2 : 3);
  if (access_ == Access::go_on && H5Lexists(file_, name.c_str(), H5P_DEFAULT) > 0) {
    open_growing(data, name, rank);
  } else {
    create_growing(data, name, rank, compression);
  }
  growing_.insert_or_assign(name, std::move(data));
}

void Hdf5File::create_growing(Growing& data, const std::string& name, int rank, int compression) {
  const hsize_t cell = data.size * data.components;
  const bool packed = compression > 0 && (data.columns == 0 || data.columns * cell >= kPackedRowBytes);
  hsize_t chunk_columns = 1;
  hsize_t chunk_rows = kChunkRecords;
  if (data.columns > 0) {
    const hsize_t chunks = (data.columns * cell + kChunkBytes - 1) / kChunkBytes;
    chunk_columns = (data.columns + chunks - 1) / chunks;
    chunk_rows = packed ? 1 : std::clamp<hsize_t>(kChunkBytes / (chunk_columns * cell), 1, kChunkRowsMax);
  }
  data.set_chunk(chunk_rows, chunk_columns, packed);
  spend(0);
  const std::array<hsize_t, 3> extent{0, data.columns, data.components};
  const std::array<hsize_t, 3> most{H5S_UNLIMITED, data.columns, data.components};
  const std::array<hsize_t, 3> chunk{data.chunk_rows, chunk_columns, data.components};
  const Hdf5Id space{H5Screate_simple(rank, extent.data(), most.data()), H5Sclose};
  const Hdf5Id creation{H5Pcreate(H5P_DATASET_CREATE), H5Pclose};
  // Every value in the extent is written, so none needs filling.
  agree(space.valid() && H5Pset_chunk(creation, rank, chunk.data()) >= 0 &&
        H5Pset_fill_time(creation, H5D_FILL_TIME_NEVER) >= 0);
  if (packed) {
    agree(H5Zfilter_avail(H5Z_FILTER_DEFLATE) > 0, "this HDF5 was built without gzip, which compression needs");
    agree(H5Pset_shuffle(creation) >= 0 && H5Pset_deflate(creation, static_cast<unsigned>(compression)) >= 0);
  }
  data.id = Hdf5Id{H5Dcreate2(file_, name.c_str(), data.type, space, H5P_DEFAULT, creation, H5P_DEFAULT), H5Dclose};
  agree(data.id.valid());
}

/// A compressed chunk may be longer than what it holds, by 13 bytes and a thousandth (zlib), and has two places for a
/// moment: HDF5 makes room for it before it knows how long it is.
void Hdf5File::Growing::set_chunk(hsize_t rows_of_it, hsize_t columns_of_it, bool compressed) {
  packed = compressed;
  chunk_rows = rows_of_it;
  chunk_columns = columns == 0 ? 1 : columns_of_it;
  chunks = columns == 0 ? 1 : (columns + chunk_columns - 1) / chunk_columns;
  const hsize_t bytes = chunk_rows * chunk_columns * size * components;
  space = (packed ? 2 * (bytes + bytes / 512 + 64) : bytes) + kIndexBytesPerChunk;
}

std::uint64_t Hdf5File::growth(const std::string& name, std::size_t rows) const {
  const Growing& data = growing_.at(name);
  const hsize_t before = (data.rows + data.chunk_rows - 1) / data.chunk_rows;
  const hsize_t after = (data.rows + rows + data.chunk_rows - 1) / data.chunk_rows;
  return (after - before) * data.chunks * data.space;
}

void Hdf5File::extend(Growing& data, hsize_t rows) {
  const std::array<hsize_t, 3> extent{data.rows + rows, data.columns, data.components};
  agree(H5Dset_extent(data.id, extent.data()) >= 0);
}

void Hdf5File::write_block(const Growing& data, hsize_t row, hsize_t rows, hsize_t column, hsize_t columns,
                           const void* values) {
  const std::array<hsize_t, 3> start{row, column, 0};
  const std::array<hsize_t, 3> count{rows, columns, data.components};
  const hsize_t total = rows * columns * data.components;
  const hsize_t memory = std::max<hsize_t>(total, 1);
  const Hdf5Id space{H5Dget_space(data.id), H5Sclose};
  const Hdf5Id memory_space{H5Screate_simple(1, &memory, nullptr), H5Sclose};
  bool ok = true;
  if (total > 0) {
    ok = H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr) >= 0;
  } else {
    ok = H5Sselect_none(space) >= 0 && H5Sselect_none(memory_space) >= 0;
  }
  ok = H5Dwrite(data.id, data.type, memory_space, space, transfer_, values) >= 0 && ok;
  agree(ok);
}

void Hdf5File::append_rows(const std::string& name, const NodeRange& nodes, std::size_t rows, const void* values) {
  Growing& data = growing_.at(name);
  spend_on_growth(growth(name, rows));
  extend(data, rows);
  write_block(data, data.rows, rows, count_of(nodes.begin), count_of(nodes.count()), values);
  data.rows += rows;
}

}  // namespace udar::io
