#include "udar/io/impact_merger.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

namespace udar::io {
namespace {

constexpr const char* kMergedSlots = "merged impacts of a node";
constexpr std::array kMergedColumns{"time",    "last_time", "x",       "support",
                                    "impacts", "speed_max", "impulse", "energy_loss"};

std::string merged_field(PetscInt slot, const char* column) {
  return "merged_impact_" + std::to_string(slot) + "_" + column;
}

std::array<double, kMergedColumns.size()> numbers_of(const MergedImpact& entry) {
  return {entry.time,
          entry.last_time,
          entry.x,
          static_cast<double>(entry.support),
          static_cast<double>(entry.impacts),
          entry.speed_max,
          entry.impulse,
          entry.energy_loss};
}

}  // namespace

ImpactMerger::ImpactMerger(PetscInt first, std::size_t points, double window)
    : first_{first}, window_{window}, newest_(points, kNone) {}

void ImpactMerger::push(const MergedImpact& entry) {
  std::int64_t& newest = newest_[point_of(entry)];
  entries_.push_back({entry, newest});
  newest = static_cast<std::int64_t>(entries_.size()) - 1;
}

void ImpactMerger::add(std::span<const ImpactRecord> impacts) {
  for (const ImpactRecord& impact : impacts) {
    latest_ = std::max(latest_, impact.time);
    std::int64_t at = newest_[static_cast<std::size_t>(impact.node - first_)];
    while (at != kNone && entries_[static_cast<std::size_t>(at)].support != impact.support) {
      at = entries_[static_cast<std::size_t>(at)].before;
    }
    if (at == kNone || impact.time - entries_[static_cast<std::size_t>(at)].time >= window_) {
      push({.time = impact.time, .node = impact.node, .x = impact.x, .support = impact.support});
      at = static_cast<std::int64_t>(entries_.size()) - 1;
    }
    Entry& entry = entries_[static_cast<std::size_t>(at)];
    entry.last_time = impact.time;
    ++entry.impacts;
    entry.speed_max = std::max(entry.speed_max, std::abs(impact.velocity_before));
    entry.impulse += impact.impulse;
    entry.energy_loss += impact.energy_loss;
  }
}

std::vector<MergedImpact> ImpactMerger::take(double time) {
  std::vector<MergedImpact> taken;
  for (const Entry& entry : entries_) {
    newest_[point_of(entry)] = kNone;
  }
  const auto ready = [&](const Entry& entry) { return time - entry.time >= window_; };
  taken.reserve(static_cast<std::size_t>(std::ranges::count_if(entries_, ready)));
  for (const Entry& entry : std::exchange(entries_, {})) {
    if (ready(entry)) {
      taken.push_back(entry);
    } else {
      push(entry);
    }
  }
  std::ranges::stable_sort(taken, [](const MergedImpact& a, const MergedImpact& b) {
    return a.time < b.time || (a.time == b.time && a.node < b.node);
  });
  return taken;
}

void ImpactMerger::save(MPI_Comm comm, MotionState& state) const {
  std::vector<PetscInt> slot(entries_.size(), 0);
  PetscInt slots = 0;
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    slot[i] = entries_[i].before == kNone ? 0 : slot[static_cast<std::size_t>(entries_[i].before)] + 1;
    slots = std::max(slots, slot[i] + 1);
  }
  MPI_Allreduce(MPI_IN_PLACE, &slots, 1, MPIU_INT, MPI_MAX, comm);
  state.scalars[kMergedSlots] = static_cast<double>(slots);
  for (PetscInt k = 0; k < slots; ++k) {
    for (const char* column : kMergedColumns) {
      state.fields[merged_field(k, column)].assign(newest_.size(), 0.0);
    }
  }
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    const auto values = numbers_of(entries_[i]);
    for (std::size_t k = 0; k < values.size(); ++k) {
      state.fields[merged_field(slot[i], kMergedColumns.at(k))][point_of(entries_[i])] = values.at(k);
    }
  }
}

void ImpactMerger::restore(const MotionState& state) {
  const auto slots = state.scalars.find(kMergedSlots);
  const PetscInt count = slots != state.scalars.end() ? static_cast<PetscInt>(slots->second) : 0;
  for (PetscInt slot = 0; slot < count; ++slot) {
    std::array<const std::vector<double>*, kMergedColumns.size()> columns{};
    for (std::size_t k = 0; k < columns.size(); ++k) {
      columns.at(k) = &state.field(merged_field(slot, kMergedColumns.at(k)), newest_.size());
    }
    const auto value = [&](std::size_t k, std::size_t point) { return (*columns.at(k))[point]; };
    for (std::size_t point = 0; point < newest_.size(); ++point) {
      if (value(4, point) > 0.0) {
        push({.time = value(0, point),
              .last_time = value(1, point),
              .node = first_ + static_cast<PetscInt>(point),
              .x = value(2, point),
              .support = static_cast<PetscInt>(value(3, point)),
              .impacts = static_cast<PetscInt>(value(4, point)),
              .speed_max = value(5, point),
              .impulse = value(6, point),
              .energy_loss = value(7, point)});
        latest_ = std::max(latest_, value(1, point));
      }
    }
  }
}

}  // namespace udar::io
