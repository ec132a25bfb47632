#include "udar/structure/load.hpp"

#include <algorithm>

#include "udar/petsc/error.hpp"

namespace udar {

Loads::Loads(const MassPoints& points, double gravity, const std::vector<NodalLoad>& nodal) : gravity_{gravity} {
  nodes_ = points.points();
  if (gravity != 0.0) {
    weight_.reserve(nodes_);
    for (std::size_t point = 0; point < nodes_; ++point) {
      const double up = points.axis(point).y;
      weight_.push_back(up == 0.0 ? 0.0 : -gravity * up * points.mass()[point]);
    }
  }
  for (const NodalLoad& load : nodal) {
    bool ascending = std::ranges::is_sorted(load.time);
    for (std::size_t i = 0; i + 1 < load.time.size(); ++i) {
      if (load.time[i] == load.time[i + 1]) {
        ascending = ascending && (i + 2 == load.time.size() || load.time[i + 2] > load.time[i]);
        jumps_.push_back(load.time[i]);
      }
    }
    if (load.time.empty() || load.time.size() != load.force.size() || !ascending) {
      throw InputError{
          "load table: the times [s] of a load table must be ascending, two equal ones for a jump, with a "
          "force "
          "[N] each"};
    }
    require_on("load position", load.position, points.extent());
    kinks_.insert(kinks_.end(), load.time.begin(), load.time.end());
    time_dependent_ = time_dependent_ || load.time.size() > 1;
    for (const auto& [point, share] : points.lever({.x = load.position})) {
      if (points.owns(point)) {
        local_.push_back({.number = count_, .local_node = point - points.begin(), .share = share, .table = load});
      }
    }
    ++count_;
  }
  for (auto* times : {&kinks_, &jumps_}) {
    std::ranges::sort(*times);
    times->erase(std::ranges::unique(*times).begin(), times->end());
  }
}

bool Loads::jumps_at(double time) const {
  const auto next = std::ranges::lower_bound(jumps_, time, {}, just_after);
  return next != jumps_.end() && *next <= just_after(time);
}

Loads::ForceAndRate Loads::evaluate(const NodalLoad& load, const Instant& at) {
  const auto after = std::ranges::upper_bound(load.time, just_after(at.begin));
  if (after == load.time.begin()) {
    return {.force = load.force.front(), .rate = 0.0};
  }
  if (after == load.time.end()) {
    return {.force = load.force.back(), .rate = 0.0};
  }
  const auto right = static_cast<std::size_t>(after - load.time.begin());
  const double rate = (load.force[right] - load.force[right - 1]) / (load.time[right] - load.time[right - 1]);
  return {.force = load.force[right - 1] + rate * (at.time - load.time[right - 1]), .rate = rate};
}

std::size_t Loads::interval(double time) const {
  return static_cast<std::size_t>(std::ranges::upper_bound(kinks_, just_after(time)) - kinks_.begin());
}

/// Weight and loads together. @param value of one table
template <class Value>
std::span<const double> Loads::sum(std::vector<double>& work, const Value& value) const {
  if (local_.empty()) {
    return weight_;
  }
  work = weight_;
  work.resize(nodes_);
  for (const LocalLoad& load : local_) {
    work[static_cast<std::size_t>(load.local_node)] += load.share * value(load.table);
  }
  return work;
}

std::span<const double> Loads::force(const Instant& at, std::vector<double>& work) const {
  return sum(work, [&](const NodalLoad& load) { return evaluate(load, at).force; });
}

std::span<const double> Loads::mean(double from, double to, std::vector<double>& work) const {
  return sum(work, [&](const NodalLoad& load) {
    double impulse = 0.0;
    each_piece(load, from, to, [&](double begin, double end) {
      impulse += (end - begin) * evaluate(load, {0.5 * (begin + end), begin}).force;
    });
    return impulse / (to - from);
  });
}

std::span<const double> Loads::rate(const Instant& at, std::vector<double>& work) const {
  if (local_.empty()) {
    return {};
  }
  work.assign(nodes_, 0.0);
  for (const LocalLoad& load : local_) {
    work[static_cast<std::size_t>(load.local_node)] += load.share * evaluate(load.table, at).rate;
  }
  return work;
}

}  // namespace udar
