#pragma once
/// @file
/// What of a run is written, as far as the user chooses.

#include <petscsystypes.h>

#include <cstdint>
#include <string>
#include <vector>

#include "udar/structure/mass_points.hpp"

namespace udar::io {

/// @brief Which lists of impacts a run writes.
struct ImpactLists {
  bool raw = true;      ///< each impact by itself
  bool rests = true;    ///< masses that come to rest, and that leave
  bool merged = false;  ///< those of a node and support within `window` as one
  double window = 0.0;  ///< [s]
};

/// @brief What of a run its files have.
struct ContentChoice {
  std::vector<std::string> fields{};  ///< by their names in results.h5; empty: all
  int compression = 0;                ///< of these, level of gzip; 0: none
  ImpactLists impacts{};
};

/// @brief Which nodes and cells of a structure have rows in the files: all cells that lie in the region, of these the
/// pieces of some members, and their corners.
struct RowChoice {
  bool everywhere = true;               ///< there is no region
  Region region{};                      ///< cells have all their corners in it
  std::vector<std::int64_t> members{};  ///< of networks, by number; empty: all
  PetscInt stride = 1;  ///< of each so many nodes along a line one, and the last; cells go from one to the next

  [[nodiscard]] bool whole() const noexcept { return everywhere && members.empty(); }
  [[nodiscard]] bool all() const noexcept { return whole() && stride == 1; }
};

}  // namespace udar::io
