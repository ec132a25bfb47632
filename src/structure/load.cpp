#include "udar/structure/load.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "udar/petsc/error.hpp"

namespace udar {

Loads::Loads(const BeamChain& beam, double gravity, const std::vector<NodalLoad>& nodal) : gravity_{gravity} {
  nodes_ = static_cast<std::size_t>(beam.local_nodes());
  if (gravity != 0.0) {
    weight_.reserve(nodes_);
    for (PetscInt node = beam.begin(); node < beam.end(); ++node) {
      weight_.push_back(-gravity * beam.mass(node));
    }
  }
  for (const NodalLoad& load : nodal) {
    if (load.time.empty() || load.time.size() != load.force.size() ||
        std::ranges::adjacent_find(load.time, std::ranges::greater_equal{}) != load.time.end()) {
      throw InputError{
          "option -load_table: the times [s] of a load table must be strictly ascending, with a force [N] each"};
    }
    if (!(load.position >= 0.0 && load.position <= beam.length())) {
      throw InputError{"option -load_position: " + std::to_string(load.position) +
                       " is off the beam, expected from 0 to " + std::to_string(beam.length()) + " [m]"};
    }
    kinks_.insert(kinks_.end(), load.time.begin(), load.time.end());
    const PetscInt node = beam.nearest_node(load.position);
    if (node >= beam.begin() && node < beam.end()) {
      local_.push_back({.local_node = node - beam.begin(), .table = load});
    }
  }
  std::ranges::sort(kinks_);
  kinks_.erase(std::ranges::unique(kinks_).begin(), kinks_.end());
}

Loads::ForceAndRate Loads::evaluate(const NodalLoad& load, double time) {
  // Steps end at kinks but for the last bits: what follows one must not take the slope before it.
  constexpr double kInstant = 8.0 * std::numeric_limits<double>::epsilon();
  const auto after = std::ranges::upper_bound(load.time, time + kInstant * std::abs(time));
  if (after == load.time.begin()) {
    return {.force = load.force.front(), .rate = 0.0};
  }
  if (after == load.time.end()) {
    return {.force = load.force.back(), .rate = 0.0};
  }
  const auto right = static_cast<std::size_t>(after - load.time.begin());
  const double rate = (load.force[right] - load.force[right - 1]) / (load.time[right] - load.time[right - 1]);
  return {.force = load.force[right - 1] + rate * (time - load.time[right - 1]), .rate = rate};
}

std::span<const double> Loads::force(double time, std::vector<double>& work) const {
  if (local_.empty()) {
    return weight_;
  }
  work = weight_;
  work.resize(nodes_);
  for (const LocalLoad& load : local_) {
    work[static_cast<std::size_t>(load.local_node)] += evaluate(load.table, time).force;
  }
  return work;
}

std::span<const double> Loads::rate(double time, std::vector<double>& work) const {
  if (local_.empty()) {
    return {};
  }
  work.assign(nodes_, 0.0);
  for (const LocalLoad& load : local_) {
    work[static_cast<std::size_t>(load.local_node)] += evaluate(load.table, time).rate;
  }
  return work;
}

}  // namespace udar
