#include "udar/modal/phase_motion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "udar/modal/oscillator.hpp"

namespace udar {
namespace {

// A row this small beside what it is added up from is zero: rounding of some tens of terms.
constexpr double kZero = 64.0 * std::numeric_limits<double>::epsilon();

/// z and z' of one coordinate of frequency w.
PhaseMotion::Value oscillate(double time, double w, double place, double speed, double load, double load_rate) {
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
  PhaseMotion::Value value{.place = place - versed * place + s * speed + f2 * load,
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

PhaseMotion::PhaseMotion(const PhaseBasis& basis, const ReducedModel& model, const Drive& drive,
                         const ModalState& start)
    : basis_{&basis}, model_{&model}, begin_{start.time}, retreat_{drive.retreat} {
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
  for (std::array<double, 4>& powers : retreat_) {
    power_series::shift(powers.data(), powers.size(), begin_ - drive.time);
    powers[0] = 0.0;  // in the offset
  }
  basis.reduce(start.amplitude, place_);
  basis.reduce(start.velocity, speed_);
  basis.load(load, offset, load_);
  basis.load(rate, offset_rate, load_rate_);
  basis.offsets(offset, constant_);
  basis.offsets(offset_rate, slope_of_constant_);
  set_fading(start);
}

/// What still gives way after a touch.
void PhaseMotion::set_fading(const ModalState& start) {
  const bool in_flight = std::ranges::none_of(touches(), [](std::uint8_t one) { return one != 0; });
  const std::size_t points = start.force.size();
  if (!in_flight || (model_->rest_lag == 0.0 && model_->support_lag.empty())) {
    return;
  }
  fading_.rest.resize(points);
  fading_.give.resize(points);
  fading_.bend.resize(points);
  for (std::size_t i = 0; i < points; ++i) {
    for (std::size_t j = 0; j < points && model_->rest_lag > 0.0; ++j) {
      fading_.rest[i] += model_->compliance[i * points + j] * start.rest_force[j];
    }
    fading_.give[i] = !model_->support_lag.empty() && model_->support_lag[i] > 0.0 ? start.give[i] : 0.0;
  }
}

double PhaseMotion::ratio_of(std::size_t mode) const { return model_->ratio.empty() ? 0.0 : model_->ratio[mode]; }

PhaseMotion::Value PhaseMotion::value_of(std::size_t mode, double elapsed) const {
  const double w = basis_->frequency()[mode];
  const double ratio = ratio_of(mode);
  if (ratio == 0.0) {
    return oscillate(elapsed, w, place_[mode], speed_[mode], load_[mode], load_rate_[mode]);
  }
  const Oscillator at = Oscillator::after(elapsed, w, ratio);
  return {.place = at.place(place_[mode], speed_[mode], load_[mode], load_rate_[mode]),
          .speed = at.speed(w * w, place_[mode], speed_[mode], load_[mode], load_rate_[mode])};
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
      const double ratio = ratio_of(m);
      const double drift = load_rate_[m] / (w * w);
      const double rest = load_[m] / (w * w) - 2.0 * ratio / w * drift;
      const double swing = std::hypot(place_[m] - rest, (speed_[m] - drift) / w);
      bend = (1.0 + 2.0 * ratio) * w * w * swing;
      reach = swing + std::abs(rest) + length * std::abs(drift);
    }
    for (std::size_t i = 0; i < value_.size(); ++i) {
      const double share = std::abs(basis_->row(i)[m]);
      curvature_[i] += share * bend;
      swing_[i] += share * reach;
    }
  }
  for (std::size_t i = 0; i < retreat_.size(); ++i) {
    const auto& powers = retreat_[i];
    curvature_[i] += std::max(std::abs(2.0 * powers[2]), std::abs(2.0 * powers[2] + 6.0 * powers[3] * length));
  }
}

void PhaseMotion::evaluate(double elapsed) {
  const auto frequency = basis_->frequency();
  for (std::size_t m = 0; m < frequency.size(); ++m) {
    const Value value = value_of(m, elapsed);
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
  for (std::size_t i = 0; i < retreat_.size(); ++i) {
    const double moved = power_series::value(retreat_[i].data(), retreat_[i].size(), elapsed);
    value_[i] += moved;
    size_[i] += std::abs(moved);
    slope_[i] += power_series::slope(retreat_[i].data(), retreat_[i].size(), elapsed);
  }
  add_fading(elapsed);
  ++evaluations_;
}

void PhaseMotion::add_fading(double elapsed) {
  for (std::size_t i = 0; i < fading_.rest.size(); ++i) {
    fading_.bend[i] = 0.0;
    const auto add = [&](double from, double lag) {
      const double now = from != 0.0 ? from * std::exp(-elapsed / lag) : 0.0;
      if (now != 0.0) {
        value_[i] += now;
        size_[i] += std::abs(now);
        slope_[i] -= now / lag;
        fading_.bend[i] += std::abs(now) / (lag * lag);
      }
    };
    add(fading_.rest[i], model_->rest_lag);
    add(fading_.give[i], fading_.give[i] != 0.0 ? model_->support_lag[i] : 0.0);
  }
}

/// To the zero of the parabola under a row.
double PhaseMotion::safe_step(std::size_t point) const {
  const double value = std::max(value_[point], 0.0);
  const double slope = slope_[point];
  const double bend = curvature_[point] + (fading_.bend.empty() ? 0.0 : fading_.bend[point]);
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

void PhaseMotion::state_at(double time, ModalState& state) const {
  const auto frequency = basis_->frequency();
  const double elapsed = time - begin_;
  std::vector<double> place(frequency.size());
  std::vector<double> speed(frequency.size());
  for (std::size_t m = 0; m < frequency.size(); ++m) {
    const Value value = value_of(m, elapsed);
    place[m] = value.place;
    speed[m] = value.speed;
  }
  basis_->expand(place, state.amplitude);
  basis_->expand(speed, state.velocity);
  state.time = time;
  state.touches = basis_->touches();
  for (std::size_t i = 0; i < model_->points(); ++i) {
    double force = 0.0;
    if (state.touches[i] != 0) {
      force = constant_[i] + elapsed * slope_of_constant_[i];
      for (std::size_t m = 0; m < place.size(); ++m) {
        force += basis_->row(i)[m] * place[m];
      }
    }
    state.force[i] = force;
    state.rest_force[i] = force;
    state.give[i] = model_->give[i] * force;
  }
}

void PhaseMotion::integrate(double from, double until, std::span<double> amplitude, std::span<double> impulse) const {
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
  basis_->expand(passed, amplitude);
  for (std::size_t i = 0; i < impulse.size(); ++i) {
    impulse[i] = 0.0;
    if (basis_->touches()[i] == 0) {
      continue;
    }
    double sum = (last - first) * (constant_[i] + 0.5 * (first + last) * slope_of_constant_[i]);
    for (std::size_t m = 0; m < passed.size(); ++m) {
      sum += basis_->row(i)[m] * passed[m];
    }
    impulse[i] = sum;
  }
}

}  // namespace udar
