#include "io/support_faces.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "io/field_lines.hpp"
#include "io/support_outline.hpp"
#include "structure/place_algebra.hpp"
#include "udar/numerics/polyline.hpp"

namespace udar::io {
namespace {

/// @name Shares of the size of a scene
/// @{
constexpr double kRoom = 0.05;    // around the structure
constexpr double kNarrow = 0.01;  // width of a support without any
constexpr double kDepth = 0.012;  // of a body behind its face
/// @}

/// The floor is, but for strikers.
bool is_last(const RunLayout& layout, std::size_t number) {
  return number + 1 == layout.supports.size() || layout.supports[number + 1].striker >= 0;
}

}  // namespace

Scene::Scene(const RunLayout& layout) {
  constexpr double kNone = -std::numeric_limits<double>::infinity();
  std::array<double, 6> most{kNone, kNone, kNone, kNone, kNone, kNone};  // -x, -y, -z, x, y, z
  for (std::size_t point = 0; point < layout.points->own_points(); ++point) {
    Place at = layout.points->place(point);
    at.y = layout.rows->upright() ? 0.0 : at.y;
    const std::array<double, 3> values = values_of(at);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      most[axis] = std::max(most[axis], -values[axis]);
      most[axis + 3] = std::max(most[axis + 3], values[axis]);
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, most.data(), 6, MPI_DOUBLE, MPI_MAX, layout.comm());
  around = {.from = {.x = -most[0], .y = -most[1], .z = -most[2]}, .to = {.x = most[3], .y = most[4], .z = most[5]}};
  const double diagonal = norm(around.to - around.from);
  size = diagonal > 0.0 ? diagonal : 1.0;
}

Region Scene::with_room() const {
  const double room = kRoom * size;
  const Place all{.x = room, .y = room, .z = room};
  return {.from = around.from - all, .to = around.to + all};
}

SupportFaces::SupportFaces(const RunLayout& layout, const Scene& scene) {
  for (std::size_t k = 0; k < layout.supports.size(); ++k) {
    if (layout.supports[k].striker < 0) {
      add_support(layout, k, scene);
    }
  }
  add_tips(layout);
}

void SupportFaces::add_support(const RunLayout& layout, std::size_t number, const Scene& scene) {
  RunLayout::Support plane = layout.supports[number];
  if (plane.space.empty()) {
    constexpr double kEnd = Region::kEnd;
    plane.space = {0.0, 1.0, 0.0, -kEnd, kEnd, -kEnd, kEnd};
  }
  const Place normal{.x = plane.space[0], .y = plane.space[1], .z = plane.space[2]};
  const Place inwards = static_cast<double>(plane.side) * normal;
  Point like{.at = {},
             .displacement = (plane.height - plane.reach) * normal,
             .normal = normal,
             .away = -plane.radius * inwards,
             .mover = -1};
  if (plane.lift) {
    like.mover = static_cast<int>(lifts.size());
    lifts.push_back(plane.lift);
  }
  const Region around = scene.with_room();
  const auto support = static_cast<std::int64_t>(number);
  if (plane.field) {
    add_field(plane, support, around, like);
  } else if (!layout.ground_x.empty() && is_last(layout, number)) {
    add_ground(layout, support, around, like);
  } else {
    const bool point = plane.width == 0.0 && normal.y == 1.0;
    plane.width = point ? kNarrow * scene.size : plane.width;
    plane.height = plane.reach;
    add_block(outline_of(plane, around), -kDepth * scene.size * inwards, like, support);
  }
}

/// @param depth from the face to the far side
void SupportFaces::add_block(const std::array<Place, 4>& corners, const Place& depth, const Point& like,
                             std::int64_t support) {
  const std::size_t first = points.size();
  for (const bool far : {false, true}) {
    for (const Place& corner : corners) {
      points.push_back(like);
      points.back().at = far ? corner + depth : corner;
    }
  }
  faces.push_back({{first, first + 1, first + 2, first + 3}, support});
  faces.push_back({{first + 4, first + 5, first + 6, first + 7}, support});
  for (std::size_t i = 0; i < 4; ++i) {
    const std::size_t next = (i + 1) % 4;
    faces.push_back({{first + i, first + next, first + 4 + next, first + 4 + i}, support});
  }
}

/// A strip over the profile, as far as it is next to the structure, level beyond its ends.
void SupportFaces::add_ground(const RunLayout& layout, std::int64_t number, const Region& around, const Point& like) {
  const RunLayout::Support& support = layout.supports[static_cast<std::size_t>(number)];
  std::vector<double> along{around.from.x};
  std::ranges::copy_if(layout.ground_x, std::back_inserter(along),
                       [&](double x) { return x > around.from.x && x < around.to.x; });
  along.push_back(around.to.x);
  const std::size_t first = points.size();
  for (const double x : along) {
    const double height = interpolate(layout.ground_x, layout.ground_height, x);
    for (const double z : {around.from.z, around.to.z}) {
      points.push_back(like);
      points.back().at = {.x = x, .y = support.reach, .z = z};
      points.back().displacement = (height - support.reach) * kUp;
    }
  }
  for (std::size_t i = first; i + 3 < points.size(); i += 2) {
    faces.push_back({{i, i + 1, i + 3, i + 2}, number});
  }
}

/// Quadrilaterals between heights that are known.
void SupportFaces::add_field(const RunLayout::Support& support, std::int64_t number, const Region& around,
                             const Point& like) {
  const HeightGrid& field = *support.field;
  const auto [columns, rows] = grid_of(field, around);
  const std::size_t first = points.size();
  std::vector<bool> known;
  for (const std::size_t row : rows) {
    for (const std::size_t column : columns) {
      const double height = support.base + field.height()[row * field.x().size() + column];
      known.push_back(std::isfinite(height));
      points.push_back(like);
      points.back().at = {.x = field.x()[column], .y = support.reach, .z = field.z()[row]};
      points.back().displacement = (known.back() ? height - support.reach : 0.0) * kUp;
    }
  }
  for (std::size_t row = 0; row + 1 < rows.size(); ++row) {
    for (std::size_t column = 0; column + 1 < columns.size(); ++column) {
      const std::size_t i = row * columns.size() + column;
      const std::array<std::size_t, 4> corners{i, i + 1, i + columns.size() + 1, i + columns.size()};
      if (std::ranges::all_of(corners, [&](std::size_t corner) { return known[corner]; })) {
        faces.push_back({{first + corners[0], first + corners[1], first + corners[2], first + corners[3]}, number});
      }
    }
  }
}

void SupportFaces::add_tips(const RunLayout& layout) {
  const MassPoints& all = *layout.points;
  std::vector<double> places(3 * all.strikes().size(), 0.0);  // zeros where another rank has it
  for (std::size_t i = 0; i < all.strikes().size(); ++i) {
    const PetscInt centre = all.strikes()[i].centre;
    if (all.owns(centre)) {
      const Place at = all.place(static_cast<std::size_t>(centre - all.begin()));
      std::ranges::copy(std::array{at.x, layout.rows->upright() ? 0.0 : at.y, at.z},
                        places.begin() + static_cast<std::ptrdiff_t>(3 * i));
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, places.data(), static_cast<int>(places.size()), MPI_DOUBLE, MPI_SUM, all.comm());
  for (std::size_t i = 0; i < all.strikes().size(); ++i) {
    const Strike& strike = all.strikes()[i];
    const auto number = static_cast<std::int64_t>(strike.striker);
    const auto face = std::ranges::find(layout.supports, number, &RunLayout::Support::striker);
    const double radius = face != layout.supports.end() ? face->radius : 0.0;
    tips.push_back({points.size(), face - layout.supports.begin()});
    points.push_back({.at = {.x = places[3 * i], .y = places[3 * i + 1], .z = places[3 * i + 2]},
                      .displacement = {},
                      .normal = kUp,
                      .away = (strike.side * radius) * kUp,
                      .mover = static_cast<int>(lifts.size() + strike.striker)});
  }
}

}  // namespace udar::io
