#include "udar/structure/load.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <sstream>
#include <string>
#include <utility>

#include "structure/beam_nodes.hpp"
#include "structure/place_algebra.hpp"
#include "udar/petsc/error.hpp"

namespace udar {

namespace {

/// Minus the masses along the direction in which the base moves; what is held goes with it.
LoadPattern inertia_of(const MassPoints& points, const BaseMotion& base) {
  LoadPattern pattern{.point = {}, .share = {}, .table = base.acceleration(), .cause = LoadCause::base};
  for (std::size_t point = 0; point < points.points(); ++point) {
    const double along = dot(points.axis(point), base.direction());
    if (along != 0.0 && points.mass()[point] > 0.0 && !points.fixed(point)) {
      pattern.point.push_back(point);
      pattern.share.push_back(-along * points.mass()[point]);
    }
  }
  auto moving = static_cast<std::int64_t>(pattern.point.size());
  MPI_Allreduce(MPI_IN_PLACE, &moving, 1, MPI_INT64_T, MPI_SUM, points.comm());
  if (moving == 0) {
    const auto [x, y, z] = base.direction();
    std::ostringstream message;
    message << "base motion direction: (" << x << ", " << y << ", " << z
            << ") is not allowed, no mass moves that way, expected a direction in which some do";
    throw InputError{message.str()};
  }
  return pattern;
}

/// The nodes that a force meets on its way along a beam.
struct Way {
  std::vector<double> x;  // [m], of all ranks
  std::size_t begin = 0;  // of this rank's

  /// Adds a node's share to a pattern, if the node is this rank's.
  void add(const MassPoints& points, std::size_t node, double share, LoadPattern& pattern) const {
    if (node < begin || node - begin >= points.own_points()) {
      return;
    }
    const std::size_t point = node - begin;
    pattern.point.push_back(point);
    pattern.share.push_back(share);
    each_own(points, [&](const Strike& strike, std::size_t centre, std::size_t gap) {
      if (centre == point) {
        pattern.point.push_back(gap);
        pattern.share.push_back(share * strike.gap_in_node());
      }
    });
  }
};

/// @param quantity that asks for one @note Collective.
Way way_along(const MassPoints& points, const char* quantity) {
  return {.x = beam_nodes(points, quantity), .begin = static_cast<std::size_t>(points.nodes().begin())};
}

void require_load(const NodalLoad& load, const Extent& extent) {
  require_on("load position, load place", load.position, extent);
  if (!load.table) {
    throw InputError{"load table: none is given for a load, expected a force over time [N]"};
  }
  if (load.breadth > 0.0 && load.width == 0.0) {
    throw InputError{"load breadth: not allowed without a length along the beam, `load width`, expected 0 [m]"};
  }
  if (load.width != 0.0 && (load.direction.x != 0.0 || load.direction.y != 1.0 || load.direction.z != 0.0)) {
    throw InputError{"load width: not allowed with another `load direction` than 0,1,0, expected 0 [m]"};
  }
}

/// Even over a length: hats of the nodes keep force and moment. @note Collective.
LoadPattern spread(const MassPoints& points, const NodalLoad& load) {
  const Way along = way_along(points, "load width");
  const std::vector<double>& way = along.x;
  if (!(load.width > 0.0)) {
    throw InputError{"load width: " + std::to_string(load.width) +
                     " is not allowed, expected a number >= 0 or inf [m]"};
  }
  const bool all = std::isinf(load.width);
  const double from = all ? way.front() : load.position - 0.5 * load.width;
  const double to = all ? way.back() : load.position + 0.5 * load.width;
  for (const double edge : {from, to}) {
    require_on("load position, load width", edge, points.extent());
  }
  std::vector<double> share(way.size(), 0.0);
  for (std::size_t node = 0; node + 1 < way.size(); ++node) {
    const double length = way[node + 1] - way[node];
    const double left = std::clamp(from - way[node], 0.0, length);
    const double right = std::clamp(to - way[node], 0.0, length);
    const double of_next = 0.5 * (right * right - left * left) / length;
    share[node] += (right - left - of_next) / (to - from);
    share[node + 1] += of_next / (to - from);
  }
  const double total = load.breadth > 0.0 ? load.breadth * (to - from) : 1.0;
  LoadPattern pattern{.point = {}, .share = {}, .table = load.table};
  for (std::size_t node = 0; node < share.size(); ++node) {
    if (share[node] > 0.0) {
      along.add(points, node, total * share[node], pattern);
    }
  }
  return pattern;
}

/// What acts along a direction across y at a node that moves in space, on its points. @note Collective.
std::vector<PointShare> dealt_across(const MassPoints& points, const NodalLoad& load) {
  const PetscInt node = points.nearest(load.place());
  std::array<double, 7> told{};  // whether it moves in space, then points and shares
  const MassPoints& nodes = points.nodes();
  if (points.owns(node)) {
    const auto own = static_cast<std::size_t>(node - points.begin());
    if (const auto others = nodes.beside(own)) {
      const Place across = load.direction - load.direction.y * kUp;
      told[0] = 1.0;
      for (std::size_t k = 0; const std::size_t point : {own, (*others)[0], (*others)[1]}) {
        told.at(1 + k) = static_cast<double>(points.global(point));
        told.at(4 + k) = dot(nodes.axis(point), across);
        ++k;
      }
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, told.data(), static_cast<int>(told.size()), MPI_DOUBLE, MPI_SUM, points.comm());
  if (told[0] == 0.0) {
    throw InputError{"load direction: not allowed but with nodes that move in space, expected 0,1,0, which is up"};
  }
  std::vector<PointShare> shares;
  for (std::size_t k = 0; k < 3; ++k) {
    if (told.at(4 + k) != 0.0) {
      shares.push_back({.point = static_cast<PetscInt>(told.at(1 + k)), .share = told.at(4 + k)});
    }
  }
  return points.of_unknowns(std::move(shares));
}

}  // namespace

std::vector<PointShare> dealt(const MassPoints& points, const NodalLoad& load) {
  std::vector<PointShare> shares;
  if (load.direction.x != 0.0 || load.direction.z != 0.0) {
    shares = dealt_across(points, load);
  }
  if (load.direction.y != 0.0) {
    for (const auto& [point, share] : points.lever(load.place())) {
      shares.push_back({.point = point, .share = load.direction.y * share});
    }
  }
  return shares;
}

Loads::Loads(const MassPoints& points, double gravity, const std::vector<NodalLoad>& nodal,
             std::span<const BaseMotion> base, std::span<const TravellingLoad> travelling,
             std::span<const HeldMove> held)
    : gravity_{gravity}, nodes_{points.points()} {
  for (const HeldMove& move : held) {
    for (const MovedPoint& moved : move.points) {
      if (moved.held() && moved.here()) {
        moved_.push_back(moved.point);
      }
    }
  }
  std::ranges::sort(moved_);
  if (gravity != 0.0) {
    weight_.reserve(nodes_);
    for (std::size_t point = 0; point < nodes_; ++point) {
      const double up = points.axis(point).y;
      weight_.push_back(up == 0.0 ? 0.0 : -gravity * up * points.mass()[point]);
    }
    for (const std::size_t point : moved_) {
      weight_[point] = 0.0;
    }
  }
  for (const NodalLoad& load : nodal) {
    require_load(load, points.extent());
    if (load.width != 0.0) {
      add(spread(points, load));
      continue;
    }
    LoadPattern pattern{.point = {}, .share = {}, .table = load.table};
    for (const auto& [point, share] : dealt(points, load)) {
      if (points.owns(point)) {
        pattern.point.push_back(static_cast<std::size_t>(point - points.begin()));
        pattern.share.push_back(share);
      }
    }
    add(std::move(pattern));
  }
  const Way way = travelling.empty() ? Way{} : way_along(points, "load axles");
  for (const TravellingLoad& load : travelling) {
    for (std::size_t node = 0; auto& table : node_tables(load, way.x)) {
      LoadPattern pattern{.point = {}, .share = {}, .table = std::move(table)};
      way.add(points, node++, 1.0, pattern);
      add(std::move(pattern));
    }
  }
  for (const Rider& rider : points.riders()) {  // what it weighs enters and leaves at once
    jumps_.insert(jumps_.end(), {rider.passage.enters(), rider.passage.leaves()});
  }
  for (const BaseMotion& motion : base) {
    add(inertia_of(points, motion));
  }
  for (const HeldMove& move : held) {
    add_move(move);
  }
  for (auto* times : {&kinks_, &jumps_}) {
    std::ranges::sort(*times);
    times->erase(std::ranges::unique(*times).begin(), times->end());
  }
}

void Loads::add(LoadPattern pattern) {
  const TimeTable& table = *pattern.table;
  kinks_.insert(kinks_.end(), table.time().begin(), table.time().end());
  const std::vector<double> jumps = table.jumps();
  jumps_.insert(jumps_.end(), jumps.begin(), jumps.end());
  time_dependent_ = time_dependent_ || !table.steady();
  // What holds a point takes the force on it.
  for (std::size_t i = pattern.point.size(); pattern.cause != LoadCause::held && i-- > 0;) {
    if (std::ranges::binary_search(moved_, pattern.point[i])) {
      pattern.point.erase(pattern.point.begin() + static_cast<std::ptrdiff_t>(i));
      pattern.share.erase(pattern.share.begin() + static_cast<std::ptrdiff_t>(i));
    }
  }
  loaded_ = loaded_ || !pattern.point.empty();
  patterns_.push_back(std::move(pattern));
}

/// A pattern of what is held and one of springs, if there are such.
void Loads::add_move(const HeldMove& move) {
  for (const LoadCause cause : {LoadCause::held, LoadCause::spring}) {
    LoadPattern pattern{.point = {}, .share = {}, .table = move.table, .cause = cause};
    bool any = false;
    for (const MovedPoint& moved : move.points) {
      if (moved.held() != (cause == LoadCause::held)) {
        continue;
      }
      any = true;
      if (moved.here()) {
        pattern.point.push_back(moved.point);
        pattern.share.push_back(moved.held() ? moved.share : moved.stiffness * moved.share);
      }
    }
    if (any) {
      add(std::move(pattern));
    }
  }
}

bool Loads::jumps_at(double time) const {
  const auto next = std::ranges::lower_bound(jumps_, time, {}, TimeTable::just_after);
  return next != jumps_.end() && *next <= TimeTable::just_after(time);
}

std::size_t Loads::interval(double time) const {
  return static_cast<std::size_t>(std::ranges::upper_bound(kinks_, TimeTable::just_after(time)) - kinks_.begin());
}

/// Adds all patterns up. @param value of a table
template <class Value>
void Loads::sum(std::vector<double>& work, const Value& value) const {
  for (const LoadPattern& pattern : patterns_) {
    const double factor = pattern.point.empty() ? 0.0 : value(*pattern.table);
    for (std::size_t i = 0; i < pattern.point.size(); ++i) {
      work[pattern.point[i]] += pattern.share[i] * factor;
    }
  }
}

std::span<const double> Loads::force(const Instant& at, std::vector<double>& work) const {
  if (!loaded_) {
    return weight_;
  }
  work = weight_;
  work.resize(nodes_);
  sum(work, [&](const TimeTable& table) { return table.at(at).value; });
  return work;
}

std::span<const double> Loads::mean(double from, double to, std::vector<double>& work) const {
  if (!loaded_) {
    return weight_;
  }
  work = weight_;
  work.resize(nodes_);
  sum(work, [&](const TimeTable& table) {
    double impulse = 0.0;
    table.each_piece(from, to, [&](double begin, double end) {
      impulse += (end - begin) * table.at({0.5 * (begin + end), begin}).value;
    });
    return impulse / (to - from);
  });
  return work;
}

std::span<const double> Loads::rate(const Instant& at, std::vector<double>& work) const {
  if (!loaded_) {
    return {};
  }
  work.assign(nodes_, 0.0);
  sum(work, [&](const TimeTable& table) { return table.at(at).rate; });
  return work;
}

}  // namespace udar
