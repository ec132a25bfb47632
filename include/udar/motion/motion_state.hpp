#pragma once
/// @file
/// The state of a motion between two steps, for a restart.

#include <cstddef>
#include <map>
#include <string>
#include <vector>

namespace udar {

/// @brief Everything needed to go on from a step's end as if nothing had happened.
struct MotionState {
  std::map<std::string, std::vector<double>> fields;  ///< one value per local node
  std::map<std::string, double> scalars;              ///< equal on every rank
  std::map<std::string, std::vector<double>> tables;  ///< equal on every rank

  /// @throws InputError naming -restart_file if it is missing or, for a field, not of `size`
  [[nodiscard]] const std::vector<double>& field(const std::string& name, std::size_t size) const;
  [[nodiscard]] double scalar(const std::string& name) const;
};

}  // namespace udar
