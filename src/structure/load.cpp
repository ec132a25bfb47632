#include "udar/structure/load.hpp"

#include <algorithm>
#include <cstdint>
#include <sstream>
#include <utility>

#include "structure/place_algebra.hpp"
#include "udar/petsc/error.hpp"

namespace udar {

namespace {

/// Minus the masses along the direction in which the base moves; what is held goes with it.
LoadPattern inertia_of(const MassPoints& points, const BaseMotion& base) {
  LoadPattern pattern{.point = {}, .share = {}, .table = base.acceleration(), .inertia = true};
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

}  // namespace

Loads::Loads(const MassPoints& points, double gravity, const std::vector<NodalLoad>& nodal,
             std::span<const BaseMotion> base)
    : gravity_{gravity}, nodes_{points.points()} {
  if (gravity != 0.0) {
    weight_.reserve(nodes_);
    for (std::size_t point = 0; point < nodes_; ++point) {
      const double up = points.axis(point).y;
      weight_.push_back(up == 0.0 ? 0.0 : -gravity * up * points.mass()[point]);
    }
  }
  for (const NodalLoad& load : nodal) {
    require_on("load position", load.position, points.extent());
    if (!load.table) {
      throw InputError{"load table: none is given for a load, expected a force over time [N]"};
    }
    LoadPattern pattern{.point = {}, .share = {}, .table = load.table};
    for (const auto& [point, share] : points.lever({.x = load.position})) {
      if (points.owns(point)) {
        pattern.point.push_back(static_cast<std::size_t>(point - points.begin()));
        pattern.share.push_back(share);
      }
    }
    add(std::move(pattern));
  }
  for (const BaseMotion& motion : base) {
    add(inertia_of(points, motion));
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
  loaded_ = loaded_ || !pattern.point.empty();
  patterns_.push_back(std::move(pattern));
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
