#include "app/field_errors.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <sstream>

#include "udar/petsc/warnings.hpp"

namespace udar::app {
namespace {

constexpr const char* kErrors = "height_field_error";
constexpr const char* kErrorTimes = "height_field_error_time";

/// How far the node of a point is from where it stands.
Place way_of(const MassPoints& points, std::size_t point, std::span<const double> position) {
  Place way{};
  const auto add = [&](std::size_t own) {
    const Place axis = points.axis(own);
    const double value = position[own] - points.reference(own);
    way = {.x = way.x + value * axis.x, .y = way.y + value * axis.y, .z = way.z + value * axis.z};
  };
  add(point);
  if (const auto others = points.beside(point)) {
    add((*others)[0]);
    add((*others)[1]);
  }
  return way;
}

}  // namespace

FieldErrors::FieldErrors(const MassPoints& points, const Case& input)
    : points_{&points},
      interval_{input.output.interval},
      contacts_{find_contacts(points, input.supports)},
      hit_(points.points(), 0),
      error_(points.points(), 0.0),
      time_(points.points(), 0.0) {
  for (std::size_t number = 0; number < contacts_.sets.size(); ++number) {
    const ContactSet& set = contacts_.sets[number];
    const auto& field = contacts_.supports[static_cast<std::size_t>(set.support)].field;
    for (std::size_t point = set.first; point < set.last && field; ++point) {
      const Place place = points.place(point);
      faced_.push_back({.point = point, .set = number, .plane = field->at(place.x, place.z).value()});
    }
  }
}

/// Of the plane beside the field above or below where the mass is, along the normal [m].
double FieldErrors::error_of(const Faced& faced, std::span<const double> position) const {
  const ContactSet& set = contacts_.sets[faced.set];
  const HeightGrid& field = *contacts_.supports[static_cast<std::size_t>(set.support)].field;
  const Place place = points_->place(faced.point);
  const auto [x, y, z] = way_of(*points_, faced.point, position);
  const auto [height, along_x, along_z] = faced.plane;
  const auto now = field.at(place.x + x, place.z + z);
  return now ? points_->axis(faced.point).y * std::abs(now->height - height - along_x * x - along_z * z)
             : std::numeric_limits<double>::infinity();
}

void FieldErrors::snapshot(const Snapshot& state) {
  const std::span<const double> position = state.values("mass_position");
  const std::span<const std::uint8_t> resting = find_field(state.fields, kRestingField.name).flags();
  for (const Faced& faced : faced_) {
    const std::size_t point = faced.point;
    const ContactSet& set = contacts_.sets[faced.set];
    const double error = error_of(faced, position);
    const double gap = set.side * (position[point] - set.height(point));
    // The plane, or the field itself, is no further away than they are apart.
    const bool touches = resting[point] != 0 || hit_[point] != 0 || gap <= (std::isfinite(error) ? error : 0.0);
    if (touches && error > error_[point]) {
      error_[point] = error;
      time_[point] = state.time;
    }
  }
  std::ranges::fill(hit_, 0);
}

void FieldErrors::events(std::span<const ImpactRecord> impacts, std::span<const RestRecord> /*rests*/,
                         const EventCounts& /*all*/) {
  for (const ImpactRecord& impact : impacts) {
    hit_[static_cast<std::size_t>(impact.node - points_->begin())] = 1;
  }
}

void FieldErrors::save(MotionState& state) const {
  state.fields[kErrors] = error_;
  state.fields[kErrorTimes] = time_;
}

void FieldErrors::restore(const MotionState& state) {
  error_ = state.field(kErrors, error_.size());
  time_ = state.field(kErrorTimes, time_.size());
}

FieldErrors::Worst FieldErrors::worst(double tolerance) const {
  const auto largest = std::ranges::max_element(error_);
  struct {
    double error;
    int rank;
  } most{.error = largest != error_.end() ? *largest : -1.0, .rank = 0};
  int rank = 0;
  MPI_Comm_rank(points_->comm(), &rank);
  most.rank = rank;
  MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_DOUBLE_INT, MPI_MAXLOC, points_->comm());
  std::array<double, 4> where{};
  if (rank == most.rank && largest != error_.end()) {
    const auto point = static_cast<std::size_t>(largest - error_.begin());
    const auto [x, y, z] = points_->place(point);
    where = {x, y, z, time_[point]};
  }
  MPI_Bcast(where.data(), static_cast<int>(where.size()), MPI_DOUBLE, most.rank, points_->comm());
  auto masses =
      static_cast<std::int64_t>(std::ranges::count_if(error_, [tolerance](double error) { return error > tolerance; }));
  MPI_Allreduce(MPI_IN_PLACE, &masses, 1, MPI_INT64_T, MPI_SUM, points_->comm());
  return {.peak = {.value = most.error, .x = where[0], .time = where[3]},
          .place = {.x = where[0], .y = where[1], .z = where[2]},
          .masses = masses};
}

void warn_of_field(const MassPoints& points, const FieldErrors& errors, double tolerance) {
  const auto [peak, place, masses] = errors.worst(tolerance);
  if (masses > 0) {
    std::ostringstream off;
    if (std::isfinite(peak.value)) {
      off << "by " << peak.value << " m";
    } else {
      off << "who has left the field,";
    }
    petsc::warn(
        points.comm(),
        "planes of a height field were off by more than %.3g m (-support_field_tolerance) under %lld masses that "
        "touched it: most under the one from (%g, %g, %g) m, %s at t = %g s; each keeps the plane of its start, "
        "do not trust what follows",
        tolerance, static_cast<long long>(masses), place.x, place.y, place.z, off.str().c_str(), peak.time);
  }
}

}  // namespace udar::app
