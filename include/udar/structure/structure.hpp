#pragma once
/// @file
/// What is simulated: masses on something elastic; it knows no filter, no contact and no time.

#include <petscmat.h>

#include "udar/structure/description.hpp"
#include "udar/structure/field.hpp"
#include "udar/structure/mass_points.hpp"

namespace udar {

class BeamChain;
class Network;

/// @brief An elastic structure with its masses, distributed over the ranks.
class Structure {
 public:
  Structure() = default;
  Structure(const Structure&) = delete;
  Structure& operator=(const Structure&) = delete;
  virtual ~Structure() = default;

  [[nodiscard]] virtual const MassPoints& points() const = 0;
  /// Without the masses that strike it.
  [[nodiscard]] virtual const Structure& elastic() const { return *this; }
  /// The chain if it is one, for solvers that need no more than that; else null.
  [[nodiscard]] virtual const BeamChain* chain() const { return nullptr; }
  /// The network of members if it is one, else null.
  [[nodiscard]] virtual const Network* network() const { return nullptr; }
  /// Else its stiffness: `MATAIJ`, symmetric; each rank's rows are its coordinates, then its unknowns without mass.
  [[nodiscard]] virtual Mat stiffness() const { return nullptr; }
  /// Else the largest C_ii / m_i of its points [1/s^2], or what it is not far below. @note Collective.
  [[nodiscard]] virtual double largest_ratio() const { return 0.0; }
  [[nodiscard]] virtual Topology topology() const = 0;
  /// How many rigid motions it has if nothing fixes it; at most so many modes have no frequency.
  [[nodiscard]] virtual PetscInt rigid_modes() const = 0;
  /// Whether anything ties it to the ground.
  [[nodiscard]] virtual bool grounded() const = 0;
  /// Adds what it is, equal on every rank. @note Not collective.
  virtual void describe(Description& all) const = 0;
};

}  // namespace udar
