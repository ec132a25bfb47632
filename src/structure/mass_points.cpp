#include "udar/structure/mass_points.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "udar/petsc/error.hpp"

namespace udar {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kEndTolerance = 1e-9;   // of the structure: places typed with ten digits still are on it
constexpr double kNearTolerance = 1e-9;  // of the distance between two points: in their middle both are equally near
constexpr double kEdgeTolerance = 1e-9;  // of the larger number: edges typed with ten digits still meet their point

double distance(const Place& left, const Place& right) {
  return std::hypot(left.x - right.x, left.y - right.y, left.z - right.z);
}

bool is_number(const Place& place) {
  return std::isfinite(place.x) && std::isfinite(place.y) && std::isfinite(place.z);
}

/// What is wrong with a table on this rank; empty: nothing.
std::string fault_of(const PointTable& table, int components) {
  const std::size_t points = table.place.size();
  std::ostringstream fault;
  if (table.mass.size() != static_cast<std::size_t>(components) * points ||
      (!table.number.empty() && table.number.size() != points) ||
      (!table.direction.empty() && (table.direction.size() != points || components != 1))) {
    fault << "points: " << points << " places, but " << table.mass.size() << " masses of " << components
          << " components, " << table.number.size() << " numbers and " << table.direction.size() << " directions";
  } else if (std::ranges::any_of(table.mass, [](double mass) { return !(mass >= 0.0) || std::isinf(mass); })) {
    fault << "points: a mass is not allowed, expected numbers >= 0 [kg]";
  } else if (!std::ranges::all_of(table.place, is_number)) {
    fault << "points: a place is not a number [m]";
  } else if (!table.frames.empty() && components != 1) {
    fault << "points: frames are for points of one component";
  } else if (!std::ranges::is_sorted(table.fixed) ||
             (!table.fixed.empty() && table.fixed.back() >= table.mass.size())) {
    fault << "points: fixed coordinates must be ascending and exist";
  }
  return fault.str();
}

PointTable checked(MPI_Comm comm, PointTable table, int components) {
  throw_together<InputError>(comm, fault_of(table, components));
  return table;
}

/// From end to end along the axis where that is furthest, over all ranks [m].
double largest_range(MPI_Comm comm, const std::vector<Place>& places) {
  constexpr std::array kAxes{&Place::x, &Place::y, &Place::z};
  std::array<double, 2 * kAxes.size()> ends{};
  ends.fill(-kInfinity);  // the first ones negative, so that one reduction finds all
  for (const Place& place : places) {
    for (std::size_t axis = 0; axis < kAxes.size(); ++axis) {
      ends[2 * axis] = std::max(ends[2 * axis], -(place.*kAxes[axis]));
      ends[2 * axis + 1] = std::max(ends[2 * axis + 1], place.*kAxes[axis]);
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, ends.data(), static_cast<int>(ends.size()), MPI_DOUBLE, MPI_MAX, comm);
  return std::max({ends[0] + ends[1], ends[2] + ends[3], ends[4] + ends[5]});
}

}  // namespace

Place Facing::at(const Place& place) const {
  if (!field) {
    return normal;
  }
  const auto surface = field->at(place.x, place.z);
  if (!surface) {
    return {};
  }
  const double size = std::hypot(surface->along_x, 1.0, surface->along_z);
  return {.x = -surface->along_x / size, .y = 1.0 / size, .z = -surface->along_z / size};
}

bool Region::holds(const Place& place) const {
  const auto between = [](double value, double least, double most) {
    const double bound =
        std::max(std::isfinite(least) ? std::abs(least) : 0.0, std::isfinite(most) ? std::abs(most) : 0.0);
    return value >= least - kEdgeTolerance * bound && value <= most + kEdgeTolerance * bound;
  };
  return between(place.x, from.x, to.x) && between(place.y, from.y, to.y) && between(place.z, from.z, to.z);
}

void require_on(const char* quantity, double x, const Extent& extent) {
  if (!(std::abs(x - extent.middle()) <= (0.5 + kEndTolerance) * extent.length())) {
    std::ostringstream message;
    message << quantity << ": " << x << " is not allowed, expected a number from " << extent.from << " to " << extent.to
            << " [m], on the beam";
    throw InputError{message.str()};
  }
}

MassPoints::MassPoints(MPI_Comm comm, int components, std::vector<double> mass, std::vector<std::size_t> fixed)
    : comm_{comm}, components_{components}, mass_{std::move(mass)}, fixed_{std::move(fixed)} {
  const auto own = static_cast<PetscInt>(points());
  MPI_Scan(&own, &begin_, 1, MPIU_INT, MPI_SUM, comm_);
  begin_ -= own;
  MPI_Allreduce(&own, &total_, 1, MPIU_INT, MPI_SUM, comm_);
}

double MassPoints::reference(std::size_t coordinate) const {
  if (components_ == 1) {
    const double up = axis(coordinate).y;
    return up == 1.0 ? place(coordinate).y : up == 0.0 ? 0.0 : up * place(coordinate).y;
  }
  const std::size_t component = coordinate / points();
  const Place at = place(coordinate % points());
  return component == 1 ? at.y : component == 0 ? at.x : at.z;
}

Place MassPoints::axis(std::size_t point) const {
  switch (direction(point)) {
    case Direction::x:
      return {.x = 1.0};
    case Direction::y:
      return kUp;
    case Direction::z:
      return {.z = 1.0};
    default:
      return {};
  }
}

PointRows MassPoints::single(PetscInt global) const {
  PointRows rows{.rows = {}, .count = 1};
  if (owns(global)) {
    const auto point = static_cast<std::size_t>(global - begin());
    rows.rows.push_back({.first = point, .last = point + 1});
    rows.mass = mass_[point];
  }
  MPI_Allreduce(MPI_IN_PLACE, &rows.mass, 1, MPI_DOUBLE, MPI_SUM, comm_);
  return rows;
}

PlacedPoints::PlacedPoints(MPI_Comm comm, int components, PointTable table)
    : PlacedPoints{checked(comm, std::move(table), components), comm, components} {}

PlacedPoints::PlacedPoints(PointTable&& table, MPI_Comm comm, int components)
    : MassPoints{comm, components, std::move(table.mass), std::move(table.fixed)},
      place_{std::move(table.place)},
      number_{std::move(table.number)},
      direction_{std::move(table.direction)},
      nodes_{table.nodes},
      frames_{std::move(table.frames)},
      turning_{std::move(table.turning)} {
  framed_.resize(frames_.empty() ? 0 : points());
  for (std::size_t frame = 0; frame < frames_.size(); ++frame) {
    for (std::size_t k = 0; k < 3; ++k) {
      framed_[frames_[frame].points.at(k)] = 1 + 3 * frame + k;
    }
  }
  for (std::size_t point = 0; point < points(); ++point) {
    if (direction(point) != Direction::other) {
      by_x_.push_back(point);
      total_mass_ += direction(point) == Direction::y ? this->mass()[point] : 0.0;
    }
  }
  std::ranges::stable_sort(by_x_, {}, [this](std::size_t point) { return place_[point].x; });
  std::array<double, 2> ends{-kInfinity, -kInfinity};  // negative, so that one reduction finds both
  for (const std::size_t point : by_x_) {
    if (direction(point) == Direction::y) {
      ends = {std::max(ends[0], -place_[point].x), std::max(ends[1], place_[point].x)};
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, ends.data(), 2, MPI_DOUBLE, MPI_MAX, comm);
  if (!(ends[1] >= -ends[0])) {
    throw InputError{"structure points: no unknown with mass moves along y, where supports and gravity act"};
  }
  extent_ = {.from = -ends[0], .to = ends[1]};
  MPI_Allreduce(MPI_IN_PLACE, &total_mass_, 1, MPI_DOUBLE, MPI_SUM, comm);
  largest_extent_ = largest_range(comm, place_);
}

std::optional<PlacedPoints::Framed> PlacedPoints::framed(std::size_t point) const {
  const std::size_t which = framed_.empty() ? 0 : framed_[point];
  return which == 0 ? std::nullopt : std::optional{Framed{&frames_[(which - 1) / 3], (which - 1) % 3}};
}

Place PlacedPoints::axis(std::size_t point) const {
  const auto found = framed(point);
  return found ? found->frame->axes.at(found->axis) : MassPoints::axis(point);
}

std::optional<std::array<std::size_t, 2>> PlacedPoints::beside(std::size_t point) const {
  const std::size_t all = 3 * nodes_;
  return point >= all ? std::nullopt : std::optional{std::array{(point + nodes_) % all, (point + 2 * nodes_) % all}};
}

bool PlacedPoints::moves_along(std::size_t point, const Facing& facing) const {
  constexpr double kSame = 1e-9;
  return distance(axis(point), facing.at(place_[point])) <= kSame;
}

std::vector<PointShare> PlacedPoints::height_of(PetscInt point) const {
  std::array<double, 7> told{};  // whether it has a frame, then points and shares
  if (owns(point)) {
    const auto local = static_cast<std::size_t>(point - begin());
    if (const auto found = framed(local)) {
      told[0] = 1.0;
      for (std::size_t k = 0; k < 3; ++k) {
        told.at(1 + k) = static_cast<double>(global(found->frame->points.at(k)));
        told.at(4 + k) = found->frame->axes.at(k).y;
      }
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, told.data(), static_cast<int>(told.size()), MPI_DOUBLE, MPI_SUM, comm());
  if (told[0] == 0.0) {
    return {{.point = point, .share = 1.0}};
  }
  std::vector<PointShare> shares(3);
  for (std::size_t k = 0; k < shares.size(); ++k) {
    shares[k] = {.point = static_cast<PetscInt>(told.at(1 + k)), .share = told.at(4 + k)};
  }
  return shares;
}

PetscInt PlacedPoints::nearest(const Place& place) const {
  // Both ways from where it would stand, until x alone is further away than what is found.
  const auto x_of = [this](std::size_t point) { return place_[point].x; };
  const auto from = std::ranges::lower_bound(by_x_, place.x, {}, x_of);
  std::array<double, 1> least{kInfinity};
  const auto walk = [&](const auto& begin, const auto& end, const auto& visit) {
    for (auto at = begin; at != end && std::abs(x_of(*at) - place.x) <= (1.0 + 3.0 * kNearTolerance) * least[0]; ++at) {
      if (direction(*at) == Direction::y) {
        visit(*at, distance(place_[*at], place));
      }
    }
  };
  const auto walk_both = [&](const auto& visit) {
    walk(from, by_x_.end(), visit);
    walk(std::make_reverse_iterator(from), by_x_.rend(), visit);
  };
  walk_both([&](std::size_t /*point*/, double away) { least[0] = std::min(least[0], away); });
  MPI_Allreduce(MPI_IN_PLACE, least.data(), 1, MPI_DOUBLE, MPI_MIN, comm());
  PetscInt first = total();
  walk_both([&](std::size_t point, double away) {
    if (away - least[0] <= 2.0 * kNearTolerance * (away + least[0])) {
      first = std::min(first, global(point));
    }
  });
  MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPIU_INT, MPI_MIN, comm());
  return first;
}

PointRows PlacedPoints::section(double x, const Region& region, const Facing& facing) const {
  std::array<double, 2> away{kInfinity, kInfinity};  // to the left and to the right
  Region slice = region;
  slice.from.x = -kInfinity;
  slice.to.x = kInfinity;
  const auto right = std::ranges::lower_bound(by_x_, x, {}, [this](std::size_t point) { return place_[point].x; });
  const auto find = [&](const auto& begin, const auto& end, double& least) {
    const auto found = std::find_if(
        begin, end, [&](std::size_t point) { return slice.holds(place_[point]) && moves_along(point, facing); });
    least = found != end ? std::abs(place_[*found].x - x) : kInfinity;
  };
  find(std::make_reverse_iterator(right), by_x_.rend(), away[0]);
  find(right, by_x_.end(), away[1]);
  MPI_Allreduce(MPI_IN_PLACE, away.data(), 2, MPI_DOUBLE, MPI_MIN, comm());
  const bool left = std::isfinite(away[0]) && away[0] - away[1] <= 2.0 * kNearTolerance * (away[0] + away[1]);
  const double nearest = left ? x - away[0] : x + away[1];
  const double thickness = kEndTolerance * extent_.length();  // of points whose x was typed
  slice.from.x = nearest - thickness;
  slice.to.x = nearest + thickness;
  return within(slice, facing);
}

PointRows PlacedPoints::within(const Region& region, const Facing& facing) const {
  const auto slack = [](double edge) { return std::isfinite(edge) ? 2.0 * kEdgeTolerance * std::abs(edge) : 0.0; };
  const double tolerance = slack(region.from.x) + slack(region.to.x);
  const auto x_of = [this](std::size_t point) { return place_[point].x; };
  std::vector<std::size_t> touched;
  std::copy_if(std::ranges::lower_bound(by_x_, region.from.x - tolerance, {}, x_of),
               std::ranges::upper_bound(by_x_, region.to.x + tolerance, {}, x_of), std::back_inserter(touched),
               [&](std::size_t point) { return region.holds(place_[point]) && moves_along(point, facing); });
  std::ranges::sort(touched);
  PointRows rows;
  std::array<double, 2> sums{static_cast<double>(touched.size()), 0.0};
  for (const std::size_t point : touched) {
    sums[1] += mass()[point];
    if (rows.rows.empty() || rows.rows.back().last != point) {
      rows.rows.push_back({.first = point, .last = point});
    }
    rows.rows.back().last = point + 1;
  }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), 2, MPI_DOUBLE, MPI_SUM, comm());
  rows.count = static_cast<PetscInt>(sums[0]);
  rows.mass = sums[1];
  return rows;
}

}  // namespace udar
