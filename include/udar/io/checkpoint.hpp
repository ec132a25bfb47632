#pragma once
/// @file
/// restart.h5: the complete state of a run, from which another can go on.

#include <mpi.h>

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "udar/io/layout.hpp"

namespace udar::io {

/// @brief The state at one time, as named numbers; who writes it knows what they mean. Doubles come back bit by bit.
struct Checkpoint {
  /// Values per node, flags included: this rank's nodes in order. The same names in the same order on every rank.
  std::vector<std::pair<std::string, std::vector<double>>> node_fields;
  std::map<std::string, double> scalars;              ///< equal on every rank
  std::map<std::string, std::vector<double>> tables;  ///< small, of any length, equal on every rank
  std::string case_text;                              ///< tells a restart with another case
};

/// @brief Writes a checkpoint to `path`. A run that is killed meanwhile, or finds the disk full, leaves the older file.
/// @param[in] nodes of this rank
/// @note Collective. Needs the disk space of the old and the new file together.
/// @throws FileError on all ranks
void write_checkpoint(MPI_Comm comm, const NodeRange& nodes, const std::string& path, const Checkpoint& checkpoint);

/// @brief Reads the checkpoint at `path`, written on any number of ranks.
/// @param[in] nodes of this rank
/// @note Collective. Fields come in the order they were written in.
/// @throws FileError on all ranks, naming `-restart_file`, if there is no such file, it is no checkpoint, damaged, or
/// of another number of nodes
[[nodiscard]] Checkpoint read_checkpoint(MPI_Comm comm, const NodeRange& nodes, const std::string& path);

}  // namespace udar::io
