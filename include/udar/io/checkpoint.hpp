#pragma once
/// @file
/// restart.h5: the complete state of a run, from which another can go on.

#include <functional>
#include <span>
#include <string>

#include "udar/io/point_order.hpp"
#include "udar/motion/motion_state.hpp"

namespace udar::io {

/// @brief Writes a checkpoint to `path`, points and cells in the user's order. A run that is killed meanwhile, or finds
/// the disk full, leaves the older file. Doubles come back bit by bit.
/// @param cells their order; may be null if the state has nothing in cells
/// @note Collective. Needs the disk space of the old and the new file together.
/// @throws FileError on all ranks
void write_checkpoint(const PointOrder& points, const std::string& path, const MotionState& state,
                      const PointOrder* cells = nullptr);

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
