#pragma once
/// @file
/// What places that hold the structure bring in by their motion.

#include <cstddef>
#include <span>
#include <vector>

#include "udar/filter/filtered_structure.hpp"
#include "udar/motion/dense_output.hpp"
#include "udar/motion/observer.hpp"
#include "udar/structure/held_motion.hpp"
#include "udar/structure/load.hpp"

namespace udar {

/// @brief The force between a structure and the places that hold it and move: its work, and what its springs store.
/// Source: docs/theory.md, "Motion of held places"
class HeldPlaces {
 public:
  HeldPlaces() = default;
  /// @param line knows what is held rigidly and moves, `FilteredStructure::moved`; must outlive this object
  /// @param moves all of them
  HeldPlaces(const FilteredStructure& line, std::vector<HeldMove> moves);

  [[nodiscard]] bool empty() const noexcept { return moves_.empty(); }
  [[nodiscard]] std::span<const HeldMove> moves() const noexcept { return moves_; }

  /// @brief What the springs of places that move store besides the energy that they had if these stood still [J], this
  /// rank's share. @param displacement of the line from the axis [m]
  [[nodiscard]] double stored(const Instant& at, std::span<const double> displacement) const;

  /// @brief Where each is and with what force it acts on the structure. @param position of the masses, @param line Yc,
  /// @param axis [m], local points @note Collective: one reduction.
  [[nodiscard]] std::vector<PlaceState> states(const Instant& at, const Loads& loads, std::span<const double> position,
                                               std::span<const double> line, std::span<const double> axis) const;

  /// @brief Work of all places on the structure from the start of a step to a time within it [J], this rank's share.
  /// @param axis [m], local points @note Not collective. Cost: where some place that holds rigidly moves, the masses'
  /// integrals and a pass over all points for each.
  [[nodiscard]] double work(const DenseOutput& step, const Loads& loads, std::span<const double> axis, double begin,
                            double until) const;

 private:
  [[nodiscard]] double work_of_springs(const DenseOutput& step, std::span<const double> axis, double begin,
                                       double until) const;
  [[nodiscard]] double work_of_held(const DenseOutput& step, const Loads& loads, std::span<const double> axis,
                                    double begin, double until) const;
  /// Integrals over a time, or values, of what rigid places push with: R of each of `MovedPoints`, this rank's share.
  /// @param push wf^2 M u + F @param moved displacements
  [[nodiscard]] std::vector<double> reactions(std::span<const double> push, std::span<const double> moved) const;

  const FilteredStructure* line_ = nullptr;
  std::vector<HeldMove> moves_;
};

/// @brief The points of `MovedPoints`: local, or `MovedPoint::kElsewhere`, of what is held rigidly and moves.
[[nodiscard]] std::vector<std::size_t> held_points(std::span<const HeldMove> moves);

}  // namespace udar
