#pragma once
/// @file
/// The recursion through members of one kind, eight side by side.

#include <array>
#include <cstddef>

#include "udar/network/lane_tables.hpp"
#include "udar/network/member_tables.hpp"
#include "udar/structure/network.hpp"

namespace udar::network {

/// @brief Three values of every node of a rank, in global axes: a pointer to each direction's first local node.
template <class Number>
struct Triple {
  Number* x = nullptr;
  Number* y = nullptr;
  Number* z = nullptr;
};

/// @brief A pack in space, and where its members end.
struct Placement {
  std::array<std::array<Lanes, 3>, 2> offset;  ///< rigid arms, global axes [m]
  std::array<std::array<Lanes, 3>, 3> axes;    ///< rows of `Axes`
  std::size_t first = 0;                       ///< as `MemberPack`
  std::size_t lanes = 0;
  std::array<std::array<std::size_t, kLanes>, 2> slot{};  ///< of the junctions, in what goes in and out
  bool offsets = false;                                   ///< whether any arm is not zero
  std::size_t nodes = 0;            ///< of the rank: so many numbers can be read; 0: those of the members alone
  const LaneTables* own = nullptr;  ///< where lanes have tables of their own
};

/// @brief One column of what goes in and out.
struct Sweep {
  Triple<const double> displacement;  ///< of the inner nodes' masses [m]
  Triple<const double> force;         ///< on them [N]; null: none
  /// Of the junctions by slot, global axes: displacement of the mass x, y, z [m], with rotary inertia its rotation
  /// [rad]; `pitch` numbers from one to the next.
  const double* place = nullptr;
  /// Of the junctions by slot, global axes: three forces and moments [N, N m] added up by `condense`, three
  /// displacements and rotations less those of the masses [m, rad] for `resolve`.
  double* value = nullptr;
  std::size_t pitch = 0;
  Triple<double> stretch;   ///< of the inner nodes [m]
  Triple<double> rotation;  ///< of them, about global axes [rad]; null: not wanted
  /// Of the inner nodes, about their member's axis: rotation of the masses [rad], without rotary inertia null, moment
  /// on them [N m], null: none, and what the line is turned more [rad].
  const double* angle = nullptr;
  const double* torque = nullptr;
  double* twist = nullptr;
};

/// What `condense` finds.
struct Condensed {
  std::array<std::array<Lanes, 4>, 2> bending;  ///< l of both planes, of spans what `MemberTables` weights
  std::array<Lanes, 2> axial;
  std::array<Lanes, 2> turning;
  std::array<std::array<Lanes, 2>, 2> rise;  ///< first and last difference of displacements in both planes
};

/// @brief What is known at both ends once the junctions are: in each plane displacement and rotation of the first end,
/// force and moment at the second, in the units and beside the chords of `BendingTable`; the same along the axis.
struct Bounds {
  std::array<Lanes, 2> deflection;
  std::array<Lanes, 2> turn;
  std::array<Lanes, 2> force;
  std::array<Lanes, 2> moment;
  Lanes along;
  Lanes pull;
  Lanes twist;       ///< rotation about the axis at the first end [rad]
  Lanes twist_rise;  ///< and what each element adds
  Lanes spin;        ///< with rotary inertia, in place of these, what that rotation is more than its mass's
  Lanes torque;      ///< and the moment at the second end over K_t
};

/// @brief What masses and forces of a pack's inner nodes show at its ends, seen from masses that stand still.
void condense(const MemberTables& tables, const Placement& frame, const Sweep& sweep, Condensed& condensed);

/// @brief Adds what members push their junctions with.
void push_junctions(const MemberTables& tables, const Placement& frame, const Sweep& sweep, const Condensed& condensed);

/// @brief What their ends know when the junctions are known.
void find_bounds(const MemberTables& tables, const Placement& frame, const Sweep& sweep, const Condensed& condensed,
                 Bounds& bounds);

/// @brief Solves inside a pack.
void resolve(const MemberTables& tables, const Placement& frame, const Sweep& sweep, const Bounds& bounds);

/// @name The same of rotations about the axis with rotary inertia, each after its counterpart.
/// @{
void condense_turning(const MemberTables& tables, const Placement& frame, const Sweep& sweep, Condensed& condensed);
/// @brief Between `condense` and `push_junctions`, of what ends at junctions: rotations there count from the masses'.
void turn_ends(const MemberTables& tables, const Placement& frame, const Sweep& sweep, Condensed& condensed);
void push_turning(const MemberTables& tables, const Placement& frame, const Sweep& sweep, const Condensed& condensed);
void find_turning_bounds(const MemberTables& tables, const Placement& frame, const Sweep& sweep,
                         const Condensed& condensed, Bounds& bounds);
void resolve_turning(const MemberTables& tables, const Placement& frame, const Sweep& sweep, const Bounds& bounds);
/// @}

}  // namespace udar::network
