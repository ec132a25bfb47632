#pragma once
/// @file
/// Files that the user names.

#include <mpi.h>

#include <cstddef>
#include <string>

namespace udar::io {

/// What is wrong with a file that the user named, to follow its name; caught in this room.
struct Complaint {
  std::string text;
};

/// @brief Where a file is: a relative path is one from the working directory, else from the folder of `beside`, else
/// from that of an options file, the last one first.
/// @param beside another file, empty: none @note Not collective. @throws Complaint
[[nodiscard]] std::string find_file(const std::string& path, const std::string& beside = {});

/// @brief All of the file that `find_file` finds. @note Not collective. @throws Complaint
[[nodiscard]] std::string read_file(const std::string& path);

/// @brief The same by rank 0, on all ranks.
/// @param quantity what the file gives, for the message @note Collective. @throws FileError on all ranks
[[nodiscard]] std::string share_file(MPI_Comm comm, const std::string& quantity, const std::string& path);

/// @brief Gives all ranks the bytes of rank 0, any number of them. @note Collective.
void broadcast(MPI_Comm comm, void* bytes, std::size_t count);

}  // namespace udar::io
