#include "udar/modal/phase_motion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace udar {
namespace {

// A row this small beside what it is added up from is zero: rounding of some tens of terms.
constexpr double kZero = 64.0 * std::numeric_limits<double>::epsilon();

struct Value {
  double place;
  double speed;
};

/// z and z' of one coordinate of frequency w.
Value oscillate(double time, double w, double place, double speed, double load, double load_rate) {
  if (w == 0.0) {
    const double half = 0.5 * time;
    return {.place = place + time * (speed + half * (load + time / 3.0 * load_rate)),
            .speed = speed + time * (load + half * load_rate)};
  }
  const double sine = std::sin(0.5 * w * time);
  const double cosine = std::cos(0.5 * w * time);
  const double versed = 2.0 * sine * sine;
  const double s = 2.0 * sine * cosine / w;
  const double f2 = versed / (w * w);
  Value value{.place = place - versed * place + s * speed + f2 * load,
              .speed = s * (load - w * w * place) + (1.0 - versed) * speed};
  if (load_rate != 0.0) {
    value.place += (time - s) / (w * w) * load_rate;
    value.speed += f2 * load_rate;
  }
  return value;
}

/// Integral of z from the start on.
double integral(double time, double w, double place, double speed, double load, double load_rate) {
  if (w == 0.0) {
    return time * (place + 0.5 * time * (speed + time / 3.0 * (load + 0.25 * time * load_rate)));
  }
  const double later = oscillate(time, w, place, speed, load, load_rate).speed;
  return (time * (load + 0.5 * time * load_rate) - (later - speed)) / (w * w);
}

}  // namespace

PhaseMotion::PhaseMotion(const PhaseBasis& basis, const Drive& drive, const ModalState& start)
    : basis_{&basis}, begin_{start.time} {
  const std::size_t modes = start.amplitude.size();
  const std::size_t points = start.force.size();
  for (std::vector<double>* of_modes : {&place_, &speed_, &load_, &load_rate_, &now_, &speed_now_, &reach_}) {
    of_modes->resize(modes);
  }
  for (std::vector<double>* of_points :
       {&constant_, &slope_of_constant_, &size_, &swing_, &curvature_, &value_, &slope_}) {
    of_points->resize(points);
  }
  std::vector<double> load(modes);
  std::vector<double> rate(modes);
  std::vector<double> offset(points);
  std::vector<double> offset_rate(points);
  for (std::size_t m = 0; m < modes; ++m) {
    load[m] = drive.load_at(m, begin_);
    rate[m] = drive.load_slope(m);
  }
  for (std::size_t i = 0; i < points; ++i) {
    offset[i] = drive.offset_at(i, begin_);
    offset_rate[i] = drive.offset_slope(i);
  }
  basis.reduce(start.amplitude, place_);
  basis.reduce(start.velocity, speed_);
  basis.load(load, offset, load_);
  basis.load(rate, offset_rate, load_rate_);
  basis.offsets(offset, constant_);
  basis.offsets(offset_rate, slope_of_constant_);
}

/// Of every row over the whole phase.
void PhaseMotion::bound_curvature(double length) {
  const auto frequency = basis_->frequency();
  std::ranges::fill(curvature_, 0.0);
  std::ranges::fill(swing_, 0.0);
  for (std::size_t m = 0; m < frequency.size(); ++m) {
    const double w = frequency[m];
    double reach = 0.0;
    double bend = std::max(std::abs(load_[m]), std::abs(load_[m] + length * load_rate_[m]));
    if (w > 0.0) {
      const double rest = load_[m] / (w * w);
      const double drift = load_rate_[m] / (w * w);
      const double swing = std::hypot(place_[m] - rest, (speed_[m] - drift) / w);
      bend = w * w * swing;
      reach = swing + std::abs(rest) + length * std::abs(drift);
    }
    for (std::size_t i = 0; i < value_.size(); ++i) {
      const double share = std::abs(basis_->row(i)[m]);
      curvature_[i] += share * bend;
      swing_[i] += share * reach;
    }
  }
}

void PhaseMotion::evaluate(double elapsed) {
  const auto frequency = basis_->frequency();
  for (std::size_t m = 0; m < frequency.size(); ++m) {
    const Value value = oscillate(elapsed, frequency[m], place_[m], speed_[m], load_[m], load_rate_[m]);
    now_[m] = value.place;
    speed_now_[m] = value.speed;
    reach_[m] = frequency[m] > 0.0
                    ? 0.0
                    : std::abs(place_[m]) + elapsed * (std::abs(speed_[m]) + 0.5 * elapsed * std::abs(load_[m]));
  }
  for (std::size_t i = 0; i < value_.size(); ++i) {
    const double* row = basis_->row(i).data();
    double value = constant_[i] + elapsed * slope_of_constant_[i];
    double slope = slope_of_constant_[i];
    double size = std::abs(value) + swing_[i];
    for (std::size_t m = 0; m < now_.size(); ++m) {
      value += row[m] * now_[m];
      size += std::abs(row[m]) * reach_[m];
      slope += row[m] * speed_now_[m];
    }
    value_[i] = value;
    slope_[i] = slope;
    size_[i] = size;
  }
  ++evaluations_;
}

/// To the zero of the parabola under a row.
double PhaseMotion::safe_step(std::size_t point) const {
  const double value = std::max(value_[point], 0.0);
  const double slope = slope_[point];
  const double bend = curvature_[point];
  const double root = std::sqrt(slope * slope + 2.0 * bend * value);
  if (slope < 0.0) {
    return 2.0 * value / (root - slope);
  }
  return bend > 0.0 ? (slope + root) / bend : std::numeric_limits<double>::infinity();
}

double PhaseMotion::last(double until) {
  const double length = until - begin_;
  bound_curvature(length);
  const auto frequency = basis_->frequency();
  const double fastest = frequency.empty() ? 0.0 : std::ranges::max(frequency);
  // A step below this would find nothing new; a row that only grazes zero must not hold the search.
  const double least = std::max(1e-9 / std::max(fastest, 1.0 / length), 2.0 * kZero * begin_);
  double elapsed = 0.0;
  evaluate(elapsed);
  for (;;) {
    double step = length - elapsed;
    for (std::size_t i = 0; i < value_.size(); ++i) {
      const bool at_start = elapsed == 0.0 && is_zero(i);
      if (!at_start && value_[i] <= kZero * size_[i] && slope_[i] < 0.0) {
        return begin_ + elapsed;
      }
      if (at_start) {
        // It has just changed sides: its slope is not negative but for rounding.
        value_[i] = 0.0;
        slope_[i] = std::max(slope_[i], 0.0);
        step = std::min(step, std::max(safe_step(i), least));
      } else {
        step = std::min(step, slope_[i] < 0.0 ? safe_step(i) : std::max(safe_step(i), least));
      }
    }
    if (step >= length - elapsed) {
      evaluate(length);
      return until;
    }
    const double next = elapsed + step;
    if (next == elapsed) {
      return begin_ + elapsed;  // as near as times can tell
    }
    elapsed = next;
    evaluate(elapsed);
  }
}

void PhaseMotion::state_at(const ReducedModel& model, double time, ModalState& state) const {
  const auto frequency = basis_->frequency();
  const double elapsed = time - begin_;
  std::vector<double> place(frequency.size());
  std::vector<double> speed(frequency.size());
  for (std::size_t m = 0; m < frequency.size(); ++m) {
    const Value value = oscillate(elapsed, frequency[m], place_[m], speed_[m], load_[m], load_rate_[m]);
    place[m] = value.place;
    speed[m] = value.speed;
  }
  basis_->expand(place, state.amplitude);
  basis_->expand(speed, state.velocity);
  state.time = time;
  state.touches = basis_->touches();
  for (std::size_t i = 0; i < model.points(); ++i) {
    double force = 0.0;
    if (state.touches[i] != 0) {
      force = constant_[i] + elapsed * slope_of_constant_[i];
      for (std::size_t m = 0; m < place.size(); ++m) {
        force += basis_->row(i)[m] * place[m];
      }
    }
    state.force[i] = force;
    state.rest_force[i] = force;
    state.give[i] = model.give[i] * force;
  }
}

void PhaseMotion::add_impulses(double from, double until, std::span<double> sums) const {
  const auto frequency = basis_->frequency();
  std::vector<double> passed(frequency.size());
  const auto fill = [&](double elapsed, double sign) {
    for (std::size_t m = 0; m < passed.size(); ++m) {
      passed[m] += sign * integral(elapsed, frequency[m], place_[m], speed_[m], load_[m], load_rate_[m]);
    }
  };
  const double first = from - begin_;
  const double last = until - begin_;
  fill(first, -1.0);
  fill(last, 1.0);
  for (std::size_t i = 0; i < sums.size(); ++i) {
    if (basis_->touches()[i] == 0) {
      continue;
    }
    double sum = (last - first) * (constant_[i] + 0.5 * (first + last) * slope_of_constant_[i]);
    for (std::size_t m = 0; m < passed.size(); ++m) {
      sum += basis_->row(i)[m] * passed[m];
    }
    sums[i] += sum;
  }
}

}  // namespace udar
