#pragma once
/// @file
/// Supports and the nodes they can touch.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "udar/contact/contact_law.hpp"
#include "udar/contact/impact_law.hpp"
#include "udar/contact/support_motion.hpp"
#include "udar/numerics/height_grid.hpp"
#include "udar/numerics/polyline.hpp"
#include "udar/structure/mass_points.hpp"

namespace udar {

/// @brief On which side of the beam a support stands: in front of its face is where its normal points.
enum class SupportSide : std::int8_t {
  below = 1,   ///< keeps masses above its height, or in front of its face
  above = -1,  ///< keeps masses below its height, or behind its face
};

/// @brief A support, rigid, on springs or with a law of contact; it touches every node within its width, edges
/// included. Where the beam has a mass patch from `from()` to `to()` these carry the mass of the width, else each its
/// own.
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
  /// A surface that is added to the height, of a support that looks up and neither moves nor is without width; null:
  /// none. A point faces the plane that touches it above or below its place.
  std::shared_ptr<const HeightGrid> field = nullptr;
  std::shared_ptr<const SupportMotion> motion = nullptr;       ///< what is added to the height over time; null: nothing
  double stiffness = std::numeric_limits<double>::infinity();  ///< of all of it [N/m], > 0; infinite: rigid
  double damping = 0.0;                                        ///< of all of it, if not rigid [N s/m]
  double friction = 0.0;  ///< Coulomb's coefficient, of nodes that move across its normal, too [-]
  /// Of its face, a unit vector: heights count along it, from the origin. Nodes must move along it.
  Place normal = kUp;
  Extent x{-Region::kEnd, Region::kEnd};  ///< of what it touches, besides its width: of a face of a box [m]
  Extent y{-Region::kEnd, Region::kEnd};  ///< of what it touches [m]
  Extent z{-Region::kEnd, Region::kEnd};
  std::shared_ptr<const ContactLaw> contact_law = nullptr;  ///< of all of it, in place of a spring; null: none
  /// Which of `MassPoints::strikes` this is the face of: it touches the gap between the two, on which nothing but its
  /// law, its restitution and a height, by which they overlap, have a meaning; negative: it is a support.
  PetscInt strike = -1;

  /// It gives way, by a spring or by a law of contact.
  [[nodiscard]] bool elastic() const noexcept {
    return stiffness < std::numeric_limits<double>::infinity() || contact_law != nullptr;
  }
  /// Rigid and at rest: nothing but the impact law.
  [[nodiscard]] bool plain() const noexcept { return !motion && !elastic(); }
  [[nodiscard]] ImpactLaw law() const noexcept { return {.restitution = restitution, .yield_speed = yield_speed}; }

  /// Whether it is not simply one below or above all that stands over its width.
  [[nodiscard]] bool in_space() const noexcept {
    return normal.y != 1.0 || field || boxed() || y.to < Region::kEnd || z.to < Region::kEnd || friction > 0.0;
  }
  [[nodiscard]] double from() const noexcept { return position - 0.5 * width; }  ///< [m]
  [[nodiscard]] double to() const noexcept { return position + 0.5 * width; }    ///< [m]
  /// Where it touches nodes; with no width of its own its x is to be ignored.
  [[nodiscard]] Region region() const noexcept {
    return {.from = {.x = std::max(from(), x.from), .y = y.from, .z = z.from},
            .to = {.x = std::min(to(), x.to), .y = y.to, .z = z.to}};
  }

  /// Whether it is a face of a box.
  [[nodiscard]] bool boxed() const noexcept { return x.from > -Region::kEnd || x.to < Region::kEnd; }
  [[nodiscard]] Facing facing() const { return {.normal = normal, .field = field}; }

  /// A support under the whole beam.
  [[nodiscard]] static Support floor(double height, double restitution) {
    return {.position = 0.0,
            .width = std::numeric_limits<double>::infinity(),
            .height = height,
            .restitution = restitution};
  }
  /// Height of the contact face at some x [m].
  [[nodiscard]] double height_at(double along) const { return height + interpolate(profile.x, profile.height, along); }
};

/// @brief A row of this rank's points that may touch one support, and how: geometry, law and spring.
///
/// Points that do not stand side by side are rows of their own, so that kernels run over contiguous values alone.
struct ContactSet {
  std::size_t first = 0;  ///< local node
  std::size_t last = 0;   ///< one past the last local node
  PetscInt support = 0;   ///< index of the support
  double side = 1.0;      ///< +1 support below, -1 above: gap = side (coordinate - height)
  double level = 0.0;     ///< height of a level support [m]; 0 with a profile
  ImpactLaw law{};
  /// Height at each node, less where the node stands along the normal beyond what its coordinate has of it [m]; empty:
  /// level.
  std::vector<double> profile;
  std::shared_ptr<const SupportMotion> motion = nullptr;  ///< null: none
  double carried = 0.0;    ///< mass over the width of its support, if that is not rigid [kg]
  double stiffness = 0.0;  ///< of a spring over the mass it carries [1/s^2]; 0: rigid
  double damping = 0.0;    ///< the same of a damper [1/s]
  double friction = 0.0;   ///< Coulomb's coefficient [-]
  std::shared_ptr<const ContactLaw> contact_law = nullptr;  ///< shared by `carried`, in place of a spring; null: none

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
  [[nodiscard]] bool elastic() const noexcept { return stiffness > 0.0 || contact_law != nullptr; }
  /// Rigid and at rest: nothing but the impact law.
  [[nodiscard]] bool plain() const noexcept { return !motion && !elastic(); }
};

/// @brief All supports and who may touch them: found and checked once a run.
struct Contacts {
  std::vector<Support> supports;
  std::vector<PetscInt> touched;  ///< points of each support over all ranks, those that never move included
  std::vector<ContactSet> sets;   ///< of this rank, by support; points that never move are left out
};

/// The points a support touches. @note Collective.
[[nodiscard]] PointRows touched_points(const MassPoints& points, const Support& support);

/// @note Collective.
/// @throws InputError naming quantity, value and range if a support is off the structure, touches no point, has e
/// outside [0, 1], has a field of heights and what does not go with it, or if one that moves or gives way shares points
/// with another on its side
[[nodiscard]] Contacts find_contacts(const MassPoints& points, std::vector<Support> supports);

}  // namespace udar
