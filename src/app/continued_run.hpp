#pragma once
/// @file
/// `udar -continue RUN`: a run that goes on in its own folder, with its own options.

#include <mpi.h>

#include <map>
#include <optional>
#include <string>

#include "udar/io/run_directory.hpp"

namespace udar::app {

/// @brief A run to go on with.
struct ContinuedRun {
  std::string folder;  ///< with all its files
  std::string file;    ///< the restart file there; empty: it begins
  bool known = false;  ///< the folder belongs to this run: its files may go, where it begins
  io::FolderLock lock{};
};

/// @brief Reads `-continue`. The options that the run had come into the database where none are given now, and files
/// are looked for where they were then.
/// @return empty: nothing is to be continued
/// @note Collective. Renames the restart file before the last one, if the last is damaged.
/// @throws InputError if the folder holds no run that can go on; FileError
[[nodiscard]] std::optional<ContinuedRun> take_up_run(MPI_Comm comm);

/// @brief What a restart file must keep for `take_up_run`, by name.
[[nodiscard]] std::map<std::string, std::string> texts_to_go_on();

}  // namespace udar::app
