#pragma once
/// @file
/// Where on the mesh the things of a case are.

#include <string>
#include <vector>

#include "udar/app/case.hpp"
#include "udar/structure/structure.hpp"

namespace udar::app {

/// @brief Where a point stands, whichever rank has it; equal on every rank. @note Collective: one reduction.
[[nodiscard]] Place place_of(const MassPoints& points, PetscInt global);

/// @brief A thing that acts or reads at the nearest node.
struct Placed {
  std::string name;       ///< "support 0"
  Place asked{};          ///< [m]
  Place used{};           ///< of the node [m]
  bool in_space = false;  ///< asked for by x, y and z, not by x alone
  PetscInt point = -1;    ///< global, of the node along y; < 0: of supports, which may touch several

  /// Along x where only that was given [m].
  [[nodiscard]] double away() const;
};

/// "x = 5 m", or "(1, 2, 3) m" of a place in space.
[[nodiscard]] std::string words_of(const Place& place, bool in_space);
/// In space where y or z is not 0.
[[nodiscard]] std::string words_of(const Place& place);

/// @brief All of a case that are at one node: supports without a width, line supports, point masses, gauges, and loads
/// of what is no beam.
/// @note Collective.
[[nodiscard]] std::vector<Placed> placed_at_nodes(const Case& input, const MassPoints& points);

/// @brief Warns of what is so far from where it was asked for that the answer is another's, by more than 2 % of the
/// structure's length or a tenth of the way to the next support, and of supports whose width covers a single node.
/// @note Collective.
void warn_of_places(const Case& input, const Structure& structure);

}  // namespace udar::app
