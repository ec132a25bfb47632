#pragma once
/// @file
/// Supports and the nodes they can touch.

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "udar/contact/support_motion.hpp"
#include "udar/numerics/polyline.hpp"
#include "udar/structure/beam_chain.hpp"

namespace udar {

/// @brief On which side of the beam a support stands.
enum class SupportSide : std::int8_t {
  below = 1,   ///< keeps masses above its height
  above = -1,  ///< keeps masses below its height
};

/// @brief A support, rigid or on springs; it touches every node within its width, edges included. Where the beam has a
/// mass patch from `from()` to `to()` these carry the mass of the width, else each its own.
struct Support {
  double position = 0.0;     ///< centre [m] from the left end
  double width = 0.0;        ///< [m]; 0: the nearest node alone
  double height = 0.0;       ///< [m]
  double restitution = 1.0;  ///< e in v+ = -e v-, from 0 to 1
  SupportSide side = SupportSide::below;
  double yield_speed = std::numeric_limits<double>::infinity();  ///< where e begins to fall [m/s], > 0
  /// What is added to the height: linear between the points, constant beyond them; may be empty.
  struct Profile {
    std::vector<double> x;       ///< [m], strictly ascending
    std::vector<double> height;  ///< [m]
  };
  Profile profile{};
  std::shared_ptr<const SupportMotion> motion = nullptr;       ///< what is added to the height over time; null: nothing
  double stiffness = std::numeric_limits<double>::infinity();  ///< of all of it [N/m], > 0; infinite: rigid
  double damping = 0.0;                                        ///< of all of it, if not rigid [N s/m]

  [[nodiscard]] bool elastic() const noexcept { return stiffness < std::numeric_limits<double>::infinity(); }

  [[nodiscard]] double from() const noexcept { return position - 0.5 * width; }  ///< [m]
  [[nodiscard]] double to() const noexcept { return position + 0.5 * width; }    ///< [m]

  /// A support under the whole beam.
  [[nodiscard]] static Support floor(double height, double restitution) {
    return {.position = 0.0,
            .width = std::numeric_limits<double>::infinity(),
            .height = height,
            .restitution = restitution};
  }
  /// Height of the contact face at x [m].
  [[nodiscard]] double height_at(double x) const { return height + interpolate(profile.x, profile.height, x); }
};

/// @brief A row of this rank's nodes that may touch one support.
struct ContactSet {
  std::size_t first = 0;  ///< local node
  std::size_t last = 0;   ///< one past the last local node
  PetscInt support = 0;   ///< index of the support
  double side = 1.0;      ///< +1 support below, -1 above: gap = side (y - height)
  double level = 0.0;     ///< height of a level support [m]
  double restitution = 1.0;
  double yield_speed = std::numeric_limits<double>::infinity();  ///< [m/s]
  std::vector<double> profile;                                   ///< height at each node [m]; empty: level
  std::shared_ptr<const SupportMotion> motion = nullptr;         ///< null: none
  double stiffness = 0.0;  ///< of a spring over the mass it carries [1/s^2]; 0: rigid
  double damping = 0.0;    ///< the same of a damper [1/s]

  /// Height of the contact face at a local node, without its motion [m].
  [[nodiscard]] double height(std::size_t node) const { return profile.empty() ? level : profile[node - first]; }
  /// What its motion adds just after a time [s].
  [[nodiscard]] SupportMotion::State lift(double time) const {
    return motion ? motion->at(time) : SupportMotion::State{};
  }
  /// The same within a step without rows from `begin` on.
  [[nodiscard]] SupportMotion::State lift(double time, double begin) const {
    return motion ? motion->at(time, begin) : SupportMotion::State{};
  }
  [[nodiscard]] bool elastic() const noexcept { return stiffness > 0.0; }
  /// Rigid and at rest: nothing but the impact law.
  [[nodiscard]] bool plain() const noexcept { return !motion && !elastic(); }
};

/// @brief The nodes a support touches: [first, last], empty if first > last.
[[nodiscard]] BeamChain::NodeRange touched_nodes(const BeamChain& beam, const Support& support);

/// @brief The rows of this rank's nodes that may touch a support, by support, held nodes left out.
/// @note Not collective.
/// @throws InputError naming option, value and range if a support is off the beam, touches no node, has e outside [0,
/// 1], or if one that moves or gives way shares nodes with another on its side
[[nodiscard]] std::vector<ContactSet> find_contact_sets(const BeamChain& beam, const std::vector<Support>& supports);

}  // namespace udar
