#pragma once
/// @file
/// The state of a motion between two steps, for a restart.

#include <mpi.h>

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "udar/structure/description.hpp"
#include "udar/structure/field.hpp"

namespace udar {

/// @brief Everything needed to go on from a step's end as if nothing had happened; who keeps a number here knows what
/// it means.
struct MotionState {
  std::map<std::string, std::vector<double>> fields;  ///< one value per local node, flags included
  std::map<std::string, std::vector<double>> cells;   ///< one value per local cell of the structure
  std::map<std::string, double> scalars;              ///< equal on every rank
  std::map<std::string, std::vector<double>> tables;  ///< small, of any length, equal on every rank
  std::map<std::string, std::string> texts;           ///< of any bytes and length; rank 0's are kept, all get them back
  std::vector<Parameter> parameters;                  ///< what the motion is one of: tells a restart with another case
  std::string integrator{};                           ///< `-ts_type` of who wrote it; empty: not known

  /// @throws InputError naming -restart_file if it is missing or, for a field, not of `size`
  [[nodiscard]] const std::vector<double>& field(const std::string& name, std::size_t size,
                                                 Where where = Where::points) const;
  [[nodiscard]] double scalar(const std::string& name) const;
  [[nodiscard]] const std::vector<double>& table(const std::string& name) const;
  [[nodiscard]] const std::string& text(const std::string& name) const;

  /// Refuses numbers that no run has written: a checksum says that a file is as it was written, not by whom.
  /// @param supports that masses may rest on @note Collective. @throws InputError naming what holds it, on all ranks
  void require_sound(MPI_Comm comm, std::size_t supports) const;
};

}  // namespace udar
