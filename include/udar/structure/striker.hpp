#pragma once
/// @file
/// Rigid masses that fly, hit a structure and leave it again; nodes that hit each other; masses that travel along it.

#include <memory>
#include <span>
#include <vector>

#include "udar/structure/structure.hpp"
#include "udar/structure/travelling_load.hpp"

namespace udar {

/// @brief A rigid mass, guided along y, that can touch one node of a structure.
struct Striker {
  Place place{};          ///< [m]: it strikes the nearest node that moves along y
  double mass = 0.0;      ///< [kg], > 0
  double gap = 0.0;       ///< between its tip and the node at the start [m], >= 0
  double velocity = 0.0;  ///< at the start [m/s], y up
  bool below = false;     ///< it stands below the structure and strikes upwards
};

/// @brief Two nodes of a structure that can touch across a gap.
struct NodePair {
  Place from{};        ///< [m]: the nearest node that moves along y
  Place to{};          ///< [m]: the same
  Place normal = kUp;  ///< from the one to the other, along x, y or z: a unit vector
  double gap = 0.0;    ///< between the two at the start [m], >= 0, wherever their axes stand
};

/// @brief A structure with what strikes it: an elastic structure, masses that nothing ties to it, what of it touches
/// itself, and masses that travel along it.
///
/// Of a node of mass m and its striker of mass M the unknowns are the centre of mass of both, with the mass m + M, and
/// the gap between them, with the mass m M / (m + M): a change of basis that leaves the mass matrix diagonal and every
/// filter spring at wf. A contact of the two is one of the gap with a rigid face, exactly, whatever its law. Of two
/// nodes that touch it is the same; their unknowns take the places of their own.
/// Masses that travel along it are points of their own behind all others of the first rank; what ties them to it is
/// not the structure's (`CarriedMasses`).
/// Source: docs/theory.md, "Strikers", "Pairs of nodes", "Travelling masses"
class StruckStructure final : public Structure {
 public:
  /// @param structure of points of one component
  /// @note Collective. @throws InputError naming quantity, value and range if a striker is off the structure, has no
  /// mass or starts within it, or if its node is held, has axes of its own or is another striker's; of pairs the same,
  /// and if both are one node, do not move along the normal, or are on two ranks; of travelling masses as
  /// `require_sound`, and if there is no straight beam without gaps
  StruckStructure(std::unique_ptr<const Structure> structure, const std::vector<Striker>& strikers,
                  const std::vector<NodePair>& pairs = {}, std::span<const TravellingLoad> travelling = {});

  [[nodiscard]] const MassPoints& points() const override { return *points_; }
  [[nodiscard]] const Structure& elastic() const override { return structure_->elastic(); }
  [[nodiscard]] const BeamChain* chain() const override { return structure_->chain(); }
  [[nodiscard]] const Network* network() const override { return structure_->network(); }
  [[nodiscard]] Mat stiffness() const override { return structure_->stiffness(); }
  [[nodiscard]] double largest_ratio() const override { return structure_->largest_ratio(); }
  /// Of the structure alone.
  [[nodiscard]] Topology topology() const override { return structure_->topology(); }
  [[nodiscard]] PetscInt rigid_modes() const override { return structure_->rigid_modes(); }
  [[nodiscard]] bool grounded() const override { return structure_->grounded(); }
  void describe(Description& all) const override { structure_->describe(all); }

 private:
  std::unique_ptr<const Structure> structure_;
  std::unique_ptr<const MassPoints> points_;
};

/// @brief Puts the heights of nodes, or their velocities, in place of those of centres of mass and gaps between nodes.
/// @param[in,out] values of local points
void centres_to_nodes(const MassPoints& points, std::span<double> values);

/// @brief The way back. @param[in,out] values of local points, gaps to strikers among them
void nodes_to_centres(const MassPoints& points, std::span<double> values);

/// `centres_to_nodes` of a copy, which has no gaps any more. @param values of local points
[[nodiscard]] std::vector<double> node_values(const MassPoints& points, std::span<const double> values);

/// Of the local points that are nodes' own, without what strikes them [kg].
[[nodiscard]] std::vector<double> node_masses(const MassPoints& points);

}  // namespace udar
