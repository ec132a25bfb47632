#include "app/body_motion.hpp"

#include <mpi.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>

#include "app/run_layout.hpp"
#include "udar/io/run_writers.hpp"
#include "udar/motion/motion_state.hpp"
#include "udar/petsc/error.hpp"
#include "udar/structure/beam_chain.hpp"
#include "udar/structure/initial_state.hpp"
#include "udar/structure/network.hpp"
#include "udar/structure/solid_motions.hpp"
#include "udar/structure/striker.hpp"

namespace udar::app {
namespace {

constexpr const char* kDeflection = "deflection_peak";
constexpr const char* kRebound = "rebound_search";

bool in_parts(const Structure& structure) {
  if (const BeamChain* beam = structure.chain(); beam != nullptr) {
    return std::ranges::any_of(beam->parameters().segments, &BeamSegment::is_gap);
  }
  const Network* network = structure.network();
  return network != nullptr && network->connected_parts() > 1;
}

/// Whether between contacts nothing but gravity moves the centre of mass, and all it hits stands below or above.
bool falls_freely(const Case& input, const Structure& structure) {
  return !structure.grounded() && input.loads.empty() && input.travelling_loads.empty() && input.base_motion.empty() &&
         input.strikers.empty() && input.pairs.empty() && !input.supports.empty() &&
         std::ranges::none_of(input.supports, &Support::in_space);
}

}  // namespace

BodyMotion::BodyMotion(const Case& input, const Structure& structure, const ImpactDynamics& dynamics)
    : structure_{&structure},
      points_{&structure.elastic().points()},
      dynamics_{&dynamics},
      interval_{io::sampling_interval(input.output.interval, longest_sample(input))},
      node_{structure.topology().node},
      apart_{in_parts(structure)} {
  if (node_.empty()) {
    node_.resize(points_->points());
    std::iota(node_.begin(), node_.end(), std::size_t{0});
  }
  if (!structure.grounded() && !apart_) {
    solid_ = solid_motions(*points_);
  }
  if (structure.grounded()) {
    unstrained_ = reference_axis(*points_, input.initial);
  } else {  // what is lifted as a solid is taken off with all such motion
    for (std::size_t point = 0; point < points_->points(); ++point) {
      unstrained_.push_back(points_->reference(point));
    }
  }
  if (falls_freely(input, structure)) {
    search_.emplace(input.gravity);
  }
}

/// Of each motion as a solid in the displacement of the line, then height and velocity of the centre of mass.
std::vector<double> BodyMotion::shares(const Snapshot& state, const std::vector<double>& displacement) const {
  const std::span<const double> mass = points_->mass();
  const std::vector<double> position = node_values(structure_->points(), state.values("mass_position"));
  const std::vector<double> velocity = node_values(structure_->points(), state.values("mass_velocity"));
  std::vector<double> sums(solid_.size() + 2, 0.0);
  for (std::size_t i = 0; i < displacement.size(); ++i) {
    for (std::size_t k = 0; k < solid_.size(); ++k) {
      sums[k] += mass[i] * solid_[k][i] * displacement[i];
    }
    const double up = points_->axis(i).y * mass[i];
    sums[solid_.size()] += up * position[i];
    sums[solid_.size() + 1] += up * velocity[i];
  }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM, points_->comm());
  sums[solid_.size()] /= points_->total_mass();
  sums[solid_.size() + 1] /= points_->total_mass();
  return sums;
}

void BodyMotion::snapshot(const Snapshot& state) {
  std::vector<double> displacement = node_values(structure_->points(), state.values("line_position"));
  for (std::size_t i = 0; i < displacement.size(); ++i) {
    displacement[i] -= unstrained_[i];
  }
  if (!solid_.empty() || search_) {
    const std::vector<double> sums = shares(state, displacement);
    for (std::size_t k = 0; k < solid_.size(); ++k) {
      for (std::size_t i = 0; i < displacement.size(); ++i) {
        displacement[i] -= sums[k] * solid_[k][i];
      }
    }
    if (search_) {
      rows_.push_back({.time = state.time, .height = sums[solid_.size()], .velocity = sums[solid_.size() + 1]});
    }
  }
  widen(state.time, displacement);
}

void BodyMotion::widen(double time, const std::vector<double>& displacement) {
  std::vector<double> square(node_.size(), 0.0);
  for (std::size_t i = 0; i < displacement.size(); ++i) {
    if (points_->direction(i) != Direction::other) {
      square[node_[i]] += displacement[i] * displacement[i];
    }
  }
  for (std::size_t i = 0; i < displacement.size(); ++i) {
    if (const double size = std::sqrt(square[node_[i]]); size > peak_.value) {
      const auto [x, y, z] = points_->place(i);
      peak_ = {.value = size, .x = x, .y = y, .z = z, .time = time};
    }
  }
}

std::optional<double> BodyMotion::first_contact() const {
  const double time = dynamics_->counts().first_contact_time;
  return time >= 0.0 ? std::optional{time} : std::nullopt;
}

void BodyMotion::flush() {
  for (; !rows_.empty(); rows_.pop_front()) {
    search_->add(rows_.front(), first_contact());
  }
}

std::optional<io::Peak> BodyMotion::deflection() const {
  if (apart_) {
    return std::nullopt;
  }
  return io::largest_of_all(points_->comm(), peak_);
}

void BodyMotion::save(MotionState& state) const {
  const auto [value, x, y, z, time, member] = io::largest_of_all(points_->comm(), peak_);
  state.tables[kDeflection] = {value, x, y, z, time};
  state.tables[kRebound] = search_ ? search_->saved() : std::vector<double>{};
}

void BodyMotion::restore(const MotionState& state) {
  constexpr std::size_t kNumbers = 5;
  const std::vector<double>& peak = state.table(kDeflection);
  if (peak.size() != kNumbers) {
    throw InputError{"restart file: the largest deflection has " + std::to_string(peak.size()) + " numbers, expected " +
                     std::to_string(kNumbers)};
  }
  peak_ = {.value = peak[0], .x = peak[1], .y = peak[2], .z = peak[3], .time = peak[4]};
  if (search_) {
    search_->restore(state.table(kRebound));
  }
}

}  // namespace udar::app
