#include "udar/modal/kernel_steps.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>
#include <utility>

#include "udar/modal/phase_motion.hpp"

namespace udar {
namespace {

// So many halvings of the longest step at most: what is wrong beside a touch lasts no longer than that.
constexpr int kFinest = 13;
// Steps in one go: what the integrator does after each of these, over all nodes, is spread over as many.
constexpr std::size_t kTogether = 64;

/// Integral of lag rho_i' rho_j' over a time, for forces that go evenly.
class LagLoss {
 public:
  LagLoss(double time, double lag, const Lag& kernel) : time_{time}, lag_{lag}, left_{kernel.left} {}

  struct Course {
    double slope;      // of the force that is followed [N/s]
    double transient;  // rho - r + slope lag at the start [N]
  };
  [[nodiscard]] Course course(double followed, double from, double until) const {
    const double slope = (until - from) / time_;
    return {.slope = slope, .transient = followed - from + slope * lag_};
  }
  [[nodiscard]] double of(const Course& a, const Course& b) const {
    const double gone = 1.0 - left_;
    return lag_ * (a.slope * b.slope * time_ - (a.slope * b.transient + a.transient * b.slope) * gone) +
           0.5 * a.transient * b.transient * gone * (1.0 + left_);
  }

 private:
  double time_;
  double lag_;
  double left_;
};

}  // namespace

Lag Lag::after(double time, double lag) {
  if (lag == 0.0) {
    return {};
  }
  const double x = time / lag;
  constexpr double kSeries = 0.5;
  Lag at{.left = std::exp(-x)};
  if (x < kSeries) {
    constexpr int kTerms = 18;  // 0.5^18 / 18! is nothing
    double term = 1.0;          // (-x)^n / (n + 1)!
    at.last = 0.0;
    for (int n = 1; n < kTerms; ++n) {
      term *= -x / (n + 1);
      at.last -= term;
    }
  } else {
    at.last = 1.0 + std::expm1(-x) / x;
  }
  at.first = -std::expm1(-x) - at.last;
  return at;
}

ModalKernels::ModalKernels(const ReducedModel& model, double duration)
    : time{duration}, rest{Lag::after(duration, model.rest_lag)} {
  for (std::size_t m = 0; m < model.modes(); ++m) {
    modes.push_back(Oscillator::after(duration, model.frequency[m], model.ratio.empty() ? 0.0 : model.ratio[m]));
  }
  for (const double lag : model.support_lag) {
    supports.push_back(Lag::after(duration, lag));
  }
}

KernelSteps::KernelSteps(const ReducedModel& model, double tolerance)
    : model_{&model},
      tolerance_{tolerance},
      longest_{1.0 / model.frequency_bound()},
      closed_{model.closed_compliance(), model.points()},
      free_{model, closed_, std::vector<std::uint8_t>(model.points())},
      state_{model.modes(), model.points()},
      passed_{model.modes(), model.points()} {
  const auto first = std::ranges::find_if(model.frequency, [](double w) { return w > 0.0; });
  constexpr double kTenths = 10.0;
  constexpr double kWithoutModes = 0.01;  // of the fastest
  share_ = first != model.frequency.end() ? kTenths * *first / (2.0 * std::numbers::pi) : kWithoutModes / longest_;
}

/// H = b diag(f3 / h) b' + last W + last / K, of step h.
KernelSteps::Stride KernelSteps::stride(double length) const {
  ModalKernels kernels{*model_, length};
  const std::size_t points = model_->points();
  std::vector<double> matrix(points * points);
  std::vector<double> weighted(model_->modes());
  for (std::size_t i = 0; i < points; ++i) {
    const auto row = model_->row_of(i);
    for (std::size_t m = 0; m < row.size(); ++m) {
      weighted[m] = row[m] * kernels.modes[m].f3 / length;
    }
    for (std::size_t j = 0; j <= i; ++j) {
      const auto other = model_->row_of(j);
      const double moved = std::inner_product(weighted.begin(), weighted.end(), other.begin(), 0.0);
      matrix[i * points + j] = moved + kernels.rest.last * model_->compliance[i * points + j];
      matrix[j * points + i] = matrix[i * points + j];
    }
    matrix[i * points + i] += model_->give[i] * (kernels.supports.empty() ? 1.0 : kernels.supports[i].last);
  }
  return {.kernels = std::move(kernels), .problem = Complementarity{std::move(matrix), points}};
}

KernelSteps::Stride& KernelSteps::stride_of(int level) {
  auto found = strides_.find(level);
  if (found == strides_.end()) {
    found = strides_.emplace(level, stride(std::ldexp(longest_, -level))).first;
  }
  return found->second;
}

void KernelSteps::start(const ModalState& state, const Drive& drive) {
  drive_ = drive;
  state_ = state;
  find_forces(true);
  largest_energy_ = std::max(largest_energy_, modal_energy(*model_, drive_, state_).swinging());
  taken_.clear();
}

/// From where the modes are. @param in_balance what lags in supports, too; else it stays as it is
void KernelSteps::find_forces(bool in_balance) {
  const std::size_t points = model_->points();
  const auto stays = [&](std::size_t i) {
    return !in_balance && !model_->support_lag.empty() && model_->support_lag[i] > 0.0;
  };
  std::ranges::fill(state_.rest_force, 0.0);
  std::vector<double> matrix = model_->closed_compliance();
  std::vector<double> gaps(points);
  bool any = false;
  for (std::size_t i = 0; i < points; ++i) {
    any = any || stays(i);
    matrix[i * points + i] -= stays(i) ? model_->give[i] : 0.0;
    state_.give[i] = stays(i) ? state_.give[i] : 0.0;
    gaps[i] = gap(state_, i);
  }
  if (any) {
    Complementarity{std::move(matrix), points}.solve(gaps, state_.force);
  } else {
    closed_.solve(gaps, state_.force);
  }
  state_.rest_force = state_.force;
  for (std::size_t i = 0; i < points; ++i) {
    state_.give[i] = stays(i) ? state_.give[i] : model_->give[i] * state_.force[i];
    state_.touches[i] = state_.force[i] > 0.0 || gaps[i] <= 0.0 ? 1 : 0;
  }
}

void KernelSteps::turn(const Drive& drive, bool jump) {
  drive_ = drive;
  // What lags stays as it is; elsewhere a jump moves the line, and its forces with it.
  if (jump && model_->rest_lag == 0.0) {
    find_forces(false);
  }
}

double KernelSteps::advance(double until) {
  before_ = memory();
  taken_.clear();
  passed_ = ModalFlow{model_->modes(), model_->points()};
  while (state_.time < until && taken_.size() < kTogether) {
    if (flies()) {
      fly(until);
    } else {
      step(until);
    }
  }
  return state_.time;
}

void KernelSteps::take_back() { resume(before_, drive_, before_.entered.time); }

ModalMemory KernelSteps::memory() const {
  return {.entered = state_, .level = static_cast<double>(level_), .largest_energy = largest_energy_};
}

void KernelSteps::resume(const ModalMemory& memory, const Drive& drive, double /*time*/) {
  drive_ = drive;
  state_ = memory.entered;
  level_ = static_cast<int>(memory.level);
  largest_energy_ = memory.largest_energy;
  taken_.clear();
}

bool KernelSteps::flies() const {
  return std::ranges::none_of(state_.touches, [](std::uint8_t touches) { return touches != 0; });
}

/// To the first touch.
void KernelSteps::fly(double until) {
  PhaseMotion motion{free_, *model_, drive_, state_};
  const double reached = motion.last(until);
  if (reached > state_.time) {
    const ModalKernels kernels{*model_, reached - state_.time};
    const std::vector<double> none(model_->points());
    const Push push{pushed(none), pushed(none)};
    ModalState end = moved(state_, kernels, none, push);
    end.time = reached;
    const ModalFlow flow = flow_of(state_, kernels, end, push);
    accept(std::move(end), flow, kernels.time);
  }
  if (reached < until) {
    std::size_t nearest = 0;
    for (std::size_t i = 0; i < model_->points(); ++i) {
      state_.touches[i] = motion.is_zero(i) ? 1 : 0;
      nearest = gap(state_, i) < gap(state_, nearest) ? i : nearest;
    }
    state_.touches[nearest] = 1;
  }
}

/// Where the rest lags, a face stops a point at once: the force jumps to what makes the rest follow.
void KernelSteps::land() {
  const double lag = model_->rest_lag;
  const auto gives = [&](std::size_t i) {
    return model_->give[i] > 0.0 && (model_->support_lag.empty() || model_->support_lag[i] == 0.0);
  };
  std::vector<std::size_t> stopped;
  bool landed = false;
  for (std::size_t i = 0; i < model_->points(); ++i) {
    if (lag > 0.0 && state_.touches[i] != 0 && !gives(i)) {
      stopped.push_back(i);
      landed = landed || state_.force[i] == 0.0;
    }
  }
  if (!landed) {
    return;
  }
  for (const std::size_t i : stopped) {
    state_.force[i] = 0.0;
  }
  const std::size_t points = model_->points();
  std::vector<double> matrix(stopped.size() * stopped.size());
  std::vector<double> rate(stopped.size());
  for (std::size_t a = 0; a < stopped.size(); ++a) {
    const std::size_t i = stopped[a];
    const auto row = model_->row_of(i);
    rate[a] = std::inner_product(row.begin(), row.end(), state_.velocity.begin(), drive_.offset_slope(i));
    if (!drive_.retreat.empty()) {
      rate[a] += power_series::slope(drive_.retreat[i].data(), 4, state_.time - drive_.time);
    }
    for (std::size_t j = 0; j < points; ++j) {
      rate[a] += model_->compliance[i * points + j] * (state_.force[j] - state_.rest_force[j]) / lag;
    }
    for (std::size_t b = 0; b < stopped.size(); ++b) {
      matrix[a * stopped.size() + b] = model_->compliance[i * points + stopped[b]] / lag;
    }
    if (model_->give[i] > 0.0) {
      matrix[a * stopped.size() + a] += model_->give[i] / model_->support_lag[i];
      rate[a] -= state_.give[i] / model_->support_lag[i];
    }
  }
  std::vector<double> force(stopped.size());
  Complementarity{std::move(matrix), stopped.size()}.solve(rate, force);
  for (std::size_t a = 0; a < stopped.size(); ++a) {
    state_.force[stopped[a]] = force[a];
  }
}

void KernelSteps::step(double until) {
  land();
  constexpr double kAtOnce = 0.02;  // of the tolerance, whatever the length of a step
  constexpr double kCoarser = 0.1;
  const double held = modal_energy(*model_, drive_, state_).held();
  Push push{pushed(state_.force), {}};
  for (;; ++level_) {
    const double left = until - state_.time;
    const bool last = std::ldexp(longest_, -level_) >= left;
    std::optional<Stride> rest;
    Stride& taken = last ? rest.emplace(stride(left)) : stride_of(level_);
    ModalState end = attempt(taken, push);
    end.time = last ? until : end.time;
    const ModalFlow flow = flow_of(state_, taken.kernels, end, push);
    const ModalEnergy energy = modal_energy(*model_, drive_, end);
    const double largest = std::max(largest_energy_, energy.swinging());
    const double allowed = tolerance_ * largest * (taken.kernels.time * share_ + kAtOnce);
    const double defect = std::abs(energy.held() - held + gap_work(end, flow, taken.kernels.time, push));
    if (!(defect > allowed) || level_ == kFinest) {
      largest_energy_ = largest;
      accept(std::move(end), flow, taken.kernels.time);
      level_ -= defect < kCoarser * allowed && level_ > 0 && !last ? 1 : 0;
      return;
    }
    ++rejected_;
  }
}

/// The end of a step: the forces there are those with which nothing overlaps.
ModalState KernelSteps::attempt(Stride& stride, Push& push) const {
  const ModalKernels& kernels = stride.kernels;
  const std::size_t points = model_->points();
  push.after.assign(model_->modes(), 0.0);
  ModalState end = moved(state_, kernels, std::vector<double>(points), push);
  std::vector<double> gaps(points);
  std::vector<std::size_t> active;
  for (std::size_t i = 0; i < points; ++i) {
    gaps[i] = gap(end, i);
    if (state_.force[i] > 0.0) {
      active.push_back(i);
    }
  }
  stride.problem.assume(std::move(active));
  stride.problem.solve(gaps, end.force);
  push.after = pushed(end.force);
  for (std::size_t m = 0; m < push.after.size(); ++m) {
    end.amplitude[m] += kernels.modes[m].f3 / kernels.time * push.after[m];
    end.velocity[m] += kernels.modes[m].f2 / kernels.time * push.after[m];
  }
  for (std::size_t i = 0; i < points; ++i) {
    end.rest_force[i] += kernels.rest.last * end.force[i];
    end.give[i] += model_->give[i] * (kernels.supports.empty() ? 1.0 : kernels.supports[i].last) * end.force[i];
    end.touches[i] = end.force[i] > 0.0 ? 1 : 0;
  }
  return end;
}

void KernelSteps::accept(ModalState end, const ModalFlow& flow, double length) {
  taken_.push_back({.start = state_, .end_force = end.force, .length = length, .before = passed_});
  passed_.add(flow);
  state_ = std::move(end);
  ++count_;
}

const KernelSteps::Taken& KernelSteps::step_at(double time) const {
  const auto after = std::ranges::upper_bound(taken_, time, {}, [](const Taken& taken) { return taken.start.time; });
  return after == taken_.begin() ? *after : *std::prev(after);
}

/// b' r of every mode.
std::vector<double> KernelSteps::pushed(std::span<const double> force) const {
  std::vector<double> sums(model_->modes());
  for (std::size_t i = 0; i < force.size(); ++i) {
    const auto row = model_->row_of(i);
    for (std::size_t m = 0; m < row.size() && force[i] != 0.0; ++m) {
      sums[m] += force[i] * row[m];
    }
  }
  return sums;
}

ModalState KernelSteps::moved(const ModalState& from, const ModalKernels& kernels, std::span<const double> end_force,
                              const Push& push) const {
  ModalState end = from;
  end.time = from.time + kernels.time;
  for (std::size_t m = 0; m < model_->modes(); ++m) {
    const double w = model_->frequency[m];
    const double load = drive_.load_at(m, from.time) + push.before[m];
    const double rate = drive_.load_slope(m) + (push.after[m] - push.before[m]) / kernels.time;
    const Oscillator& mode = kernels.modes[m];
    end.amplitude[m] = mode.place(from.amplitude[m], from.velocity[m], load, rate);
    end.velocity[m] = mode.speed(w * w, from.amplitude[m], from.velocity[m], load, rate);
  }
  const auto follow = [&](const Lag& lag, double followed, std::size_t i) {
    return lag.left * followed + lag.first * from.force[i] + lag.last * end_force[i];
  };
  for (std::size_t i = 0; i < end_force.size(); ++i) {
    end.force[i] = end_force[i];
    end.touches[i] = end_force[i] > 0.0 ? 1 : 0;
    end.rest_force[i] = follow(kernels.rest, from.rest_force[i], i);
    if (model_->give[i] > 0.0) {
      const Lag lag = kernels.supports.empty() ? Lag{} : kernels.supports[i];
      end.give[i] = model_->give[i] * follow(lag, from.give[i] / model_->give[i], i);
    }
  }
  return end;
}

double KernelSteps::gap(const ModalState& state, std::size_t point) const {
  const auto row = model_->row_of(point);
  const std::size_t points = model_->points();
  double sum = std::inner_product(row.begin(), row.end(), state.amplitude.begin(), drive_.offset_at(point, state.time));
  for (std::size_t j = 0; j < points; ++j) {
    sum += model_->compliance[point * points + j] * state.rest_force[j];
  }
  return sum + state.give[point];
}

ModalFlow KernelSteps::flow_of(const ModalState& from, const ModalKernels& kernels, const ModalState& end,
                               const Push& push) const {
  ModalFlow flow{model_->modes(), model_->points()};
  add_modes(from, kernels, end, push, flow);
  for (std::size_t i = 0; i < model_->points(); ++i) {
    flow.impulse[i] = 0.5 * kernels.time * (from.force[i] + end.force[i]);
    flow.rest_force[i] = flow.impulse[i] - model_->rest_lag * (end.rest_force[i] - from.rest_force[i]);
  }
  add_supports(from, kernels, end, flow);
  flow.radiated = radiated(from, kernels, end);
  return flow;
}

void KernelSteps::add_modes(const ModalState& from, const ModalKernels& kernels, const ModalState& end,
                            const Push& push, ModalFlow& flow) const {
  for (std::size_t m = 0; m < model_->modes(); ++m) {
    const double w = model_->frequency[m];
    const double zeta = model_->ratio.empty() ? 0.0 : model_->ratio[m];
    const Oscillator& mode = kernels.modes[m];
    const double load = drive_.load_at(m, from.time) + push.before[m];
    const double rate = drive_.load_slope(m) + (push.after[m] - push.before[m]) / kernels.time;
    flow.amplitude[m] = (mode.s + 2.0 * zeta * w * mode.f2) * from.amplitude[m] + mode.f2 * from.velocity[m] +
                        mode.f3 * load + mode.f4 * rate;
    if (zeta > 0.0) {
      const double work =
          (load + kernels.time * rate) * end.amplitude[m] - load * from.amplitude[m] - rate * flow.amplitude[m];
      const auto energy = [&](const ModalState& state) {
        return 0.5 * (std::pow(state.velocity[m], 2) + std::pow(w * state.amplitude[m], 2));
      };
      flow.in_modes += work - energy(end) + energy(from);
    }
  }
}

/// What supports that move bring in, and what their dampers take.
void KernelSteps::add_supports(const ModalState& from, const ModalKernels& kernels, const ModalState& end,
                               ModalFlow& flow) const {
  for (std::size_t i = 0; i < model_->points(); ++i) {
    if (!drive_.retreat.empty()) {
      // Force times the speed of a face is a cubic: two Gauss points.
      for (const double at : {0.5 - 0.5 / std::numbers::sqrt3, 0.5 + 0.5 / std::numbers::sqrt3}) {
        const double force = from.force[i] + at * (end.force[i] - from.force[i]);
        const double since = from.time - drive_.time + at * kernels.time;
        flow.support_work -= 0.5 * kernels.time * force * power_series::slope(drive_.retreat[i].data(), 4, since);
      }
    }
    if (!model_->support_lag.empty() && model_->give[i] > 0.0 && model_->support_lag[i] > 0.0) {
      const LagLoss loss{kernels.time, model_->support_lag[i], kernels.supports[i]};
      const auto course = loss.course(from.give[i] / model_->give[i], from.force[i], end.force[i]);
      flow.in_supports += model_->give[i] * loss.of(course, course);
    }
  }
}

/// What the lag of the rest takes [J].
double KernelSteps::radiated(const ModalState& from, const ModalKernels& kernels, const ModalState& end) const {
  if (model_->rest_lag == 0.0) {
    return 0.0;
  }
  const std::size_t points = model_->points();
  const LagLoss loss{kernels.time, model_->rest_lag, kernels.rest};
  std::vector<LagLoss::Course> courses;
  courses.reserve(points);
  for (std::size_t i = 0; i < points; ++i) {
    courses.push_back(loss.course(from.rest_force[i], from.force[i], end.force[i]));
  }
  double sum = 0.0;
  for (std::size_t i = 0; i < points; ++i) {
    for (std::size_t j = 0; j < points; ++j) {
      sum += model_->compliance[i * points + j] * loss.of(courses[i], courses[j]);
    }
  }
  return sum;
}

/// Work of contact forces on gaps in a step from `state_`, but for what rest and springs hold: none where a gap is
/// closed while there is a force.
double KernelSteps::gap_work(const ModalState& end, const ModalFlow& flow, double time, const Push& push) const {
  double work = flow.radiated + flow.in_supports - flow.support_work;
  for (std::size_t m = 0; m < model_->modes(); ++m) {
    work += push.after[m] * end.amplitude[m] - push.before[m] * state_.amplitude[m] -
            (push.after[m] - push.before[m]) / time * flow.amplitude[m];
  }
  for (std::size_t i = 0; i < model_->points(); ++i) {
    work += flow.impulse[i] * drive_.offset_slope(i);
  }
  return work;
}

ModalState KernelSteps::at(double time) const {
  if (taken_.empty() || time >= state_.time) {
    return state_;
  }
  const Taken& step = step_at(time);
  const double elapsed = time - step.start.time;
  if (!(elapsed > 0.0)) {
    return step.start;
  }
  std::vector<double> force = step.start.force;
  for (std::size_t i = 0; i < force.size(); ++i) {
    force[i] += elapsed / step.length * (step.end_force[i] - force[i]);
  }
  return moved(step.start, ModalKernels{*model_, elapsed}, force, {pushed(step.start.force), pushed(force)});
}

std::vector<ModalContact> KernelSteps::contacts() const {
  std::vector<ModalContact> all;
  for (std::size_t i = 0; i < model_->points(); ++i) {
    for (const Taken& step : taken_) {
      if (step.start.force[i] == 0.0 && step.end_force[i] == 0.0) {
        continue;
      }
      const double end = step.start.time + step.length;
      if (!all.empty() && all.back().point == i && all.back().until == step.start.time) {
        all.back().until = end;
      } else {
        all.push_back({.point = i, .from = step.start.time, .until = end});
      }
    }
  }
  return all;
}

ModalFlow KernelSteps::flow(double until) const {
  if (taken_.empty() || until >= state_.time) {
    return passed_;
  }
  const Taken& step = step_at(until);
  ModalFlow sum = step.before;
  const double elapsed = until - step.start.time;
  if (elapsed > 0.0) {
    const ModalState end = at(until);
    sum.add(flow_of(step.start, ModalKernels{*model_, elapsed}, end, {pushed(step.start.force), pushed(end.force)}));
  }
  return sum;
}

}  // namespace udar
