#pragma once
/// @file
/// The readers of a case, one per group of options, and what they share.

#include <mpi.h>

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "udar/app/case.hpp"
#include "udar/io/table_file.hpp"

namespace udar::app {

using Strings = std::vector<std::string>;
using Numbers = std::vector<double>;

/// A word of an option and what it stands for.
template <class T>
using Names = std::pair<const char*, T>;

[[nodiscard]] Numbers column(const io::Table& table, std::size_t index);

/// @brief Refuses a table whose first column does not ascend.
/// @param jumps whether two equal values are a jump
/// @throws InputError naming option, file and row
void require_ascending(const char* option, const std::string& path, const Numbers& values, const char* what,
                       bool jumps = false);

/// @name Each reads one group of options, and explains it under `-help`; collective.
/// @{
[[nodiscard]] StructureInput read_structure(MPI_Comm comm);
[[nodiscard]] StartInput read_start(MPI_Comm comm);
[[nodiscard]] ContactInput read_contact(MPI_Comm comm);
[[nodiscard]] OutputInput read_output(MPI_Comm comm);
/// @param unfiltered whether a step must be given
[[nodiscard]] TimeInput read_time(MPI_Comm comm, bool unfiltered);
/// @}

}  // namespace udar::app
