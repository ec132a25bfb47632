#pragma once
/// @file
/// One HDF5 file that all ranks write or read together.

#include <hdf5.h>
#include <mpi.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "udar/io/point_order.hpp"

namespace udar::io {

/// @brief Owns one HDF5 identifier and closes it once.
class Hdf5Id {
 public:
  using Close = herr_t (*)(hid_t);

  Hdf5Id() noexcept = default;
  Hdf5Id(hid_t id, Close close) noexcept : id_{id}, close_{close} {}
  Hdf5Id(const Hdf5Id&) = delete;
  Hdf5Id& operator=(const Hdf5Id&) = delete;
  Hdf5Id(Hdf5Id&& other) noexcept : id_{other.release()}, close_{other.close_} {}
  Hdf5Id& operator=(Hdf5Id&& other) noexcept;
  ~Hdf5Id() { reset(); }

  operator hid_t() const noexcept { return id_; }  // NOLINT(google-explicit-constructor): HDF5 calls take the raw id
  [[nodiscard]] bool valid() const noexcept { return id_ >= 0; }
  hid_t release() noexcept;
  void reset() noexcept;

 private:
  hid_t id_ = H5I_INVALID_HID;
  Close close_ = nullptr;
};

/// @brief Starts HDF5 and keeps it from closing files when the process ends; for programs, before MPI starts.
///
/// HDF5 started after MPI would flush and close, inside MPI_Finalize, a file given up after an error, and so fail, hang
/// or crash once more. Started before MPI, and kept from doing it at exit, it leaves such a file alone. It is a choice
/// for the whole process, which the library does not make when it is loaded. @note Not collective.
void start_hdf5();

/// @brief A file open on all ranks of a communicator, with collective transfers and collective metadata.
///
/// Every member function is collective and throws `FileError` on all ranks together when a call fails on one. HDF5 over
/// MPI-IO cannot be trusted with a full disk: Open MPI's ranks may then wait for each other for ever. So rank 0 first
/// reserves the space of every write with the operating system; what does not fit is refused before HDF5 hears of it,
/// and what was written before is flushed: the file is whole and readable. Where a file system cannot reserve, its free
/// space is compared instead. If HDF5 still fails on some ranks while others are stuck in the call, the program
/// ends with the message after a minute.
class Hdf5File {
 public:
  enum class Access : std::uint8_t { create, read, go_on };

  /// @brief A file as it was once flushed: all of it but the values of datasets, which no later write changes. HDF5
  /// writes over what this holds, so that a program which is killed may leave it in pieces.
  struct Mark {
    std::vector<double> extents;  ///< size of the file, then begin and length of each piece [bytes]
    std::string pieces;           ///< one behind the other
  };

  /// @brief Creates (empties) or opens the file.
  /// @throws FileError on all ranks if there is no such file, no permission, or it is not HDF5
  Hdf5File(MPI_Comm comm, std::string path, Access access, std::string quantity = "output directory");
  /// @brief Puts the file back to where it was at `mark` and goes on in it: `add_rows` and `add_records` then find the
  /// datasets that are there.
  /// @throws FileError on all ranks, also if the file is shorter than it was
  Hdf5File(MPI_Comm comm, std::string path, const Mark& mark);
  Hdf5File(const Hdf5File&) = delete;
  Hdf5File& operator=(const Hdf5File&) = delete;
  /// @brief Closes a file that was not closed, but leaves it as last flushed after a failure or while an exception
  /// unwinds this rank: the others may be elsewhere. Never throws, never waits for a rank that is gone.
  ~Hdf5File();

  /// @name Writing
  /// @{
  void add_group(const std::string& name);
  void add_attribute(const std::string& object, const std::string& name, const std::string& value);
  void add_attribute(const std::string& object, const std::string& name, double value);
  void add_attribute(const std::string& object, const std::string& name, std::int64_t value);
  void add_attribute(const std::string& object, const std::string& name, std::uint64_t value);
  /// Takes one away that is there, for another value.
  void remove_attribute(const std::string& object, const std::string& name);
  /// A short one-dimensional dataset that every rank has in full.
  void add_small(const std::string& name, std::span<const double> values);
  void add_small(const std::string& name, std::span<const std::int64_t> values);
  /// Rank 0's.
  void add_bytes(const std::string& name, const std::string& bytes);
  /// A dataset with one value per node; each rank gives its nodes.
  void add_node_values(const std::string& name, const NodeRange& nodes, std::span<const double> values);
  /// @param[in] components values a node, a second dimension if there are several
  void add_node_values(const std::string& name, const NodeRange& nodes, std::span<const std::int64_t> values,
                       int components = 1);

  /// @brief A dataset that grows by rows of one value per node, in chunks of about 1 MiB.
  ///
  /// Compressed rows of at least 4 KiB have chunks of their own, so that none is ever written twice: HDF5 would move it
  /// and put others where it stood, which neither a file that a kill left nor a `Mark` could stand. Shorter rows share
  /// chunks and are not compressed.
  /// @param[in] type        HDF5's type of a value, in memory and in the file; copied
  /// @param[in] components  values at a node, a third dimension if there are several
  /// @param[in] compression level of gzip, 1 to 9, behind a shuffle of bytes; 0: none. Of a dataset that is there it
  /// stays as it was
  /// @throws FileError if HDF5 was built without gzip
  void add_rows(const std::string& name, hid_t type, PetscInt nodes, int components = 1, int compression = 0);
  /// @brief A one-dimensional dataset that grows; for compound records, too.
  ///
  /// Where it is compressed, rows that fill no chunk yet wait for those that come, or for `close`.
  /// @param[in] compression as of `add_rows`
  void add_records(const std::string& name, hid_t type, int compression = 0);
  /// @brief Adds one row to a dataset of `add_rows`; each rank gives its nodes.
  void append_row(const std::string& name, const NodeRange& nodes, const void* values) {
    append_rows(name, nodes, 1, values);
  }
  /// Several at once, row after row.
  void append_rows(const std::string& name, const NodeRange& nodes, std::size_t rows, const void* values);
  /// @brief Adds records to a dataset of `add_records`: each rank's, one rank's behind the other's.
  /// @param[in] count of this rank's
  void append_records(const std::string& name, const void* records, std::size_t count);
  /// Gives the next so many records, which stay there until it is called again.
  using NextRecords = std::function<const void*(std::size_t)>;
  /// The same a part at a time.
  void append_records(const std::string& name, std::size_t count, const NextRecords& next);
  /// @name Of each compressed table the records that wait, on rank 0: of who goes on from a `Mark`
  /// @{
  [[nodiscard]] std::map<std::string, std::string> waiting() const;
  void set_waiting(const std::string& name, const std::string& records);
  /// @}
  /// @brief Makes room for `bytes` of coming writes until the next `flush`, so that they fail before the first or not
  /// at all.
  void reserve(std::uint64_t bytes);
  /// Rows, or records, of a dataset that grows.
  [[nodiscard]] std::size_t rows(const std::string& name) const { return growing_.at(name).rows; }
  /// Bytes by which the next row of this dataset makes the file longer.
  [[nodiscard]] std::uint64_t growth(const std::string& name, std::size_t rows = 1) const;

  /// @brief Brings all to the disk: what was written until now survives the end of the program, however it comes.
  void flush();
  /// @brief The same once a second, for those who write often: waiting for the disk takes milliseconds.
  /// @return whether it flushed
  bool flush_if_due();
  /// @brief Flushes, and tells where the file stands: the pieces on rank 0 alone.
  [[nodiscard]] Mark mark();
  /// @brief Flushes and closes; nothing may be called afterwards.
  void close();
  /// @}

  /// @name Reading
  /// @{
  [[nodiscard]] bool has(const std::string& object, const std::string& attribute);
  [[nodiscard]] std::string read_text(const std::string& object, const std::string& name);
  [[nodiscard]] double read_double(const std::string& object, const std::string& name);
  [[nodiscard]] std::int64_t read_int(const std::string& object, const std::string& name);
  [[nodiscard]] std::uint64_t read_uint(const std::string& object, const std::string& name);
  /// Names of the attributes of an object, and of the datasets in a group in the order they were added.
  [[nodiscard]] std::vector<std::string> attribute_names(const std::string& object);
  [[nodiscard]] std::vector<std::string> dataset_names(const std::string& group);
  [[nodiscard]] std::vector<double> read_small(const std::string& name);
  [[nodiscard]] std::string read_bytes(const std::string& name);
  /// This rank's nodes of a dataset with one value per node. @throws FileError if it has another number of nodes
  [[nodiscard]] std::vector<double> read_node_values(const std::string& name, const NodeRange& nodes);
  /// @}

  /// @brief Throws `FileError` on all ranks with a message on this file unless `ok` is true on every rank.
  /// @param[in] reason what is wrong; empty for what HDF5 says about its last call
  void agree(bool ok, const std::string& reason = {});

 private:
  struct Growing {
    Hdf5Id id;
    Hdf5Id type;
    hsize_t size = 0;        ///< of a value [bytes]
    hsize_t rows = 0;        ///< written
    hsize_t columns = 0;     ///< 0: one-dimensional
    hsize_t components = 1;  ///< of a value in a column
    hsize_t chunk_rows = 0;  ///< rows of a chunk
    hsize_t chunk_columns = 1;
    hsize_t chunks = 0;                ///< that make a row of chunks
    hsize_t space = 0;                 ///< that a chunk may take while it is written [bytes]
    hsize_t chunks_known = 0;          ///< of all, in HDF5's order, those in `values_`
    bool packed = false;               ///< compressed
    std::vector<std::byte> waiting{};  ///< records of the chunk that is not full, if compressed, on rank 0

    void set_chunk(hsize_t rows_of_it, hsize_t columns_of_it, bool compressed);
  };

  void create();
  void open();
  void put_back(const Mark& mark);
  void open_growing(Growing& data, const std::string& name, int rank);
  void note_values(haddr_t begin, hsize_t bytes);
  void find_chunks(Growing& data);
  [[nodiscard]] Hdf5Id access_together();
  void set_transfer();
  void abandon() noexcept;
  void add_growing(const std::string& name, hid_t type, hsize_t columns, hsize_t components = 1, int compression = 0);
  void create_growing(Growing& data, const std::string& name, int rank, int compression);
  void add_attribute_of(const std::string& object, const std::string& name, hid_t type, const void* value);
  void read_attribute_of(const std::string& object, const std::string& name, hid_t type, void* value);
  void add_dataset(const std::string& name, hid_t type, const NodeRange& range, const void* values, int components = 1);
  [[nodiscard]] NodeRange on_first(std::size_t size) const;
  void claim(std::uint64_t bytes);
  void spend(std::uint64_t bytes);
  void spend_on_growth(std::uint64_t bytes);
  void require_usable() const;
  void extend(Growing& data, hsize_t rows);
  void write_parts(const Growing& data, hsize_t row, hsize_t count, hsize_t most, const NextRecords& next);
  void append_chunks(const std::string& name, const NodeRange& rows, const NextRecords& next);
  void write_two(const Growing& data, std::array<hsize_t, 2> one, std::array<hsize_t, 2> other, const void* values);
  void write_waiting();
  void write_block(const Growing& data, hsize_t row, hsize_t rows, hsize_t column, hsize_t columns, const void* values);
  [[nodiscard]] std::string message(const std::string& reason) const;

  MPI_Comm comm_;
  int rank_ = 0;
  std::string path_;
  std::string quantity_;
  Access access_;
  Hdf5Id file_;
  Hdf5Id transfer_;  ///< property list of collective transfers
  std::map<std::string, Growing> growing_;
  std::map<haddr_t, haddr_t> values_;  ///< where values of datasets stand, known so far: begin and end [bytes]
  int exceptions_ = 0;                 ///< in flight on this rank at construction
  bool failed_ = false;                ///< an HDF5 call failed on some rank: HDF5 must not touch the file again
  int descriptor_ = -1;                ///< rank 0's own handle on the file, to reserve space
  std::uint64_t flushed_end_ = 0;      ///< size of the file after the last flush, on rank 0 [bytes]
  std::uint64_t pending_ = 0;          ///< reserved behind it
  std::uint64_t credit_ = 0;           ///< of that, not yet used by a write
  std::chrono::steady_clock::time_point flushed_at_;  ///< rank 0's clock decides
};

}  // namespace udar::io
