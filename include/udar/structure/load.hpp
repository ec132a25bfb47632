#pragma once
/// @file
/// Forces on the line: gravity and patterns of forces that follow time tables.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "udar/structure/base_motion.hpp"
#include "udar/structure/held_motion.hpp"
#include "udar/structure/mass_points.hpp"
#include "udar/structure/time_law.hpp"
#include "udar/structure/time_table.hpp"
#include "udar/structure/travelling_load.hpp"

namespace udar {

/// @brief A force at a place, or spread evenly over a length, that follows a table.
struct NodalLoad {
  double position = 0.0;                   ///< x [m], of a beam from its left end, where nodes beside it share force
                                           ///< and moment; of others the node nearest in space has it
  double width = 0.0;                      ///< of the length about it [m], on the beam; 0: a point; infinite: all of it
  std::shared_ptr<const TimeTable> table;  ///< [N], along `direction`; with a breadth [Pa]
  double breadth = 0.0;                    ///< on which the table is a pressure, along `width` [m]; 0: it is a force
  double y = 0.0;                          ///< of the place [m]
  double z = 0.0;                          ///< the same
  Place direction = kUp;                   ///< unit vector; another than up needs nodes that move in space
  std::optional<TimeLaw> law{};            ///< from which the table is made

  [[nodiscard]] Place place() const noexcept { return {.x = position, .y = y, .z = z}; }
};

/// @brief What a load at a place is dealt to, equal on every rank. @note Collective.
/// @throws InputError if nothing can move in its direction there
[[nodiscard]] std::vector<PointShare> dealt(const MassPoints& points, const NodalLoad& load);

/// @brief What makes forces.
enum class LoadCause : std::uint8_t {
  load,
  base,    ///< what the base's motion makes of the masses: shares are minus these, the table accelerations
  spring,  ///< the foot of a spring that moves: shares are stiffnesses [N/m], the table displacements
  held,    ///< a place that holds the points and moves: no force, but their displacement [m]
};

/// @brief Forces on many points that follow one table: a point's is its share of the table's value. Of the whole
/// structure, but for the points, which are this rank's.
struct LoadPattern {
  std::vector<std::size_t> point;  ///< local, those with a share alone
  std::vector<double> share;       ///< as many
  std::shared_ptr<const TimeTable> table;
  LoadCause cause = LoadCause::load;
};

/// @brief The load vector F(t) of the line on this rank's nodes.
class Loads {
 public:
  /// @param gravity [m/s^2], acts downward on every lumped mass
  /// @param base whose motions give each mass that moves the inertia force of its own in the frame of the base
  /// @param held what is held rigidly and moves has its displacement in place of a force [m]
  /// @param nodal spread over a length, and those travelling: on a straight beam without gaps alone
  /// @note Collective.
  /// @throws InputError if a position is off the beam, or has no table, if nothing moves along a motion of the base, or
  /// there is no such beam
  Loads(const MassPoints& points, double gravity, const std::vector<NodalLoad>& nodal,
        std::span<const BaseMotion> base = {}, std::span<const TravellingLoad> travelling = {},
        std::span<const HeldMove> held = {});

  /// @brief F [N], one value per local node; empty: none on this rank.
  /// @param work where it is built if it must be; the result lives as long as this object and `work` do
  /// @note Cost: a look-up and a pass over its points for each pattern.
  [[nodiscard]] std::span<const double> force(const Instant& at, std::vector<double>& work) const;
  /// @brief dF/dt [N/s], in the same way.
  [[nodiscard]] std::span<const double> rate(const Instant& at, std::vector<double>& work) const;
  /// @brief Mean of F [N] from one time to a later one, in the same way.
  [[nodiscard]] std::span<const double> mean(double from, double to, std::vector<double>& work) const;

  [[nodiscard]] double gravity() const noexcept { return gravity_; }
  /// All times at which some table of the whole structure has a kink, ascending, equal on every rank [s].
  [[nodiscard]] const std::vector<double>& kinks() const noexcept { return kinks_; }

  /// Those of the whole structure in one order, weight not counted; a rank has all of them, if with no points.
  [[nodiscard]] std::span<const LoadPattern> patterns() const noexcept { return patterns_; }
  /// Weight [N], one value per local node; empty: none.
  [[nodiscard]] std::span<const double> weight() const noexcept { return weight_; }
  /// How many kinks are not after time t: between two of them all rates are constant.
  [[nodiscard]] std::size_t interval(double time) const;
  /// Whether any load of the whole structure changes in time.
  [[nodiscard]] bool time_dependent() const noexcept { return time_dependent_; }
  /// Whether what a local point has is a force, and not the displacement of what holds it.
  [[nodiscard]] bool is_force(std::size_t point) const { return !std::ranges::binary_search(moved_, point); }
  /// Whether some force of the whole structure jumps at this time [s].
  [[nodiscard]] bool jumps_at(double time) const;

 private:
  void add(LoadPattern pattern);
  void add_move(const HeldMove& move);
  template <class Value>
  void sum(std::vector<double>& work, const Value& value) const;

  double gravity_;
  std::vector<double> weight_;      // empty without gravity
  std::vector<std::size_t> moved_;  // local points whose force is a displacement, ascending
  std::size_t nodes_ = 0;
  std::vector<LoadPattern> patterns_;
  bool loaded_ = false;  // some of them on this rank
  std::vector<double> kinks_;
  std::vector<double> jumps_;  // ascending [s]
  bool time_dependent_ = false;
};

}  // namespace udar
