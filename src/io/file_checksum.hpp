#pragma once
/// @file
/// A checksum over all bytes of a file, in a line at its end.

#include <mpi.h>

#include <string>

namespace udar::io {

/// @brief What the system says of a value of `errno`.
[[nodiscard]] std::string system_reason(int error);

/// @brief Puts a line with length and CRC-32 of the file behind its last byte. HDF5 does not mind what follows its own.
/// @param[in] path of a file that is closed on all ranks
/// @return what went wrong, empty if nothing did; the same on every rank
/// @note Collective; each rank reads its share of the file.
[[nodiscard]] std::string append_checksum(MPI_Comm comm, const std::string& path);

/// @brief What is wrong with a file.
struct ChecksumFailure {
  std::string text;         ///< empty: nothing
  bool unreadable = false;  ///< the system does not let it be read, whatever it is like
};

/// @brief Whether the file is byte for byte as it was when `append_checksum` left it. No library has to understand
/// bytes that are damaged: HDF5 may hang or crash on them.
/// @return the same on every rank
/// @note Collective; each rank reads its share of the file.
[[nodiscard]] ChecksumFailure checksum_failure(MPI_Comm comm, const std::string& path);

}  // namespace udar::io
