#include "udar/modal/exact_phases.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>

#include "udar/petsc/error.hpp"

namespace udar {

ExactPhases::ExactPhases(const ReducedModel& model)
    : model_{&model},
      closed_{model.closed_compliance(), model.points()},
      state_{model.modes(), model.points()},
      entered_{model.modes(), model.points()} {
  if (!model.conservative() || model.points() > kMostPoints) {
    throw SolveError{"modal integrator: exact phases need an undamped motion and at most " +
                     std::to_string(kMostPoints) + " contact points"};
  }
}

void ExactPhases::start(const ModalState& state, const Drive& drive) {
  drive_ = drive;
  state_ = state;
  last_.reset();
  const std::size_t points = model_->points();
  std::vector<double> gap(points);
  double size = 0.0;
  for (std::size_t i = 0; i < points; ++i) {
    const auto row = model_->row_of(i);
    gap[i] = drive_.offset_at(i, state.time);
    size = std::max(size, std::abs(gap[i]));
    for (std::size_t m = 0; m < row.size(); ++m) {
      gap[i] += row[m] * state.amplitude[m];
      size = std::max(size, std::abs(row[m] * state.amplitude[m]));
    }
  }
  closed_.solve(gap, state_.force);
  std::vector<double> closed(points);
  closed_.gaps(gap, state_.force, closed);
  // What touches without a force, but for rounding, is decided by how it goes on.
  constexpr double kRounding = 256.0 * std::numeric_limits<double>::epsilon();
  std::vector<std::size_t> due;
  for (std::size_t i = 0; i < points; ++i) {
    const double stiff = model_->compliance[i * points + i] + model_->give[i];
    const bool pressed = state_.force[i] * stiff > kRounding * size;
    if (!pressed && closed[i] <= kRounding * size) {
      due.push_back(i);
    }
    state_.touches[i] = pressed ? 1 : 0;
  }
  if (!due.empty()) {
    change(due);
  }
  for (std::size_t i = 0; i < points; ++i) {
    if (state_.touches[i] != 0) {
      state_.rest_force[i] = state_.force[i];
      state_.give[i] = model_->give[i] * state_.force[i];
    }
  }
  enter_phase();
}

void ExactPhases::resume(const ModalMemory& memory, const Drive& drive, double time) {
  drive_ = drive;
  state_ = memory.entered;
  enter_phase();
  motion_->state_at(time, state_);
  last_.reset();
}

double ExactPhases::advance(double until) {
  before_ = memory();
  last_begin_ = state_.time;
  const double reached = motion_->last(until);
  last_ = motion_;
  last_end_ = reached;
  motion_->state_at(reached, state_);
  if (reached < until) {
    std::vector<std::size_t> due;
    for (std::size_t i = 0; i < model_->points(); ++i) {
      if (motion_->is_zero(i)) {
        due.push_back(i);
      }
    }
    change(due);
    ++changes_;
    enter_phase();
  }
  return reached;
}

ModalState ExactPhases::at(double time) const {
  ModalState state = state_;
  (last_ && time <= last_end_ ? *last_ : *motion_).state_at(time, state);
  return state;
}

std::vector<ModalContact> ExactPhases::contacts() const {
  std::vector<ModalContact> all;
  for (std::size_t i = 0; last_ && i < model_->points(); ++i) {
    if (last_->touches()[i] != 0) {
      all.push_back({.point = i, .from = last_begin_, .until = last_end_});
    }
  }
  return all;
}

ModalFlow ExactPhases::flow(double until) const {
  ModalFlow flow{model_->modes(), model_->points()};
  if (last_) {
    last_->integrate(last_begin_, std::min(until, last_end_), flow.amplitude, flow.impulse);
    flow.rest_force = flow.impulse;
  }
  return flow;
}

void ExactPhases::enter_phase() {
  if (motion_) {
    evaluations_ += motion_->evaluations();
  }
  auto known = std::ranges::find(bases_, state_.touches, &PhaseBasis::touches);
  if (known == bases_.end()) {
    bases_.emplace_back(*model_, closed_, state_.touches);
    known = std::prev(bases_.end());
  }
  entered_ = state_;
  motion_.emplace(*known, *model_, drive_, state_);
}

std::vector<double> ExactPhases::gap_rates() const {
  std::vector<double> rates(model_->points());
  for (std::size_t i = 0; i < rates.size(); ++i) {
    const auto row = model_->row_of(i);
    rates[i] = std::inner_product(row.begin(), row.end(), state_.velocity.begin(), drive_.offset_slope(i));
  }
  return rates;
}

std::vector<double> ExactPhases::gap_accelerations() const {
  std::vector<double> acceleration(model_->modes());
  for (std::size_t m = 0; m < acceleration.size(); ++m) {
    const double w = model_->frequency[m];
    acceleration[m] = drive_.load_at(m, state_.time) - w * w * state_.amplitude[m];
    for (std::size_t i = 0; i < model_->points(); ++i) {
      acceleration[m] += model_->row_of(i)[m] * state_.force[i];
    }
  }
  std::vector<double> rates(model_->points());
  for (std::size_t i = 0; i < rates.size(); ++i) {
    const auto row = model_->row_of(i);
    rates[i] = std::inner_product(row.begin(), row.end(), acceleration.begin(), 0.0);
  }
  return rates;
}

/// Finds who of the points whose force or gap is zero touches from now on: the complementarity problem of the rates.
void ExactPhases::change(const std::vector<std::size_t>& due) {
  std::vector<double> rates = gap_rates();
  // Where nothing moves on, accelerations decide.
  constexpr double kStill = 1e-12;
  const double speed =
      std::sqrt(std::inner_product(state_.velocity.begin(), state_.velocity.end(), state_.velocity.begin(), 0.0));
  const bool still = std::ranges::all_of(due, [&](std::size_t i) {
    const auto row = model_->row_of(i);
    const double size = std::sqrt(std::inner_product(row.begin(), row.end(), row.begin(), 0.0));
    return std::abs(rates[i]) <= kStill * size * speed;
  });
  if (still) {
    rates = gap_accelerations();
  }
  const std::vector<std::uint8_t> touches = closed_.follow(state_.touches, due, rates);
  for (std::size_t i = 0; i < touches.size(); ++i) {
    state_.touches[i] = touches[i];
    if (touches[i] == 0) {
      state_.force[i] = state_.rest_force[i] = state_.give[i] = 0.0;
    }
  }
}

}  // namespace udar
