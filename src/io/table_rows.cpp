#include "io/table_rows.hpp"

#include <limits>
#include <numeric>
#include <string_view>
#include <utility>

namespace udar::io {

GaugeRows::GaugeRows(const RunLayout& layout, std::vector<std::vector<PointShare>> places)
    : comm_{layout.comm()}, points_{layout.points}, places_{std::move(places)}, base_{layout.base} {
  MPI_Comm_rank(comm_, &rank_);
}

void GaugeRows::read(std::size_t field, std::string name) {
  field_.push_back(field);
  name_.push_back(std::move(name));
}

GaugeRows GaugeRows::of_gauges(const RunLayout& layout) {
  GaugeRows rows{layout, layout.gauges.height};
  for (std::size_t i = 0; i < layout.fields.size(); ++i) {
    if (!layout.fields[i].gauge.empty()) {
      rows.read(i, std::string{layout.fields[i].gauge});
    }
  }
  return rows;
}

GaugeRows GaugeRows::of_strikers(const RunLayout& layout) {
  std::vector<std::vector<PointShare>> heights;
  for (const Strike& strike : layout.points->strikes()) {
    if (!strike.of_nodes()) {
      heights.push_back(layout.points->height_of(strike.gap));
    }
  }
  GaugeRows rows{layout, std::move(heights)};
  for (std::size_t i = 0; i < layout.fields.size(); ++i) {
    if (layout.fields[i].name == "mass_position" || layout.fields[i].name == "mass_velocity") {
      rows.read(i, layout.fields[i].position ? "position" : "velocity");
    }
  }
  return rows;
}

void GaugeRows::add(const Snapshot& state) {
  times_.push_back(state.time);
  const std::array<double, 2> base = base_ && rank_ == 0 ? base_(state.time) : std::array<double, 2>{};
  for (const std::vector<PointShare>& place : places_) {
    const std::size_t first = values_.size();
    for (const std::size_t field : field_) {
      double value = 0.0;
      for (const auto& [point, share] : place) {
        if (points_->owns(point)) {
          value += share * state.fields[field].numbers()[static_cast<std::size_t>(point - points_->begin())];
        }
      }
      values_.push_back(value);
    }
    for (std::size_t i = 0; base_ && i < field_.size(); ++i) {
      values_.push_back(values_[first + i] + (state.fields[field_[i]].position ? base[0] : base[1]));
    }
  }
}

void GaugeRows::clear() {
  times_.clear();
  values_.clear();
}

std::string GaugeRows::header() const {
  std::vector<std::string> names = name_;
  for (std::size_t i = 0; base_ && i < name_.size(); ++i) {
    names.push_back("absolute_" + name_[i]);
  }
  return gauge_header(places_.size(), std::vector<std::string_view>{names.begin(), names.end()});
}

/// All but one rank add zeros.
std::string GaugeRows::text() const {
  std::vector<double> sum(rank_ == 0 ? values_.size() : 0);
  MPI_Reduce(values_.data(), sum.data(), static_cast<int>(values_.size()), MPI_DOUBLE, MPI_SUM, 0, comm_);
  return rank_ == 0 ? gauge_rows(times_, sum) : "";
}

std::vector<double> GaugeRows::numbers() const {
  std::vector<double> sum(values_.size());
  MPI_Allreduce(values_.data(), sum.data(), static_cast<int>(values_.size()), MPI_DOUBLE, MPI_SUM, comm_);
  std::vector<double> table;
  const auto columns = static_cast<std::ptrdiff_t>(times_.empty() ? 0 : values_.size() / times_.size());
  for (auto row = sum.cbegin(); const double time : times_) {
    table.push_back(time);
    table.insert(table.end(), row, row + columns);
    row += columns;
  }
  return table;
}

ContactRows::ContactRows(const RunLayout& layout, SupportForces& forces) : comm_{layout.comm()}, forces_{&forces} {
  MPI_Comm_rank(comm_, &rank_);
  for (const RunLayout::Support& support : layout.supports) {
    lifts_.push_back(support.lift);
    moves_ = moves_ || support.lift;
  }
}

void ContactRows::add(const Snapshot& state) {
  const std::vector<double> force = forces_->add(state.time, state.support_impulse);
  force_.insert(force_.end(), force.begin(), force.end());
  impulse_.insert(impulse_.end(), state.support_impulse.begin(), state.support_impulse.end());
  for (std::size_t k = 0; moves_ && k < lifts_.size(); ++k) {
    lift_.push_back(lifts_[k] ? lifts_[k](state.time) : 0.0);
  }
  rows_.push_back({.time = state.time,
                   .force = std::reduce(force.begin(), force.end()),
                   .impulse = std::reduce(state.support_impulse.begin(), state.support_impulse.end())});
  masses_.push_back(static_cast<double>(state.zone.masses));
  edges_.insert(edges_.end(), {-state.zone.x_min, state.zone.x_max});
}

void ContactRows::clear() {
  rows_.clear();
  force_.clear();
  impulse_.clear();
  lift_.clear();
  masses_.clear();
  edges_.clear();
}

std::vector<ContactRow> ContactRows::rows() const {
  constexpr double kNowhere = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> masses(masses_.size());
  std::vector<double> edges(edges_.size());
  MPI_Reduce(masses_.data(), masses.data(), static_cast<int>(masses.size()), MPI_DOUBLE, MPI_SUM, 0, comm_);
  MPI_Reduce(edges_.data(), edges.data(), static_cast<int>(edges.size()), MPI_DOUBLE, MPI_MAX, 0, comm_);
  std::vector<ContactRow> rows = rows_;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rows[i].masses = masses[i];
    rows[i].x_min = masses[i] > 0.0 ? -edges[2 * i] : kNowhere;
    rows[i].x_max = masses[i] > 0.0 ? edges[2 * i + 1] : kNowhere;
  }
  return rows;
}

}  // namespace udar::io
