#pragma once
/// @file
/// restart.h5: the complete state of a run, from which another can go on.

#include <functional>
#include <map>
#include <span>
#include <string>

#include "udar/io/point_order.hpp"
#include "udar/motion/motion_state.hpp"

namespace udar::io {

/// @brief Writes a checkpoint to `path`, points and cells in the user's order, and keeps the one that was there at
/// `previous_checkpoint`. A run that is killed meanwhile, or finds the disk full, leaves the older file at one of both.
/// Doubles come back bit by bit.
/// @param cells their order; may be null if the state has nothing in cells
/// @note Collective. Needs the disk space of three.
/// @throws FileError on all ranks
void write_checkpoint(const PointOrder& points, const std::string& path, const MotionState& state,
                      const PointOrder* cells = nullptr);

/// @brief Where the checkpoint before the one at `path` is kept: "restart.previous.h5" for "restart.h5".
[[nodiscard]] std::string previous_checkpoint(const std::string& path);

/// @brief What is wrong with the bytes of the checkpoint at `path`; empty: it is whole.
/// @note Collective. @throws FileError on all ranks if it cannot be read
[[nodiscard]] std::string checkpoint_damage(MPI_Comm comm, const std::string& path);

/// @brief What can be known of a checkpoint by who does not yet know what it is one of.
struct CheckpointHead {
  std::map<std::string, std::string> texts;
  bool begun = false;  ///< there is a state to go on from; false: the run was killed before its first step
};

/// @pre `checkpoint_damage` found none @note Collective. @throws as `read_checkpoint`
[[nodiscard]] CheckpointHead read_checkpoint_head(MPI_Comm comm, const std::string& path);

/// @brief Reads the checkpoint at `path`, written on any number of ranks.
/// @param[in] accept judges the parameters before anything else is read; throws on all ranks if it does not
/// @param[in] cells  as it was written with
/// @note Collective.
/// @throws FileError on all ranks, naming `-restart_file`, if there is no such file, it is no checkpoint, damaged, or
/// of another number of nodes
[[nodiscard]] MotionState read_checkpoint(const PointOrder& points, const std::string& path,
                                          const std::function<void(std::span<const Parameter>)>& accept = {},
                                          const PointOrder* cells = nullptr);

}  // namespace udar::io
