#pragma once
/// @file
/// Places that hold a structure and move by themselves, each as it likes.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "udar/structure/base_motion.hpp"
#include "udar/structure/beam_chain.hpp"
#include "udar/structure/network.hpp"
#include "udar/structure/structure.hpp"
#include "udar/structure/time_table.hpp"

namespace udar {

/// @brief What holds a structure.
enum class HeldKind : std::uint8_t { left_end, right_end, line_support, junction };

/// @brief One place that holds a structure: rigidly, or by a spring whose foot it is.
struct HeldPlace {
  HeldKind kind = HeldKind::left_end;
  std::size_t number = 0;  ///< of the line support of a beam, or the junction of a network, as they are given

  bool operator==(const HeldPlace&) const = default;
};

/// @brief What a user calls it: "left", "line_support_0", the name of a junction. @param network null: of a beam
[[nodiscard]] std::string place_name(const HeldPlace& place, const NetworkParameters* network = nullptr);

/// @brief How such a place moves. Source: docs/theory.md, "Motion of held places"
struct HeldMotion {
  HeldPlace place;
  BaseMotion motion;
  double accuracy = 1e-4;  ///< largest error of its table, of the largest displacement [-]
};

/// @brief A coordinate of the structure that such a motion moves.
struct MovedPoint {
  static constexpr std::size_t kElsewhere = static_cast<std::size_t>(-1);

  PetscInt number = 0;             ///< among those of the elastic structure, of all ranks
  std::size_t point = kElsewhere;  ///< local, on the rank that has it
  double share = 1.0;              ///< of the displacement that is along it [-]
  double stiffness = 0.0;          ///< of the spring between it and the place [N/m]; infinite: it is held

  [[nodiscard]] bool held() const noexcept { return stiffness == BeamEnd::kRigid; }
  [[nodiscard]] bool here() const noexcept { return point != kElsewhere; }
};

/// @brief A motion of a place of some structure.
struct HeldMove {
  std::shared_ptr<const TimeTable> table;  ///< displacement along the motion's direction [m]
  std::vector<MovedPoint> points;          ///< the same on every rank but for `point`
};

/// @brief A motion's displacement as a table: linear between rows so close that this is right to a share of the largest
/// displacement, with the motion's mean over every piece where its acceleration does not jump.
/// @throws InputError if the accuracy is out of range, or there were too many rows
[[nodiscard]] std::shared_ptr<const TimeTable> displacement_table(const BaseMotion& motion, double accuracy);

/// @brief What the motions move. @note Collective.
/// @throws InputError on all ranks if a place does not hold the structure in the direction in which it moves, or
/// something else holds it there, too
[[nodiscard]] std::vector<HeldMove> held_moves(const Structure& structure, const std::vector<HeldMotion>& motions);

/// @brief A structure's parameters with what holds it rigidly at these places, in the directions in which they move,
/// let go.
[[nodiscard]] BeamParameters released(BeamParameters beam, const std::vector<HeldMotion>& motions);
[[nodiscard]] NetworkParameters released(NetworkParameters network, const std::vector<HeldMotion>& motions);

}  // namespace udar
