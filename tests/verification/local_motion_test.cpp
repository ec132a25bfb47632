// ranks: 1 2; size: medium
/// @file
/// The impact integrator on random problems against a slow reference: the same law, in long double, with every zero of
/// every derivative bracketed.

#include "udar/local/local_motion.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "udar/local/local_batch.hpp"
#include "udar/numerics/power_series.hpp"
#include "udar/numerics/roots.hpp"

namespace udar {
namespace {

using Real = long double;

constexpr std::size_t kDerivatives = 34;
constexpr int kMostCompared = 30;  ///< impacts up to which ends are compared
constexpr std::size_t kSamples = 8;
constexpr int kMostAfterRest = 3;  ///< impacts of a mass whose speed `kMostImpacts` took, lifted off again

/// A function by its derivatives at 0: f(s) = sum_k at[k] s^k / k!.
struct Taylor {
  std::array<Real, kDerivatives> at{};
  std::size_t count = 0;

  /// Derivative `order` at s.
  [[nodiscard]] Real operator()(std::size_t order, Real s) const {
    static const std::array<Real, kDerivatives + 1> inverse = [] {  // up to that of `count`, for derivative 0
      std::array<Real, kDerivatives + 1> table{};
      for (std::size_t k = 1; k <= kDerivatives; ++k) {
        table[k] = 1.0L / static_cast<Real>(k);
      }
      return table;
    }();
    Real sum = 0.0L;
    for (std::size_t k = count; k-- > order;) {
      sum = at[k] + sum * s * inverse[k - order + 1];
    }
    return sum;
  }

  /// Sign of the first derivative that is not zero at 0, from `order` on.
  [[nodiscard]] int leading(std::size_t order) const {
    for (std::size_t k = order; k < count; ++k) {
      if (at[k] != 0.0L) {
        return at[k] > 0.0L ? 1 : -1;
      }
    }
    return 0;
  }

  /// The zero of derivative `order` in [a, b], whose ends differ in sign: Newton's method, kept in the bracket.
  [[nodiscard]] Real bracketed(std::size_t order, Real a, Real b) const {
    const bool rises = (*this)(order, b) > 0.0L;
    Real s = 0.5L * (a + b);
    for (int turn = 0; turn < 200; ++turn) {
      const Real f = (*this)(order, s);
      if (f == 0.0L) {
        break;
      }
      ((f > 0.0L) == rises ? b : a) = s;
      Real next = s - f / (*this)(order + 1, s);
      if (!(next > a && next < b) || turn % 8 == 7) {
        next = 0.5L * (a + b);
      }
      const Real moved = std::abs(next - s);
      s = next;
      if (moved <= 1e-19L * s || b - a <= 2e-19L * b) {
        break;
      }
    }
    return s;
  }

  /// 0, all sign changes of derivative 1 inside, and `end`, given that derivative `simple` changes sign once at most
  /// there: between two zeros of a derivative the one below it is monotone.
  [[nodiscard]] std::vector<Real> turns(std::size_t simple, Real end) const {
    std::vector<Real> knots{0.0L, end};
    std::vector<Real> next;
    for (std::size_t order = simple; order >= 1; --order) {
      next.assign(1, 0.0L);
      Real from = (*this)(order, 0.0L);
      for (std::size_t i = 1; i < knots.size(); ++i) {
        const Real to = (*this)(order, knots[i]);
        if ((from < 0.0L && to > 0.0L) || (from > 0.0L && to < 0.0L)) {
          next.push_back(bracketed(order, knots[i - 1], knots[i]));
        }
        from = to;
      }
      next.push_back(end);
      knots = next;
    }
    return knots;
  }
};

/// Nodes and weights of Gauss quadrature on [0, 1].
struct Gauss {
  static constexpr std::size_t kCount = 10;
  std::array<Real, kCount> node{};
  std::array<Real, kCount> weight{};
  Gauss() {
    for (std::size_t i = 0; i < kCount; ++i) {
      Real x = std::cos(std::numbers::pi_v<Real> * (static_cast<Real>(i) + 0.75L) / (kCount + 0.5L));
      Real derivative = 1.0L;
      for (int turn = 0; turn < 12; ++turn) {
        Real before = 1.0L;
        Real p = x;
        for (std::size_t k = 2; k <= kCount; ++k) {
          const Real k1 = static_cast<Real>(k);
          const Real after = ((2.0L * k1 - 1.0L) * x * p - (k1 - 1.0L) * before) / k1;
          before = p;
          p = after;
        }
        derivative = kCount * (x * p - before) / (x * x - 1.0L);
        x -= p / derivative;
      }
      node[i] = 0.5L * (1.0L + x);
      weight[i] = 1.0L / ((1.0L - x * x) * derivative * derivative);
    }
  }
};

struct Event {
  char kind = ' ';  ///< i: impact, r: rest, l: release
  int stop = 0;
  double tau = 0.0;
  double before = 0.0;
  double after = 0.0;
};

class Listener final : public local::Journal {
 public:
  explicit Listener(std::vector<Event>& events) : events_{&events} {}
  void impact(int stop, double tau, double before, double after) override {
    events_->push_back({'i', stop, tau, before, after});
  }
  void rest(int stop, double tau, double speed) override { events_->push_back({'r', stop, tau, speed, 0.0}); }
  void release(int stop, double tau) override { events_->push_back({'l', stop, tau, 0.0, 0.0}); }

 private:
  std::vector<Event>* events_;
};

/// The reference: flights and rests of one mass by Taylor series in long double, one after the other.
class Reference {
 public:
  std::array<Real, kMostTerms> moments{};
  std::array<Real, kSamples> sampled{};
  Real displacement = 0.0L;
  Real velocity = 0.0L;
  int resting = -1;
  int impacts = 0;
  bool marginal = false;  ///< round-off decides what happens
  bool cut = false;       ///< more than `kMostCompared` impacts
  std::vector<Real> releases;

  /// Marginal: an impact slower than 1e-7 of the scale per step in flight, a hop within 1e-3 of the hop tolerance, a
  /// plastic impact where the pull is 1e-10 of its scale, a gap (or a pressing stretch) whose least value, also at the
  /// end of the step, is within 1e-10 of the scale from 0.
  Reference(const local::Problem& problem, Real scale, const std::array<double, kSamples>& samples)
      : velocity{problem.velocity},
        resting{problem.resting},
        problem_{problem},
        scale_{scale},
        samples_{samples},
        z2_{static_cast<Real>(problem.angle) * problem.angle} {
    if (resting >= 0) {
      place_ = stop(resting).at;
      velocity = 0.0L;
    }
    for (int side = 0; side < 2 && resting < 0; ++side) {
      if (stop(side).present && std::abs(stop(side).at) <= problem.together) {
        on_ = side;
      }
    }
    while (!done_) {
      expand_line();
      if (resting >= 0) {
        rest();
      } else {
        fly();
      }
    }
    displacement = place_;
  }

 private:
  struct Meeting {
    Real end = 0.0L;  ///< of the flight
    int stop = -1;    ///< that is met there
    Real close_at = 2.0L;
  };

  static constexpr Real kNear = 1e-10L;

  [[nodiscard]] const local::Stop& stop(int side) const { return problem_.stops[static_cast<std::size_t>(side)]; }
  [[nodiscard]] Real line(std::size_t order) const { return order < problem_.terms ? line_[order] : 0.0L; }

  /// The line's derivatives at `tau_`.
  void expand_line() {
    line_.fill(0.0L);
    for (std::size_t order = 0; order < problem_.terms; ++order) {
      for (std::size_t k = problem_.terms; k-- > order;) {
        Real factor = problem_.line[k];
        for (std::size_t i = 0; i < order; ++i) {
          factor *= static_cast<Real>(k - i);
        }
        line_[order] = line_[order] * tau_ + factor;
      }
    }
  }

  /// Adds a stretch of the motion to the moments and samples.
  void pass(const Taylor& z, Real length, bool last) {
    static const Gauss gauss;
    for (std::size_t i = 0; i < Gauss::kCount; ++i) {
      const Real at = z(0, gauss.node[i] * length);
      const Real x = 2.0L * (tau_ + gauss.node[i] * length) - 1.0L;
      Real before = 1.0L;
      Real p = x;
      for (std::size_t j = 0; j < problem_.terms; ++j) {
        const Real now = j == 0 ? 1.0L : p;
        moments[j] += static_cast<Real>(2 * j + 1) * length * gauss.weight[i] * now * at;
        if (j > 0) {
          const Real k = static_cast<Real>(j + 1);
          const Real after = ((2.0L * k - 1.0L) * x * p - (k - 1.0L) * before) / k;
          before = p;
          p = after;
        }
      }
    }
    for (std::size_t i = 0; i < kSamples; ++i) {
      if (samples_[i] >= tau_ && (last || samples_[i] < tau_ + length)) {
        sampled[i] = z(0, samples_[i] - tau_);
      }
    }
    tau_ += length;
  }

  void rest() {
    const Real left = 1.0L - tau_;
    const Real side = resting == 0 ? 1.0L : -1.0L;
    Taylor pressing;
    pressing.count = problem_.terms;
    for (std::size_t k = 0; k < problem_.terms; ++k) {
      pressing.at[k] = -side * (line_[k] - (k == 0 ? place_ : 0.0L));
    }
    bool leaves = pressing.leading(0) < 0;
    Real end = leaves ? 0.0L : left;
    const std::vector<Real> knots = leaves ? std::vector<Real>{} : pressing.turns(problem_.terms, left);
    for (std::size_t i = 1; i < knots.size() && !leaves; ++i) {
      const Real least = pressing(0, knots[i]);
      const bool turn = i + 1 == knots.size() || pressing(2, knots[i]) > 0.0L;
      marginal = marginal || (turn && pressing.leading(0) != 0 && std::abs(least) < kNear * scale_);
      if (least < 0.0L) {
        leaves = true;
        end = pressing(0, knots[i - 1]) > 0.0L ? pressing.bracketed(0, knots[i - 1], knots[i]) : knots[i - 1];
      }
    }
    Taylor still;
    still.count = 1;
    still.at[0] = place_;
    pass(still, end, !leaves);
    if (!leaves) {
      done_ = true;
      return;
    }
    releases.push_back(tau_);
    on_ = resting;
    resting = -1;
    released_ = end > 0.0L;
    velocity = 0.0L;
  }

  /// The free motion from `tau_` on.
  [[nodiscard]] Taylor flight() const {
    Taylor z;
    z.count = kDerivatives;
    z.at[0] = place_;
    z.at[1] = velocity;
    const auto higher = [&] {
      for (std::size_t k = 2; k + 2 < kDerivatives; ++k) {
        z.at[k + 2] = z2_ * (line(k) - z.at[k]);
      }
    };
    z.at[2] = z2_ * (line(0) - z.at[0]);
    z.at[3] = z2_ * (line(1) - z.at[1]);
    higher();
    if (released_) {
      z.at[4] += z2_ * z.at[2];
      z.at[2] = 0.0L;  // what the release means
      higher();
    }
    return z;
  }

  /// Looks for the first contact with one stop between the knots of a flight.
  void meet(int side, const Taylor& z, const std::vector<Real>& knots, Meeting& meeting) {
    const Real sign = side == 0 ? 1.0L : -1.0L;
    Taylor gap = z;
    for (Real& value : gap.at) {
      value *= sign;
    }
    gap.at[0] = on_ == side ? 0.0L : sign * (place_ - stop(side).at);
    if (on_ == side && gap.leading(1) < 0) {
      meeting.end = 0.0L;
      meeting.stop = side;
      return;
    }
    for (std::size_t i = 1; i < knots.size(); ++i) {
      const Real least = gap(0, knots[i]);
      const bool turn = i + 1 == knots.size() || gap(2, knots[i]) > 0.0L;
      if (turn && std::abs(least) < kNear * scale_ && knots[i] < meeting.close_at) {
        meeting.close_at = knots[i];
      }
      if (least < 0.0L) {
        const Real root = gap.bracketed(0, knots[i - 1], knots[i]);
        if (root < meeting.end || meeting.stop < 0) {
          meeting.end = root;
          meeting.stop = side;
        }
        if (meeting.close_at == knots[i]) {
          meeting.close_at = root;
        }
        return;
      }
    }
  }

  void fly() {
    const Taylor z = flight();
    released_ = false;
    const Real left = 1.0L - tau_;
    const std::vector<Real> knots = z.turns(problem_.terms, left);
    Meeting meeting;
    meeting.end = left;
    for (int side = 0; side < 2; ++side) {
      if (stop(side).present) {
        meet(side, z, knots, meeting);
      }
    }
    marginal = marginal || meeting.close_at <= meeting.end;
    const Real arrived = z(1, meeting.end);
    const Real reached = z(0, meeting.end);
    pass(z, meeting.end, meeting.stop < 0);
    on_ = -1;
    velocity = arrived;
    place_ = reached;
    if (meeting.stop < 0) {
      done_ = true;
    } else {
      hit(meeting, z(2, meeting.end));
    }
  }

  void hit(const Meeting& meeting, Real acceleration) {
    const local::Stop& support = stop(meeting.stop);
    const Real side = meeting.stop == 0 ? 1.0L : -1.0L;
    const Real pull = side * acceleration;
    place_ = support.at;
    const Real before = side * velocity;
    const Real after = before < 0.0L ? -support.restitution * before : 0.0L;
    if (before < 0.0L) {
      ++impacts;
      marginal = marginal || (meeting.end > 0.0L && -before < 1e-7L * scale_);
    }
    const Real limit = -2.0L * pull * problem_.hop_tolerance;
    if (after > 0.0L) {
      marginal = marginal || std::abs(after * after - limit) < 1e-3L * std::abs(limit);
    } else if (before < 0.0L) {
      marginal = marginal || std::abs(pull) < kNear * z2_ * scale_;
    }
    if (impacts > kMostCompared) {
      cut = true;
      done_ = true;
    } else if ((pull < 0.0L && after * after <= limit) || (after == 0.0L && pull <= 0.0L)) {
      resting = meeting.stop;
      velocity = 0.0L;
    } else {
      velocity = side * after;
      on_ = meeting.stop;
    }
  }

  const local::Problem& problem_;
  Real scale_;
  const std::array<double, kSamples>& samples_;
  Real z2_;
  Real tau_ = 0.0L;
  Real place_ = 0.0L;
  int on_ = -1;            ///< the stop that the mass flies off
  bool released_ = false;  ///< with the line's pull zero
  bool done_ = false;
  std::array<Real, kMostTerms> line_{};
};

/// A problem and the size of its displacements.
struct Drawn {
  local::Problem problem;
  double scale = 0.0;
};

using Source = std::mt19937_64;

double uniform(Source& source, double from, double to) {
  return std::uniform_real_distribution<double>(from, to)(source);
}

std::size_t below(Source& source, std::size_t count) {
  return std::uniform_int_distribution<std::size_t>(0, count - 1)(source);
}

Drawn draw(Source& source) {
  constexpr std::array<double, 5> kRestitutions{0.0, 0.3, 0.5, 0.9, 1.0};
  constexpr double kTogether = 1e-12;
  Drawn drawn;
  local::Problem& problem = drawn.problem;
  const double length = std::pow(10.0, uniform(source, -2.0, 0.0));
  problem.hop_tolerance = 1e-10;
  problem.together = kTogether;
  problem.angle = uniform(source, 0.05, 1.5);
  problem.powers = local::powers_for(problem.angle);
  problem.terms = 2 + below(source, kMostTerms - 1);
  const auto sign = [&source] { return below(source, 2) == 0 ? -1.0 : 1.0; };
  problem.velocity = below(source, 6) == 0 ? 0.0 : sign() * length * std::pow(10.0, uniform(source, -6.0, 1.0));
  const std::size_t present = 1 + below(source, 3);  // lower, upper, both
  for (std::size_t stop = 0; stop < 2; ++stop) {
    local::Stop& support = problem.stops[stop];
    support.present = ((present >> stop) & 1U) != 0;
    support.restitution = kRestitutions[below(source, kRestitutions.size())];
    support.at = (stop == 0 ? -1.0 : 1.0) * length * std::pow(10.0, uniform(source, -4.0, 0.5));
  }
  // Where it starts: off the stops, on one of them, or at rest on it.
  const std::size_t start = below(source, 4);
  const std::size_t stop = present == 3 ? below(source, 2) : present - 1;
  if (start >= 2) {
    problem.stops[stop].at = below(source, 4) == 0 ? uniform(source, -0.5, 0.5) * kTogether : 0.0;
  }
  if (start == 3) {
    problem.stops[stop].at = 0.0;
    problem.resting = static_cast<int>(stop);
    problem.velocity = 0.0;
  }
  for (std::size_t k = 0; k < problem.terms; ++k) {
    problem.line[k] = sign() * length * std::pow(10.0, uniform(source, -2.0, 0.7));
  }
  const std::size_t shape = below(source, 8);
  const double at = problem.stops[stop].at;
  if (shape == 0) {  // presses on the stop, and lifts later or not at all
    problem.line[0] = (stop == 0 ? -1.0 : 1.0) * std::abs(problem.line[0]);
  } else if (shape == 1) {  // touches the stop's place between, or nearly does
    const double where = uniform(source, 0.0, 1.0);
    const double curvature = problem.line[1];
    problem.line = {at + curvature * where * where + (below(source, 2) == 0 ? 0.0 : 1e-4 * sign() * length),
                    -2.0 * curvature * where};
    (problem.terms > 2 ? problem.line[2] : problem.line[1]) = curvature;
  } else if (shape == 2) {  // balances at the start, and leaves with some power of time
    const std::size_t first = below(source, problem.terms + 1);
    for (std::size_t k = 0; k < first; ++k) {
      problem.line[k] = k == 0 ? at : 0.0;
    }
  }
  drawn.scale = std::max(length, std::abs(problem.velocity));
  for (const double term : problem.line) {
    drawn.scale = std::max(drawn.scale, std::abs(term));
  }
  return drawn;
}

std::string describe(const local::Problem& problem) {
  std::array<char, 600> text{};
  std::snprintf(text.data(), text.size(),
                "angle %.17g terms %zu line %.17g %.17g %.17g %.17g %.17g velocity %.17g resting %d\n"
                "lower %d at %.17g e %g, upper %d at %.17g e %g",
                problem.angle, problem.terms, problem.line[0], problem.line[1], problem.line[2], problem.line[3],
                problem.line[4], problem.velocity, problem.resting, static_cast<int>(problem.stops[0].present),
                problem.stops[0].at, problem.stops[0].restitution, static_cast<int>(problem.stops[1].present),
                problem.stops[1].at, problem.stops[1].restitution);
  return text.data();
}

/// Keeps the largest.
void raise(double& largest, double value) { largest = std::max(largest, std::isnan(value) ? 1e300 : value); }

/// What holds of every end, however many impacts it took.
void check_end(const local::Problem& problem, const local::Outcome& outcome, double scale) {
  const double round_off = 1e-14 * scale;
  for (int stop = 0; stop < 2; ++stop) {
    const local::Stop& support = problem.stops[static_cast<std::size_t>(stop)];
    const double side = stop == 0 ? 1.0 : -1.0;
    if (!support.present) {
      continue;
    }
    EXPECT_GE(side * (outcome.displacement - support.at), -problem.together - round_off);
    // A mass put back on the stop at the end of its flight must not have been on its way through it.
    EXPECT_FALSE(outcome.resting < 0 && outcome.displacement == support.at && problem.until > 0.0 &&
                 side * outcome.velocity < -1e-9 * scale)
        << "passed a stop";
    if (outcome.resting == stop) {
      EXPECT_EQ(outcome.velocity, 0.0);
      EXPECT_EQ(outcome.displacement, support.at);
      const double line = power_series::value(problem.line.data(), problem.terms, problem.until);
      EXPECT_LE(side * (line - support.at), round_off) << "missed release";
    }
  }
}

void check_journal(const local::Problem& problem, const local::Outcome& outcome, const std::vector<Event>& events,
                   double scale) {
  double lost = 0.0;
  double kick = 0.0;
  int impacts = 0;
  double tau = 0.0;
  int resting = problem.resting;
  for (const Event& event : events) {
    EXPECT_GE(event.tau, tau);
    EXPECT_LE(event.tau, 1.0);
    tau = event.tau;
    if (event.kind == 'i') {
      const double e = problem.stops[static_cast<std::size_t>(event.stop)].restitution;
      EXPECT_EQ(resting, -1);
      EXPECT_LT((event.stop == 0 ? 1.0 : -1.0) * event.before, 0.0);
      EXPECT_LE(std::abs(event.after + e * event.before), 1e-15 * std::abs(event.before));
      const double drop = event.before * event.before - event.after * event.after;
      EXPECT_LE(std::abs(drop - (1.0 - e * e) * event.before * event.before), 1e-15 * event.before * event.before);
      lost += drop;
      kick += std::abs(event.after - event.before);
      ++impacts;
    } else {
      EXPECT_EQ(resting, event.kind == 'r' ? -1 : event.stop);
      resting = event.kind == 'r' ? event.stop : -1;
    }
  }
  EXPECT_EQ(resting, outcome.resting);
  EXPECT_GE(lost, 0.0);
  EXPECT_EQ(impacts, outcome.impacts);
  EXPECT_NEAR(kick, outcome.kick, 1e-12 * (kick + scale));
  EXPECT_LE(outcome.impacts, local::kMostImpacts + kMostAfterRest);
}

int failures() { return ::testing::UnitTest::GetInstance()->current_test_info()->result()->total_part_count(); }

/// The largest deviations from the reference, of the scale of the problem.
struct Deviations {
  double displacement = 0.0;
  double velocity = 0.0;
  double moment = 0.0;
  double release = 0.0;
  double between = 0.0;
};

/// The motion up to instants within the step is that of the whole step.
void check_between(const Drawn& drawn, const Reference& reference, const std::array<double, kSamples>& samples,
                   Deviations& largest) {
  const bool strict = !reference.marginal && !reference.cut;
  for (std::size_t k = 0; k < kSamples; ++k) {
    local::Problem part = drawn.problem;
    part.until = samples[k];
    const local::Outcome there = local::advance(part);
    check_end(part, there, drawn.scale);
    if (strict) {
      const double apart = std::abs(there.displacement - static_cast<double>(reference.sampled[k])) / drawn.scale;
      raise(largest.between, apart);
      EXPECT_LE(apart, 1e-9) << "at " << samples[k];
    }
  }
}

void compare_end(const Drawn& drawn, const local::Outcome& outcome, const Reference& reference, Deviations& largest) {
  EXPECT_EQ(outcome.impacts, reference.impacts);
  EXPECT_EQ(outcome.resting, reference.resting);
  const double off = std::abs(outcome.displacement - static_cast<double>(reference.displacement)) / drawn.scale;
  const double faster = std::abs(outcome.velocity - static_cast<double>(reference.velocity)) / drawn.scale;
  raise(largest.displacement, off);
  raise(largest.velocity, faster);
  EXPECT_LE(off, 1e-9);
  EXPECT_LE(faster, 1e-9);
  for (std::size_t j = 0; j < drawn.problem.terms; ++j) {
    const double apart = std::abs(outcome.moments[j] - static_cast<double>(reference.moments[j])) / drawn.scale;
    raise(largest.moment, apart);
    EXPECT_LE(apart, 1e-8) << "moment " << j;
  }
}

void compare_releases(const std::vector<Event>& events, const Reference& reference, Deviations& largest) {
  std::size_t releases = 0;
  for (const Event& event : events) {
    if (event.kind == 'l') {
      if (releases < reference.releases.size()) {
        const double apart = std::abs(event.tau - static_cast<double>(reference.releases[releases]));
        raise(largest.release, apart);
        EXPECT_LE(apart, 1e-9) << "release";
      }
      ++releases;
    }
  }
  EXPECT_EQ(releases, reference.releases.size());
}

TEST(LocalMotion, FollowsASlowReference) {
  constexpr int kProblems = 20000;
  constexpr int kMostTold = 10;
  Source source(20260802);
  int compared = 0;
  int marginal = 0;
  int cut = 0;
  int most = 0;
  int told = 0;
  int failed = 0;
  Deviations largest;
  std::vector<Event> events;
  for (int i = 0; i < kProblems && told < kMostTold; ++i) {
    const Drawn drawn = draw(source);
    const local::Problem& problem = drawn.problem;
    std::array<double, kSamples> samples{};
    for (std::size_t k = 0; k < kSamples; ++k) {
      samples[k] = (static_cast<double>(k) + uniform(source, 0.0, 1.0)) / kSamples;
    }
    SCOPED_TRACE("problem " + std::to_string(i));
    events.clear();
    Listener listener{events};
    const local::Outcome outcome = local::advance(problem, &listener);
    most = std::max(most, outcome.impacts);
    check_end(problem, outcome, drawn.scale);
    check_journal(problem, outcome, events, drawn.scale);
    const Reference reference(problem, drawn.scale, samples);
    check_between(drawn, reference, samples, largest);
    if (reference.marginal) {
      ++marginal;
    } else if (reference.cut) {
      ++cut;
      EXPECT_GT(outcome.impacts, kMostCompared);
    } else {
      ++compared;
      compare_end(drawn, outcome, reference, largest);
      compare_releases(events, reference, largest);
    }
    if (const int now = failures(); now > failed) {
      failed = now;
      ++told;
      std::printf("problem %d: %s\n", i, describe(problem).c_str());
    }
  }
  EXPECT_LT(marginal, 0.02 * kProblems);
  std::printf(
      "%d compared, %d marginal, %d of more than %d impacts (most %d)\n"
      "largest deviations: displacement %.2g, velocity %.2g, moments %.2g, release %.2g, between %.2g\n",
      compared, marginal, cut, kMostCompared, most, largest.displacement, largest.velocity, largest.moment,
      largest.release, largest.between);
}

/// Nothing presses it on either stop: its speed is taken all the same.
TEST(LocalMotion, EndsBetweenCloseStopsThatItNeverRestsOn) {
  local::Problem problem;
  problem.angle = 1.0;
  problem.terms = 2;
  problem.powers = local::powers_for(problem.angle);
  problem.velocity = 10.0;
  problem.stops = {
      {{.at = -1e-8, .restitution = 1.0, .present = true}, {.at = 1e-8, .restitution = 1.0, .present = true}}};
  problem.hop_tolerance = 1e-10;
  problem.together = 1e-12;
  std::vector<Event> events;
  Listener listener{events};
  const local::Outcome outcome = local::advance(problem, &listener);
  check_end(problem, outcome, problem.velocity);
  check_journal(problem, outcome, events, problem.velocity);
  EXPECT_GE(outcome.impacts, local::kMostImpacts);
  EXPECT_LE(std::abs(outcome.velocity), 2e-8);
}

/// The reference's series against sines and cosines.
TEST(LocalMotion, ReferenceFollowsTheClosedForm) {
  Source source(7);
  for (int i = 0; i < 1000; ++i) {
    Drawn drawn = draw(source);
    local::Problem& problem = drawn.problem;
    problem.stops = {};
    problem.resting = -1;
    const Real w = problem.angle;
    const auto& c = problem.line;
    // z = Q + A cos(w tau) + B sin(w tau), Q = P - P''/w^2 + P''''/w^4
    const auto particular = [&](Real t) {
      const Real p = c[0] + t * (c[1] + t * (c[2] + t * (c[3] + t * c[4])));
      return p - (2.0L * c[2] + t * (6.0L * c[3] + t * 12.0L * c[4])) / (w * w) + 24.0L * c[4] / (w * w * w * w);
    };
    const Real rate = c[1] - 6.0L * c[3] / (w * w);
    std::array<double, kSamples> samples{};
    for (std::size_t k = 0; k < kSamples; ++k) {
      samples[k] = uniform(source, 0.0, 1.0);
    }
    const Reference reference(problem, drawn.scale, samples);
    for (std::size_t k = 0; k < kSamples; ++k) {
      const Real t = samples[k];
      const Real exact =
          particular(t) - particular(0.0L) * std::cos(w * t) + (problem.velocity - rate) / w * std::sin(w * t);
      EXPECT_NEAR(static_cast<double>((reference.sampled[k] - exact) / drawn.scale), 0.0, 1e-11);
    }
  }
}

TEST(LocalMotion, FirstZeroPassesNone) {
  constexpr long kPolynomials = 20000;
  Source source(11);
  double deepest = 0.0;
  double early = 0.0;
  for (long i = 0; i < kPolynomials; ++i) {
    const std::size_t count = 2 + below(source, 7);
    const double end = std::pow(10.0, uniform(source, -3.0, 0.0));
    std::array<double, 8> c{};
    if (below(source, 2) == 0) {
      for (std::size_t k = 0; k < count; ++k) {
        c[k] = uniform(source, -1.0, 1.0) * std::pow(10.0, uniform(source, -4.0, 0.0)) /
               std::pow(end, static_cast<double>(k));
      }
    } else {  // by its zeros, some of them double
      c[0] = 1.0;
      double last = 0.0;
      for (std::size_t degree = 1; degree < count; ++degree) {
        last = degree > 1 && below(source, 3) == 0 ? last : uniform(source, -0.5, 1.5);
        for (std::size_t k = degree + 1; k-- > 0;) {
          c[k] = (k > 0 ? c[k - 1] : 0.0) - last * c[k];
        }
      }
      for (std::size_t k = 0; k < count; ++k) {
        c[k] /= std::pow(end, static_cast<double>(k));
      }
    }
    if (below(source, 10) == 0) {
      for (std::size_t k = 0; k < 1 + below(source, count - 1); ++k) {
        c[k] = 0.0;
      }
    }
    if (c[0] < 0.0) {
      for (double& value : c) {
        value = -value;
      }
    }
    Taylor f;
    f.count = count;
    Real factorial = 1.0L;
    Real size = 0.0L;
    for (std::size_t k = 0; k < count; ++k) {
      factorial *= k > 0 ? static_cast<Real>(k) : 1.0L;
      f.at[k] = c[k] * factorial;
      size += std::abs(c[k]) * std::pow(static_cast<Real>(end), static_cast<Real>(k));
    }
    const double zero = first_zero(c.data(), count, end);
    const Real reach = zero < 0.0 ? end : zero;
    EXPECT_LE(zero, end);
    Real least = 0.0L;
    for (const Real knot : f.turns(count, reach)) {
      least = std::min(least, f(0, knot));
    }
    raise(deepest, static_cast<double>(-least / size));
    EXPECT_GE(static_cast<double>(least / size), -3e-14) << "polynomial " << i << " returned " << zero;
    if (zero >= 0.0) {
      raise(early, static_cast<double>(f(0, zero) / size));
      EXPECT_LE(static_cast<double>(f(0, zero) / size), 1e-13) << "polynomial " << i << " returned " << zero;
    }
  }
  std::printf("deepest %.2g, earliest %.2g of the terms\n", deepest, early);
}

TEST(LocalMotion, LanesDoAsOneMassAlone) {
  Source source{11};
  constexpr long kTrials = 4000;
  long solved = 0;
  long impacts = 0;
  long rests = 0;
  long left = 0;
  long grazing = 0;
  double worst = 0.0;
  for (long trial = 0; trial < kTrials; ++trial) {
    local::Batch batch;
    std::array<Drawn, local::kLanes> drawn;
    const Drawn first = draw(source);
    for (std::size_t lane = 0; lane < local::kLanes; ++lane) {
      Drawn& one = drawn[lane];
      int stop = 0;
      do {
        one = draw(source);
        stop = one.problem.stops[0].present ? 0 : 1;
      } while (one.problem.resting >= 0 || (one.problem.stops[0].present && one.problem.stops[1].present) ||
               std::abs(one.problem.stops[static_cast<std::size_t>(stop)].at) <= one.problem.together);
      local::Problem& problem = one.problem;
      problem.angle = first.problem.angle;
      problem.terms = first.problem.terms;
      problem.powers = first.problem.powers;
      std::fill(problem.line.begin() + static_cast<long>(problem.terms), problem.line.end(), 0.0);
      const local::Stop& support = problem.stops[static_cast<std::size_t>(stop)];
      std::array<double, kMostTerms> powers = problem.line;
      for (std::size_t k = problem.terms; k-- > 0;) {
        batch.line[k][lane] = powers[k] / kLegendre[k][k];
        for (std::size_t i = 0; i <= k; ++i) {
          powers[i] -= batch.line[k][lane] * kLegendre[k][i];
        }
      }
      batch.velocity[lane] = problem.velocity;
      batch.at[lane] = support.at;
      batch.side[lane] = stop == 0 ? 1.0 : -1.0;
      batch.restitution[lane] = support.restitution;
    }
    local::advance(batch, first.problem.angle, first.problem.terms, first.problem.powers, first.problem.hop_tolerance);
    for (std::size_t lane = 0; lane < local::kLanes; ++lane) {
      if (batch.simple[lane] == 0.0) {
        ++left;
        continue;
      }
      const local::Problem& problem = drawn[lane].problem;
      const local::Outcome alone = local::advance(problem);
      const double scale = drawn[lane].scale;
      const bool hit = batch.impact[lane] <= 1.0;
      if (alone.impacts != (hit ? 1 : 0)) {  // only one of them saw a touch without force
        ++grazing;
        EXPECT_LE(hit ? std::abs(batch.before[lane]) : alone.kick, 1e-6 * scale) << describe(problem);
        continue;
      }
      ++solved;
      impacts += hit ? 1 : 0;
      rests += batch.rests[lane] != 0.0 ? 1 : 0;
      EXPECT_EQ(alone.resting >= 0, batch.rests[lane] != 0.0) << describe(problem);
      double error = std::max(std::abs(alone.displacement - batch.displacement[lane]),
                              std::abs(alone.velocity - batch.end_velocity[lane]));
      for (std::size_t j = 0; j < problem.terms; ++j) {
        error = std::max(error, std::abs(alone.moments[j] - batch.moments[j][lane]));
      }
      if (hit) {
        // A slow impact's instant is known to round-off over its speed.
        const double slow = scale / std::abs(batch.before[lane]);
        EXPECT_NEAR(alone.first_impact, batch.impact[lane], 1e-13 * slow) << describe(problem);
        EXPECT_NEAR(alone.kick, std::abs(batch.after[lane] - batch.before[lane]), 1e-12 * scale * slow);
        error /= std::max(1.0, 0.01 * slow);
      }
      raise(worst, error / scale);
      EXPECT_LE(error / scale, 1e-12) << describe(problem);
    }
  }
  std::printf("%ld solved (%ld impacts, %ld rests), %ld left, %ld grazing; differ by %.2g\n", solved, impacts, rests,
              left, grazing, worst);
  EXPECT_GT(solved, 4 * left);
  EXPECT_GT(impacts, solved / 5);
  EXPECT_GT(rests, 0);
  EXPECT_LT(grazing, kTrials / 1000 + 10);
}

TEST(LocalMotion, EndsWhateverItIsGiven) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  for (const double bad : {kNan, std::numeric_limits<double>::infinity()}) {
    const std::array<double, 4> c{1.0, -2.0, bad, 1.0};
    EXPECT_LT(first_zero(c.data(), c.size(), 1.0), 0.0);
    for (const int resting : {-1, 0}) {
      local::Problem problem;
      problem.angle = 1.0;
      problem.terms = 4;
      problem.powers = local::powers_for(1.0);
      problem.line = {0.0, bad, 0.0, 0.0, 0.0};
      problem.velocity = -1.0;
      problem.stops[0] = {.at = -0.1, .restitution = 0.5, .present = true};
      problem.resting = resting;
      EXPECT_EQ(local::advance(problem).impacts, 0);
    }
  }
}

}  // namespace
}  // namespace udar
