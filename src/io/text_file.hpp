#pragma once
/// @file
/// Text files that rank 0 writes for all, and the numbers in them.

#include <mpi.h>

#include <cstdint>
#include <string>
#include <string_view>

namespace udar {
struct MotionState;
}

namespace udar::io {

/// The one line the user reads when an output file cannot be written.
std::string cannot_write(const std::string& path, const std::string& reason);

/// Writes all of `text` at `offset`; returns errno, 0 if all went well.
int write_fully(int descriptor, std::string_view text, std::int64_t offset);

/// Reads `bytes` at `offset`; returns errno, 0 if all went well. A file that ends before is an error.
int read_fully(int descriptor, char* to, std::size_t bytes, std::uint64_t offset);

/// Of an open file [bytes]; 0 if it cannot be told.
std::uint64_t size_of_file(int descriptor);

/// @brief Appends `value` in the fewest digits that read back to the same double.
void append_number(std::string& text, double value);
void append_number(std::string& text, std::int64_t value);

/// @brief Writes a text file that appears whole, in the place of one before, or not at all.
/// @param[in] text read on rank 0 only @param[in] sync wait until it is on the disk
/// @note Collective. @throws FileError on all ranks
void replace_text(MPI_Comm comm, const std::string& path, const std::string& text, bool sync);

/// @brief What stands in a text file before all text, and what behind it at all times, so that it is always whole.
struct TextFrame {
  std::string header{};
  std::string footer{};
};

/// @brief A text file of which only rank 0 writes. A write that fails leaves the file as it was before it.
class TextFile {
 public:
  /// @brief Creates the file, or empties it; or goes on in it where it stood when `earlier` was saved.
  /// @param earlier null, or of no file of this name: the file is created
  /// @note Collective. @throws FileError on all ranks, also if the file is shorter than it was, or another file
  TextFile(MPI_Comm comm, std::string path, TextFrame frame = {}, const MotionState* earlier = nullptr);
  TextFile(const TextFile&) = delete;
  TextFile& operator=(const TextFile&) = delete;
  ~TextFile();

  /// @brief Puts `text` behind what was appended before.
  /// @param[in] text read on rank 0 only
  /// @note Collective. @throws FileError on all ranks, here and in every later call, if the disk takes no more
  void append(std::string_view text);

  /// @brief Waits until all is on the disk, which is where some file systems report that they are full.
  /// @note Collective. @throws FileError on all ranks
  void sync();

  /// @brief Where the file stands now, for who goes on in it. @note Collective.
  void save(MotionState& state) const;

 private:
  void fail(int error);
  void put(std::string_view text);
  void open_anew(const std::string& header);
  void open_at(std::int64_t size, const std::string& header);

  MPI_Comm comm_;
  std::string path_;
  std::string failure_;
  std::string footer_;     ///< behind the text
  int descriptor_ = -1;    ///< on rank 0
  std::int64_t size_ = 0;  ///< of the text [bytes]
};

}  // namespace udar::io
