#pragma once
/// @file
/// Supports as bodies and strikers as tips, for pictures.

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "udar/io/layout.hpp"
#include "udar/structure/mass_points.hpp"

namespace udar::io {

/// @brief Where a structure stands as long as nothing strains it; at height 0 if all of it moves along y.
struct Scene {
  Region around;      ///< the box of it [m]
  double size = 1.0;  ///< diagonal of that [m], > 0

  /// @note Collective: one reduction.
  explicit Scene(const RunLayout& layout);
  /// The box with some room around it, across a beam, too.
  [[nodiscard]] Region with_room() const;
};

/// @brief Supports as what stands next to the structure, tips of strikers on it.
///
/// A point stands where the structure is that its support touches first, and `displacement` takes it to where it is
/// itself: who exaggerates the displacements of both by the same factor sees them touch when they do.
struct SupportFaces {
  struct Point {
    Place at;            ///< [m]
    Place displacement;  ///< without motion [m]
    Place normal;        ///< towards the structure, a unit vector; of a tip up [-]
    Place away;          ///< from the axis of what is touched to its surface [m]
    int mover = -1;      ///< what moves it along its normal; -1: nothing
  };
  struct Face {
    std::array<std::size_t, 4> corners;
    std::int64_t support;
  };
  struct Tip {
    std::size_t point;
    std::int64_t support;
  };

  /// @note Collective.
  SupportFaces(const RunLayout& layout, const Scene& scene);

  std::vector<Point> points;
  std::vector<Face> faces;
  std::vector<Tip> tips;
  /// The first movers: how far supports are moved along their normal [m] at a time [s]; strikers are those after them.
  std::vector<std::function<double(double)>> lifts;

 private:
  void add_support(const RunLayout& layout, std::size_t number, const Scene& scene);
  void add_block(const std::array<Place, 4>& corners, const Place& depth, const Point& like, std::int64_t support);
  void add_ground(const RunLayout& layout, std::int64_t number, const Region& around, const Point& like);
  void add_field(const RunLayout::Support& support, std::int64_t number, const Region& around, const Point& like);
  void add_tips(const RunLayout& layout);
};

}  // namespace udar::io
