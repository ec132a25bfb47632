#include "udar/structure/mass_points.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <sstream>
#include <string>

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

}  // namespace

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
    return direction(coordinate) == Direction::y ? place(coordinate).y : 0.0;
  }
  const std::size_t component = coordinate / points();
  const Place at = place(coordinate % points());
  return component == 1 ? at.y : component == 0 ? at.x : at.z;
}

PointRows MassPoints::all() const {
  PointRows rows{.rows = {}, .count = total_, .mass = total_mass()};
  if (points() > 0) {
    rows.rows.push_back({.first = 0, .last = points()});
  }
  return rows;
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
      direction_{std::move(table.direction)} {
  for (std::size_t point = 0; point < points(); ++point) {
    if (direction(point) == Direction::y) {
      by_x_.push_back(point);
      total_mass_ += this->mass()[point];
    }
  }
  std::ranges::stable_sort(by_x_, {}, [this](std::size_t point) { return place_[point].x; });
  std::array<double, 2> ends{-kInfinity, -kInfinity};  // negative, so that one reduction finds both
  if (!by_x_.empty()) {
    ends = {-place_[by_x_.front()].x, place_[by_x_.back()].x};
  }
  MPI_Allreduce(MPI_IN_PLACE, ends.data(), 2, MPI_DOUBLE, MPI_MAX, comm);
  if (!(ends[1] >= -ends[0])) {
    throw InputError{"structure points: no unknown with mass moves along y, where supports and gravity act"};
  }
  extent_ = {.from = -ends[0], .to = ends[1]};
  MPI_Allreduce(MPI_IN_PLACE, &total_mass_, 1, MPI_DOUBLE, MPI_SUM, comm);
}

PetscInt PlacedPoints::nearest(const Place& place) const {
  // Both ways from where it would stand, until x alone is further away than what is found.
  const auto x_of = [this](std::size_t point) { return place_[point].x; };
  const auto from = std::ranges::lower_bound(by_x_, place.x, {}, x_of);
  std::array<double, 1> least{kInfinity};
  const auto walk = [&](const auto& begin, const auto& end, const auto& visit) {
    for (auto at = begin; at != end && std::abs(x_of(*at) - place.x) <= (1.0 + 3.0 * kNearTolerance) * least[0]; ++at) {
      visit(*at, distance(place_[*at], place));
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

PointRows PlacedPoints::section(double x) const {
  const auto x_of = [this](std::size_t point) { return place_[point].x; };
  const auto right = std::ranges::lower_bound(by_x_, x, {}, x_of);
  std::array<double, 2> away{kInfinity, kInfinity};  // to the left and to the right
  if (right != by_x_.begin()) {
    away[0] = x - x_of(*(right - 1));
  }
  if (right != by_x_.end()) {
    away[1] = x_of(*right) - x;
  }
  MPI_Allreduce(MPI_IN_PLACE, away.data(), 2, MPI_DOUBLE, MPI_MIN, comm());
  const bool left = std::isfinite(away[0]) && away[0] - away[1] <= 2.0 * kNearTolerance * (away[0] + away[1]);
  const double nearest = left ? x - away[0] : x + away[1];
  const double thickness = kEndTolerance * extent_.length();  // of points whose x was typed
  return within(nearest - thickness, nearest + thickness);
}

PointRows PlacedPoints::within(double from, double to) const {
  const double tolerance = kEdgeTolerance * std::max(std::abs(from), std::abs(to));
  const auto x_of = [this](std::size_t point) { return place_[point].x; };
  std::vector<std::size_t> touched(std::ranges::lower_bound(by_x_, from - tolerance, {}, x_of),
                                   std::ranges::upper_bound(by_x_, to + tolerance, {}, x_of));
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
