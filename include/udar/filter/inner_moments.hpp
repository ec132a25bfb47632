#pragma once
/// @file
/// Moments on the inner nodes of members, for right-hand sides that have them.

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "udar/structure/network.hpp"

namespace udar {

/// @brief Turns moments on the massless rotations of inner nodes into forces on the nodes and on the ends of the
/// members: static condensation of the frame's rotations, member by member.
class InnerMoments {
 public:
  /// @param local of each junction of the network, where `Loads::junction` has it
  /// @note Not collective. Cost and memory O(elements of this rank).
  InnerMoments(const Network& network, std::span<const std::size_t> local);

  /// What stands for the moments.
  struct Loads {
    std::span<double> point;     ///< forces on the rank's points [N], added to
    std::span<double> rotation;  ///< of its nodes about y, x, z: moments [N m] in, rotations [rad] out; 0 at junctions
    std::span<double> junction;  ///< six forces and moments of each junction [N, N m], added to
  };
  void eliminate(const Loads& loads) const;

 private:
  using Matrix3 = std::array<std::array<double, 3>, 3>;
  void factor(std::size_t member);
  void add_twist(std::size_t member, Matrix3& own) const;
  void eliminate(std::size_t index, const Loads& loads) const;

  const Network* network_;
  std::span<const std::size_t> local_;
  std::vector<std::size_t> members_;  // of this rank, those with inner nodes
  std::vector<std::size_t> first_;    // inner node of each of them in what follows
  std::vector<Matrix3> inverse_;      // of the diagonal once the nodes before it are gone
  std::vector<Matrix3> coupling_;     // to the node before it
};

}  // namespace udar
