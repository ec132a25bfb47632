#pragma once
/// @file
/// Text files that rank 0 writes for all, and the numbers in them.

#include <mpi.h>

#include <cstdint>
#include <string>
#include <string_view>

namespace udar::io {

/// The one line the user reads when an output file cannot be written.
std::string cannot_write(const std::string& path, const std::string& reason);

/// Writes all of `text` at `offset`; returns errno, 0 if all went well.
int write_fully(int descriptor, std::string_view text, std::int64_t offset);

/// @brief Appends `value` in the fewest digits that read back to the same double.
void append_number(std::string& text, double value);
void append_number(std::string& text, std::int64_t value);

/// @brief A text file of which only rank 0 writes. A write that fails leaves the file as it was before it.
class TextFile {
 public:
  /// @brief Creates the file, or empties it.
  /// @note Collective. @throws FileError on all ranks
  TextFile(MPI_Comm comm, std::string path);
  TextFile(const TextFile&) = delete;
  TextFile& operator=(const TextFile&) = delete;
  ~TextFile();

  /// @brief Puts `text` behind what was appended before, then `footer`, which the next call writes over: the file is
  /// whole after each call.
  /// @param[in] text, footer read on rank 0 only; the footer is the same in every call
  /// @note Collective. @throws FileError on all ranks, here and in every later call, if the disk takes no more
  void append(std::string_view text, std::string_view footer = {});

  /// @brief Waits until all is on the disk, which is where some file systems report that they are full.
  /// @note Collective. @throws FileError on all ranks
  void sync();

 private:
  void fail(int error);

  MPI_Comm comm_;
  std::string path_;
  std::string failure_;
  std::string footer_;     ///< now behind the text
  int descriptor_ = -1;    ///< on rank 0
  std::int64_t size_ = 0;  ///< of the text [bytes]
};

}  // namespace udar::io
