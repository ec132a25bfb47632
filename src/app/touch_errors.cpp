#include "app/touch_errors.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace udar::app {

TouchErrors::TouchErrors(const MassPoints& points, const Case& input, std::string name,
                         const std::function<bool(const Support&)>& looked_at)
    : points_{&points},
      name_{std::move(name)},
      interval_{input.output.interval},
      contacts_{find_contacts(points, input.supports)},
      hit_(points.points(), 0),
      error_(points.points(), 0.0),
      time_(points.points(), 0.0) {
  for (std::size_t number = 0; number < contacts_.sets.size(); ++number) {
    const ContactSet& set = contacts_.sets[number];
    const bool matters = looked_at(contacts_.supports[static_cast<std::size_t>(set.support)]);
    for (std::size_t point = set.first; point < set.last && matters; ++point) {
      faced_.push_back({.point = point, .set = number});
    }
  }
}

Place TouchErrors::way_of(std::size_t point, std::span<const double> position) const {
  Place way{};
  const auto add = [&](std::size_t own) {
    const Place axis = points_->axis(own);
    const double value = position[own] - points_->reference(own);
    way = {.x = way.x + value * axis.x, .y = way.y + value * axis.y, .z = way.z + value * axis.z};
  };
  add(point);
  if (const auto others = points_->beside(point)) {
    add((*others)[0]);
    add((*others)[1]);
  }
  return way;
}

void TouchErrors::snapshot(const Snapshot& state) {
  const std::span<const double> position = state.values("mass_position");
  const std::span<const std::uint8_t> resting = find_field(state.fields, kRestingField.name).flags();
  for (const Faced& faced : faced_) {
    const std::size_t point = faced.point;
    const ContactSet& set = contacts_.sets[faced.set];
    const double error = error_of(point, contacts_.supports[static_cast<std::size_t>(set.support)], position);
    const double gap = set.side * (position[point] - set.height(point) - set.lift(state.time).height);
    const bool touches = resting[point] != 0 || hit_[point] != 0 || gap <= reach(error);
    if (touches && error > error_[point]) {
      error_[point] = error;
      time_[point] = state.time;
    }
  }
  std::ranges::fill(hit_, 0);
}

void TouchErrors::events(const StepRecords<ImpactRecord>& impacts, const StepRecords<RestRecord>& /*rests*/,
                         const EventCounts& /*all*/) {
  for (const ImpactRecord& impact : impacts) {
    hit_[static_cast<std::size_t>(impact.node - points_->begin())] = 1;
  }
}

void TouchErrors::save(MotionState& state) const {
  state.fields[name_] = error_;
  state.fields[name_ + "_time"] = time_;
}

void TouchErrors::restore(const MotionState& state) {
  error_ = state.field(name_, error_.size());
  time_ = state.field(name_ + "_time", time_.size());
}

TouchErrors::Worst TouchErrors::worst(double tolerance) const {
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

}  // namespace udar::app
