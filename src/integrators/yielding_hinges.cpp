#include "udar/integrators/yielding_hinges.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>

#include "udar/numerics/bernstein.hpp"
#include "udar/petsc/array.hpp"
#include "udar/petsc/error.hpp"

namespace udar {
namespace {

constexpr double kNoStand = std::numeric_limits<double>::infinity();

// Moments nearer to a bound than this share of it are at it (sums of a few thousand products round by less).
constexpr double kAtBound = 1e-12;
// A rate that differs by more of wf times the yield moment from that at the end of the last step has jumped: masses
// have hit something there.
constexpr double kJumped = 1e-9;

constexpr const char* kHingeBounds = "hinge_bounds";
constexpr const char* kHingeStands = "hinge_stands";
constexpr const char* kHingeRates = "hinge_rates";

}  // namespace

YieldingHinges::YieldingHinges(Equations& equations)
    : equations_{&equations},
      hinges_{equations.hinges()},
      line_{equations.line(), *equations.hinges()},
      constant_(line_.points()),
      steady_(line_.points()),
      load_rate_(line_.points()),
      event_at_(line_.points(), kNoStand),
      towards_(line_.points(), 0),
      rotation_before_(line_.points()),
      turned_before_(line_.points()) {
  for (Status* status : {&now_, &next_}) {
    status->bound.assign(line_.points(), 0);
    status->stands.assign(line_.points(), 0);
    status->rate.assign(line_.points(), 0.0);
  }
}

/// X of the hinges; then its rates while they do not turn, by velocities and by loads; then these of loads alone.
std::vector<double> YieldingHinges::stresses(const Instant& at, std::span<const double> position,
                                             std::span<const double> velocity, const LoadRate* rate) const {
  std::vector<double> work;
  std::vector<double> rate_work;
  std::vector<double> displacement(position.size());
  std::ranges::transform(position, equations_->axis(), displacement.begin(), std::minus{});
  std::vector<ReleasedLine::Field> fields{{.displacement = displacement, .force = equations_->loads().force(at, work)}};
  if (!velocity.empty()) {
    const std::span<const double> change = rate != nullptr && !rate->stretch.empty()
                                               ? equations_->loads().rate({at.time, at.time}, rate_work)
                                               : std::span<const double>{};
    fields.push_back({.displacement = velocity, .force = change});
    fields.push_back({.displacement = {}, .force = change});
  }
  std::vector<double> moments;
  line_.moments(fields, moments);
  line_.subtract(hinges_->rotations(), std::span{moments}.first(line_.points()));
  return moments;
}

std::vector<double> YieldingHinges::stresses(double time, Vec state) const {
  const petsc::ReadArray now{state};
  return stresses({time, time}, {now.values(), equations_->line().mass().size()}, {}, nullptr);
}

double YieldingHinges::settle(double time, Vec state) {
  const std::span<const PlasticHinge> hinges = hinges_->hinges();
  std::vector<double> value = stresses(time, state);
  std::vector<double> lower;
  std::vector<double> upper;
  for (std::size_t i = 0; i < value.size(); ++i) {
    value[i] = -value[i];
    lower.push_back(-hinges[i].moment);
    upper.push_back(hinges[i].moment);
  }
  std::vector<double> turns(value.size(), 0.0);
  if (!hinges_->rows().solve({.value = value, .lower = lower, .upper = upper}, turns)) {
    return 0.0;
  }
  double lost = 0.0;
  std::vector<double> rotation(hinges_->rotations().begin(), hinges_->rotations().end());
  for (std::size_t i = 0; i < turns.size(); ++i) {
    rotation[i] += turns[i];
    lost += hinges[i].moment * std::abs(turns[i]);
  }
  hinges_->turn(rotation);
  return own_share(lost);
}

void YieldingHinges::start(double time, Vec state) {
  const std::vector<double> value = stresses(time, state);
  for (std::size_t i = 0; i < value.size(); ++i) {
    const bool reached = std::abs(value[i]) >= hinges_->hinges()[i].moment * (1.0 - kAtBound);
    next_.bound[i] = static_cast<std::int8_t>(!reached ? 0 : value[i] > 0.0 ? 1 : -1);
    next_.stands[i] = 0;
  }
}

/// Of the hinges at a bound those that would go beyond it; who has just come to a stand goes back.
std::vector<std::int8_t> YieldingHinges::who_yields(std::span<const double> rates) {
  const std::size_t count = rates.size();
  const double wf = equations_->line().filter_frequency();
  bool jumped = false;
  for (std::size_t i = 0; i < count; ++i) {
    jumped = jumped || std::abs(rates[i] - now_.rate[i]) > kJumped * wf * hinges_->hinges()[i].moment;
  }
  std::vector<std::size_t> due;
  std::vector<double> signs(count, 1.0);
  std::vector<double> towards(count);
  for (std::size_t i = 0; i < count; ++i) {
    if (now_.bound[i] != 0 && (jumped || now_.stands[i] == 0)) {
      due.push_back(i);
    }
    signs[i] = now_.bound[i] < 0 ? -1.0 : 1.0;
    towards[i] = -signs[i] * rates[i];
  }
  std::vector<double> matrix = yielding_matrix(*hinges_);
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = 0; j < count; ++j) {
      matrix[i * count + j] *= signs[i] * signs[j];
    }
  }
  const std::vector<std::uint8_t> none(count, 0);
  const std::vector<std::uint8_t> found = Complementarity{std::move(matrix), count}.follow(none, due, towards);
  std::vector<std::int8_t> yields(count, 0);
  for (std::size_t i = 0; i < count; ++i) {
    yields[i] = found[i] != 0 ? now_.bound[i] : std::int8_t{0};
  }
  return yields;
}

void YieldingHinges::begin_step(double time, std::span<const double> position, std::span<const double> velocity,
                                LoadRate& rate) {
  const std::size_t count = line_.points();
  begin_ = time;
  now_ = next_;
  std::ranges::copy(hinges_->rotations(), rotation_before_.begin());
  std::ranges::copy(hinges_->turned(), turned_before_.begin());
  const std::vector<double> all = stresses({time, time}, position, velocity, &rate);
  const std::span<const double> rates = std::span{all}.subspan(count, count);
  std::copy_n(all.begin() + static_cast<std::ptrdiff_t>(2 * count), count, load_rate_.begin());
  const bool any_bound = std::ranges::any_of(now_.bound, [](std::int8_t bound) { return bound != 0; });
  line_.assume(any_bound ? who_yields(rates) : std::vector<std::int8_t>(count, 0));
  for (std::size_t i = 0; i < count; ++i) {
    const double at_bound = static_cast<double>(now_.bound[i]) * hinges_->hinges()[i].moment;
    constant_[i] = line_.yields(i) ? hinges_->rotations()[i] : now_.bound[i] != 0 ? at_bound : all[i];
  }
  std::ranges::fill(event_at_, kNoStand);
  steady_ = load_rate_;
  line_.release(steady_);
  if (!rate.stretch.empty()) {
    std::vector<double> turns(count, 0.0);
    for (std::size_t i = 0; i < count; ++i) {
      turns[i] = line_.yields(i) ? steady_[i] : 0.0;
    }
    line_.turn(turns, rate.stretch);
  }
}

/// Of X from a bound. One that begins there does not go beyond it but by rounding.
Kinematics YieldingHinges::distance(const FreeMotion& motion, std::size_t hinge, double side,
                                    const SeriesSample& at) const {
  const double x = constant_[hinge] + steady_[hinge] * at.time + motion.row(at.weights[0], hinge);
  Kinematics left{.position = hinges_->hinges()[hinge].moment - side * x,
                  .velocity = -side * (steady_[hinge] + motion.row(at.weights[1], hinge)),
                  .acceleration = -side * motion.row(at.weights[2], hinge)};
  if (at.time == 0.0 && static_cast<double>(now_.bound[hinge]) == side) {
    left.position = 0.0;
    left.velocity = std::max(left.velocity, 0.0);
  }
  return left;
}

/// How fast a hinge turns the way that it yields, and the rate of that.
std::array<double, 2> YieldingHinges::turning(const FreeMotion& motion, std::size_t hinge,
                                              const SeriesSample& at) const {
  const auto side = static_cast<double>(now_.bound[hinge]);
  return {side * (steady_[hinge] + motion.row(at.weights[1], hinge)), side * motion.row(at.weights[2], hinge)};
}

double YieldingHinges::guess(const FreeMotion& motion) const {
  const SeriesSample start = sample(motion, 0.0);
  double first = any() ? 0.0 : kNoStand;
  for (std::size_t i = 0; i < constant_.size() && !any(); ++i) {
    for (const double side : {1.0, -1.0}) {
      first = std::min(first, guessed_closing(distance(motion, i, side, start)));
    }
  }
  return first;
}

double YieldingHinges::first_stand(const FreeMotion& motion, std::size_t hinge, SeriesGrid& grid, double end) const {
  const double resolution = time_resolution(begin_ + end);
  const auto turns = [&](const SeriesSample& at) { return turning(motion, hinge, at); };
  const auto stands = [&](const SeriesSample& from, const SeriesSample& to) -> std::optional<double> {
    auto start = turns(from);
    const auto last = turns(to);
    const double length = to.time - from.time;
    const bool begins = from.time == 0.0 && start[0] <= 0.0;
    start[0] = begins ? 0.0 : start[0];
    const auto theta = first_closing(cubic_bernstein(start[0], start[1], last[0], last[1], length), begins ? 1 : 0);
    return theta ? std::optional{polished(motion, from.time + *theta * length, from.time, to.time, resolution, turns)}
                 : std::nullopt;
  };
  return grid
      .first([&](const SeriesSample& at) { return Kinematics{.position = turns(at)[0]}; },
             [](const Kinematics& /*start*/, const Kinematics& /*end*/, double /*length*/) { return true; }, stands)
      .value_or(kNoStand);
}

double YieldingHinges::search(const FreeMotion& motion, double from, double to) {
  SeriesGrid grid{motion, from, to, equations_->frequency_bound()};
  const double resolution = time_resolution(begin_ + to);
  for (std::size_t i = 0; i < constant_.size(); ++i) {
    event_at_[i] = line_.yields(i) ? first_stand(motion, i, grid, to) : kNoStand;
    for (const double side : {1.0, -1.0}) {
      if (line_.yields(i)) {
        continue;
      }
      const auto value = [&](const SeriesSample& at) { return distance(motion, i, side, at); };
      const auto time = grid.first(value, comes_near, [&](const SeriesSample& start, const SeriesSample& end) {
        return first_closing(motion, start, end, resolution, value);
      });
      if (time && *time < event_at_[i]) {
        event_at_[i] = *time;
        towards_[i] = static_cast<std::int8_t>(side);
      }
    }
  }
  return std::ranges::min(event_at_);
}

void YieldingHinges::end_step(const FreeMotion& motion, double length) {
  const double at_once = length + 2.0 * time_resolution(begin_ + length);
  const SeriesSample end = sample(motion, length);
  hinges_->turn(rotations(motion, length));
  std::vector<double> turns(constant_.size(), 0.0);
  for (std::size_t i = 0; i < constant_.size(); ++i) {
    const bool event = event_at_[i] <= at_once;
    const double rate = steady_[i] + motion.row(end.weights[1], i);
    next_.stands[i] = line_.yields(i) && event ? 1 : 0;
    next_.bound[i] = line_.yields(i) ? now_.bound[i] : event ? towards_[i] : std::int8_t{0};
    turns[i] = line_.yields(i) ? rate : 0.0;
    next_.rate[i] = line_.yields(i) ? 0.0 : rate;
  }
  // Of a line whose hinges do not turn.
  std::ranges::transform(turns, turns.begin(), std::negate{});
  line_.subtract(turns, next_.rate);
}

void YieldingHinges::take_back() {
  next_ = now_;
  hinges_->restore(rotation_before_, turned_before_);
}

std::vector<double> YieldingHinges::rotations(const FreeMotion& motion, double time) const {
  std::vector<double> rotation(rotation_before_);
  if (any()) {
    const FreeMotion::Weights weights = motion.weights(0, time);
    for (std::size_t i = 0; i < rotation.size(); ++i) {
      rotation[i] = line_.yields(i) ? constant_[i] + steady_[i] * time + motion.row(weights, i) : rotation[i];
    }
  }
  return rotation;
}

double YieldingHinges::lost(const FreeMotion& motion, double time) const {
  double sum = 0.0;
  const std::vector<double> rotation = rotations(motion, time);
  for (std::size_t i = 0; i < rotation.size(); ++i) {
    sum += static_cast<double>(now_.bound[i]) * hinges_->hinges()[i].moment * (rotation[i] - rotation_before_[i]);
  }
  return own_share(sum);
}

void YieldingHinges::save(MotionState& state) const {
  state.tables[kHingeBounds].assign(next_.bound.begin(), next_.bound.end());
  state.tables[kHingeStands].assign(next_.stands.begin(), next_.stands.end());
  state.tables[kHingeRates] = next_.rate;
}

void YieldingHinges::restore(const MotionState& state) {
  const auto flags = [&](const char* name, std::vector<std::int8_t>& values) {
    const std::vector<double>& saved = state.table(name);
    if (saved.size() != values.size()) {
      throw InputError{"restart file: it was written with another number of plastic hinges"};
    }
    std::ranges::transform(saved, values.begin(), [](double value) {
      return static_cast<std::int8_t>(value > 0.0 ? 1 : value < 0.0 ? -1 : 0);
    });
  };
  flags(kHingeBounds, next_.bound);
  flags(kHingeStands, next_.stands);
  next_.rate = state.table(kHingeRates);
  next_.rate.resize(line_.points());
}

}  // namespace udar
