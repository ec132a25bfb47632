// ranks: 1; size: medium
/// @file
/// Laws of contact: one mass against each, by closed forms, and random problems against a slow reference.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "udar/contact/loading_curve.hpp"
#include "udar/contact/power_law.hpp"
#include "udar/local/local_motion.hpp"
#include "udar/petsc/error.hpp"

namespace udar {
namespace {

/// What a journal adds up, per mass and step.
class Sums final : public local::Journal {
 public:
  void pressed(int stop, double push, double work) override {
    push_.at(static_cast<std::size_t>(stop)) += push;
    work_ += work;
  }
  void damped(double loss) override { damped_ += loss; }
  void touched(double from, double until) override {
    from_ = std::min(from_, from);
    until_ = until;
  }
  [[nodiscard]] double push(std::size_t stop = 0) const { return push_.at(stop); }
  [[nodiscard]] double work() const { return work_; }
  [[nodiscard]] double damped() const { return damped_; }
  [[nodiscard]] double from() const { return from_; }
  [[nodiscard]] double until() const { return until_; }

 private:
  std::array<double, 2> push_{};
  double work_ = 0.0;
  double damped_ = 0.0;
  double from_ = 2.0;
  double until_ = -1.0;
};

constexpr double kMass = 3.0;    // kg
constexpr double kStep = 0.02;   // s
constexpr double kSpeed = 1.25;  // m/s

/// A mass at a speed towards the stop that it is about to touch; the spring of the filter does nothing.
local::Problem arriving(const ContactLaw& law, double speed = kSpeed, double step = kStep) {
  local::Problem problem;
  problem.angle = 1e-12;
  problem.terms = 2;
  problem.powers = local::powers_for(problem.angle);
  problem.velocity = -speed * step;
  problem.stops[0] = {.present = true, .contact_law = &law, .carried = kMass, .step = step};
  return problem;
}

/// int_0^1 dx / sqrt(1 - x^a).
double arc_integral(double a) {
  return std::sqrt(std::numbers::pi) * std::tgamma(1.0 / a) / (a * std::tgamma(1.0 / a + 0.5));
}

/// K. L. Johnson, Contact Mechanics, chapter 11: largest compression and contact time, for any exponent.
TEST(PowerLaw, HertzContactLastsAsInTheClosedForm) {
  for (const double n : {1.0, 1.5, 2.0, 2.5}) {
    for (const double depth : {1e-6, 1e-4, 2e-3}) {
      const double k = 0.5 * (n + 1.0) * kMass * kSpeed * kSpeed / std::pow(depth, n + 1.0);
      const PowerLaw law{{.stiffness = k, .exponent = n}};
      const double time = 2.0 * depth / kSpeed * arc_integral(n + 1.0);
      local::Problem problem = arriving(law);
      Sums sums;
      const local::Outcome outcome = local::advance(problem, &sums);
      EXPECT_NEAR(sums.from(), 0.0, 1e-15);
      EXPECT_NEAR(sums.until() * kStep, time, 1e-12 * time) << n << ' ' << depth;
      EXPECT_NEAR(outcome.velocity, kSpeed * kStep, 1e-13 * kStep) << n << ' ' << depth;
      EXPECT_NEAR(sums.push(), 2.0 * kSpeed * kStep, 1e-12 * kStep);
      EXPECT_EQ(sums.damped(), 0.0);
      problem.until = 0.5 * time / kStep;
      const local::Outcome middle = local::advance(problem);
      EXPECT_NEAR(-middle.displacement, depth, 1e-13 * depth) << n << ' ' << depth;
      EXPECT_NEAR(middle.velocity, 0.0, 1e-11 * kStep) << n << ' ' << depth;
      EXPECT_NEAR(law.stored(depth, 0.0), 0.5 * kMass * kSpeed * kSpeed, 1e-13 * kMass);
    }
  }
}

/// m v dv / (1 + c v) = -k d^n dd: v / c - ln(1 + c v) / c^2 is the same at both ends.
TEST(PowerLaw, HuntCrossleyReboundsByItsImplicitEquation) {
  for (const double n : {1.0, 1.5, 2.2}) {
    for (const double cv : {1e-3, 0.1, 0.6, 3.0, 20.0}) {
      const double c = cv / kSpeed;
      const auto level = [](long double x) { return x - std::log1p(x); };
      long double low = 0.0L;
      long double high = std::min(cv, 1.0);
      for (int turn = 0; turn < 200; ++turn) {
        const long double middle = 0.5L * (low + high);
        (middle < 1.0L && level(-middle) < level(cv) ? low : high) = middle;
      }
      const double rebound = static_cast<double>(low) / c;
      const double k = 2e6;
      const PowerLaw law{{.stiffness = k, .exponent = n, .damping = c}};
      const double depth = std::pow(static_cast<double>(level(cv)) / (c * c) * kMass * (n + 1.0) / k, 1.0 / (n + 1.0));
      Sums sums;
      const local::Outcome outcome = local::advance(arriving(law, kSpeed, 5.0), &sums);
      EXPECT_NEAR(outcome.velocity / 5.0, rebound, 1e-11 * kSpeed) << n << ' ' << cv;
      const double lost = 0.5 * (kSpeed * kSpeed - rebound * rebound) * 25.0;
      EXPECT_NEAR(sums.damped(), lost, 1e-12 * kSpeed * kSpeed * 25.0) << n << ' ' << cv;
      local::Problem problem = arriving(law, kSpeed, 5.0);
      double from = 0.0;
      double until = 1.0;
      for (int turn = 0; turn < 60; ++turn) {
        problem.until = 0.5 * (from + until);
        (local::advance(problem).velocity < 0.0 ? from : until) = problem.until;
      }
      EXPECT_NEAR(-local::advance(problem).displacement, depth, 1e-12 * depth) << n << ' ' << cv;
    }
  }
}

/// The law would pull where something tears the mass off: it gives nothing then, and loses what it had stored.
TEST(PowerLaw, NeverPulls) {
  const PowerLaw law{{.stiffness = 4e4, .exponent = 1.5, .damping = 5.0}};
  local::Problem problem = arriving(law, 0.0, 1.0);
  problem.angle = 1.2;
  problem.powers = local::powers_for(problem.angle);
  problem.stops[0].at = 0.02;  // 20 mm in it
  problem.line = {3.0, 0.0};   // up by 4.3 m/s^2 at once, and more than 1 / c soon
  problem.velocity = 0.5;
  Sums sums;
  const local::Outcome outcome = local::advance(problem, &sums);
  EXPECT_EQ(sums.push(), 0.0);
  EXPECT_NEAR(sums.damped(), law.stored(0.02, 0.0) / kMass, 1e-13);
  const double w = problem.angle;
  EXPECT_NEAR(outcome.displacement, 3.0 * (1.0 - std::cos(w)) + 0.5 / w * std::sin(w), 1e-13);
}

/// Loading by k, unloading by k': e = sqrt(k / k'), in contact for quarter periods of both.
TEST(LoadingCurve, BilinearReboundsByTheRootOfItsSlopes) {
  constexpr double kLoading = 5e5;
  for (const double ratio : {1.0, 1.7, 9.0}) {
    const LoadingCurve law{LoadingCurve::bilinear(kLoading, ratio * kLoading)};
    Sums sums;
    const local::Problem problem = arriving(law);
    const local::Outcome outcome = local::advance(problem, &sums);
    const double depth = kSpeed * std::sqrt(kMass / kLoading);
    const double e = 1.0 / std::sqrt(ratio);
    const double time = 0.5 * std::numbers::pi * (1.0 + e) * std::sqrt(kMass / kLoading);
    EXPECT_NEAR(outcome.velocity, e * kSpeed * kStep, 1e-14 * kStep);
    EXPECT_NEAR(outcome.largest[0], depth, 1e-15 * depth * 10.0);
    EXPECT_NEAR(law.permanent_set(depth), depth * (1.0 - 1.0 / ratio), 1e-15);
    EXPECT_NEAR(sums.until() * kStep, time, 1e-13 * time);
    EXPECT_NEAR(sums.damped(), 0.5 * kSpeed * kSpeed * (1.0 - 1.0 / ratio) * kStep * kStep, 1e-15);
    // Once more at the speed it had left with: elastic, as it does not get deeper, and at the face that has moved.
    local::Problem again = arriving(law, e * kSpeed);
    again.stops[0].largest = outcome.largest[0];
    again.stops[0].at = law.permanent_set(depth);
    Sums second;
    const local::Outcome twice = local::advance(again, &second);
    EXPECT_NEAR(twice.velocity, e * kSpeed * kStep, 1e-13 * kStep);
    EXPECT_NEAR(second.damped(), 0.0, 1e-15);
    EXPECT_NEAR(second.from(), 0.0, 1e-15);
    EXPECT_NEAR(second.until() * kStep, e * std::numbers::pi * std::sqrt(kMass / kLoading), 1e-12);
  }
}

/// Elastic, plateau, bottoming out: where it stops by its energy, what it loses by the area of the loop.
TEST(LoadingCurve, CrushStopsWhereItsWorkIsTheEnergy) {
  const LoadingCurve::Crush of{.stiffness = 2e6, .plateau = 1000.0, .bottoming = 2e-3, .bottoming_stiffness = 5e5};
  const LoadingCurve law{LoadingCurve::crush(of)};
  const double yield = of.plateau / of.stiffness;
  for (const double speed : {0.3, 1.0, 3.0}) {
    const double energy = 0.5 * kMass * speed * speed;
    const double elastic = 0.5 * of.plateau * yield;
    const double to_bottom = elastic + of.plateau * (of.bottoming - yield);
    double depth = speed * std::sqrt(kMass / of.stiffness);
    double force = of.stiffness * depth;
    if (energy > to_bottom) {
      const double k = of.bottoming_stiffness;
      depth = of.bottoming + (std::sqrt(of.plateau * of.plateau + 2.0 * k * (energy - to_bottom)) - of.plateau) / k;
      force = of.plateau + k * (depth - of.bottoming);
    } else if (energy > elastic) {
      depth = yield + (energy - elastic) / of.plateau;
      force = of.plateau;
    }
    Sums sums;
    const local::Outcome outcome = local::advance(arriving(law, speed), &sums);
    const double given_back = 0.5 * force * force / of.stiffness;
    EXPECT_NEAR(outcome.largest[0], depth, 1e-14) << speed;
    EXPECT_NEAR(outcome.velocity / kStep, std::sqrt(2.0 * given_back / kMass), 1e-12) << speed;
    EXPECT_NEAR(kMass * sums.damped() / (kStep * kStep), energy - given_back, 1e-12 * energy) << speed;
    EXPECT_NEAR(law.force({.compression = 0.9999 * depth, .rate = -1.0}, depth), force - of.stiffness * 1e-4 * depth,
                1e-9);
  }
}

/// Force against compression along a cycle, and the loss per cycle as its area.
TEST(LoadingCurve, TableGoesOnItsCurveAndBackOnItsSlope) {
  const LoadingCurve law{LoadingCurve::table({0.0, 1e-3, 3e-3, 4e-3}, {0.0, 500.0, 700.0, 1500.0}, 1e6)};
  const auto at = [&](double d, double rate, double largest) {
    return law.force({.compression = d, .rate = rate}, largest);
  };
  EXPECT_DOUBLE_EQ(at(0.5e-3, 1.0, 0.0), 250.0);
  EXPECT_DOUBLE_EQ(at(2e-3, 1.0, 0.0), 600.0);
  EXPECT_NEAR(at(5e-3, 1.0, 4e-3), 2300.0, 1e-9);
  EXPECT_NEAR(at(2.8e-3, -1.0, 3e-3), 500.0, 1e-9);
  EXPECT_EQ(at(2.2e-3, -1.0, 3e-3), 0.0);  // behind the set of 2.3 mm
  EXPECT_NEAR(at(2.8e-3, 1.0, 3e-3), 500.0, 1e-9);
  EXPECT_DOUBLE_EQ(law.permanent_set(3e-3), 2.3e-3);
  EXPECT_DOUBLE_EQ(law.compression_for(600.0), 2e-3);
  EXPECT_DOUBLE_EQ(law.stored(3e-3, 0.0), 0.5 * 700.0 * 700.0 / 1e6);
  // In and out from 3.5 mm: 0.25 + 1.2 + 0.45 J of work, 1100^2 / 2e6 of it comes back.
  const double work = 0.25 + 1.2 + 0.45;
  Sums sums;
  const local::Outcome outcome = local::advance(arriving(law, std::sqrt(2.0 * work / kMass)), &sums);
  EXPECT_NEAR(outcome.largest[0], 3.5e-3, 1e-15);
  EXPECT_NEAR(kMass * sums.damped() / (kStep * kStep), work - 0.605, 1e-13);
}

TEST(ContactLaws, RefuseWhatIsNoLaw) {
  EXPECT_THROW(PowerLaw({.stiffness = 0.0}), InputError);
  EXPECT_THROW(PowerLaw({.stiffness = 1.0, .exponent = 0.5}), InputError);
  EXPECT_THROW(PowerLaw({.stiffness = 1.0, .damping = -1.0}), InputError);
  EXPECT_THROW(LoadingCurve{LoadingCurve::bilinear(2.0, 1.0)}, InputError);
  EXPECT_THROW(LoadingCurve{LoadingCurve::bilinear(0.0, 1.0)}, InputError);
  EXPECT_THROW(static_cast<void>(LoadingCurve::crush({.stiffness = 1.0, .plateau = 1.0, .bottoming = 0.5})),
               InputError);
  EXPECT_THROW(static_cast<void>(LoadingCurve::crush(
                   {.stiffness = 1.0, .plateau = 1.0, .bottoming = 2.0, .bottoming_stiffness = 2.0})),
               InputError);
  EXPECT_THROW(LoadingCurve{LoadingCurve::table({0.0}, {0.0}, 1.0)}, InputError);
  EXPECT_THROW(LoadingCurve{LoadingCurve::table({0.0, 1.0}, {1.0, 2.0}, 9.0)}, InputError);
  EXPECT_THROW(LoadingCurve{LoadingCurve::table({0.0, 1.0, 0.5}, {0.0, 1.0, 2.0}, 9.0)}, InputError);
  EXPECT_THROW(LoadingCurve{LoadingCurve::table({0.0, 1.0, 2.0}, {0.0, 2.0, 1.0}, 9.0)}, InputError);
  EXPECT_THROW(LoadingCurve{LoadingCurve::table({0.0, 1.0}, {0.0, 2.0}, 1.0)}, InputError);
}

using Real = long double;
using Source = std::mt19937_64;

double uniform(Source& source, double from, double to) {
  return std::uniform_real_distribution<double>(from, to)(source);
}

std::size_t below(Source& source, std::size_t count) {
  return std::uniform_int_distribution<std::size_t>(0, count - 1)(source);
}

/// A law written down once more, in long double, with its own memory.
struct PlainLaw {
  bool curved = true;
  Real k = 0.0L;
  Real n = 1.0L;
  Real c = 0.0L;
  std::vector<double> compression;
  std::vector<double> force;
  Real last_slope = 0.0L;
  Real unloading = 0.0L;
  Real largest = 0.0L;

  [[nodiscard]] Real loading(Real d) const {
    std::size_t i = 0;
    while (i + 1 < compression.size() && d > compression[i + 1]) {
      ++i;
    }
    const Real slope = i + 1 < compression.size() ? (static_cast<Real>(force[i + 1]) - force[i]) /
                                                        (static_cast<Real>(compression[i + 1]) - compression[i])
                                                  : last_slope;
    return force[i] + slope * (d - compression[i]);
  }
  [[nodiscard]] Real operator()(Real d, Real rate) const {
    if (d <= 0.0L) {
      return 0.0L;
    }
    if (curved) {
      const Real power = n == 1.5L ? d * std::sqrt(d) : n == 1.0L ? d : std::pow(d, n);
      return k * power * std::max(0.0L, 1.0L + c * rate);
    }
    return d >= largest ? loading(d) : std::max(0.0L, loading(largest) - unloading * (largest - d));
  }
  /// What changes where f has a kink: below it one smooth formula holds.
  [[nodiscard]] int branch(Real d, Real rate) const {
    if (d <= 0.0L) {
      return 0;
    }
    if (curved) {
      return 1.0L + c * rate > 0.0L ? 1 : 2;
    }
    if (d < largest) {
      return loading(largest) - unloading * (largest - d) > 0.0L ? 1 : 0;
    }
    int piece = 2;
    for (std::size_t i = 1; i < compression.size(); ++i) {
      piece += d > compression[i] ? 1 : 0;
    }
    return rate >= 0.0L ? piece : 1;
  }
};

struct Drawn {
  local::Problem problem;
  std::array<PlainLaw, 2> plain;
  std::array<std::unique_ptr<ContactLaw>, 2> law;
  double scale = 0.0;
};

/// The reference: Dormand and Prince's fifth order with steps for 1e-13, cut where a law changes its formula.
class Reference {
 public:
  static constexpr std::size_t kSize = 2 + kMostTerms;  // place, speed, moments
  using State = std::array<Real, kSize>;

  explicit Reference(const Drawn& drawn) : problem_{&drawn.problem}, laws_{drawn.plain}, scale_{drawn.scale} {
    now_[1] = problem_->velocity;
    Real tau = 0.0L;
    Real step = 1e-4L;
    while (tau < 1.0L && steps_ < 400000) {
      ++steps_;
      step = std::min(step, 1.0L - tau);
      Real error = 0.0L;
      State next = advanced(tau, step, error);
      const Real factor = error > 0.0L ? 0.9L * std::pow(1.0L / error, 0.2L) : 5.0L;
      if (error > 1.0L) {
        step *= std::max(0.2L, factor);
        continue;
      }
      Real taken = step;
      if (changes(next, tau + step)) {
        taken = cut(tau, step, next);
      }
      tau += taken;
      now_ = next;
      remember(tau);
      step *= std::min(5.0L, factor);
    }
    for (std::size_t j = 0; j < problem_->terms; ++j) {
      now_[2 + j] *= static_cast<Real>(2 * j + 1);
    }
  }
  [[nodiscard]] const State& end() const { return now_; }
  [[nodiscard]] Real largest(std::size_t stop) const { return laws_.at(stop).largest; }
  [[nodiscard]] long steps() const { return steps_; }

 private:
  [[nodiscard]] Real compression(const State& at, std::size_t stop, Real tau) const {
    const local::Stop& support = problem_->stops.at(stop);
    const Real side = stop == 0 ? 1.0L : -1.0L;
    const Real place = static_cast<Real>(support.at) +
                       tau * (support.path[0] + tau * (support.path[1] + tau * static_cast<Real>(support.path[2])));
    return -side * (at[0] - place);
  }
  [[nodiscard]] Real rate(const State& at, std::size_t stop, Real tau) const {
    const local::Stop& support = problem_->stops.at(stop);
    const Real side = stop == 0 ? 1.0L : -1.0L;
    return -side * (at[1] - (support.path[0] +
                             tau * (2.0L * support.path[1] + 3.0L * tau * static_cast<Real>(support.path[2]))));
  }
  [[nodiscard]] State slope(const State& at, Real tau) const {
    State change{};
    Real line = 0.0L;
    for (std::size_t k = problem_->terms; k-- > 0;) {
      line = line * tau + problem_->line[k];
    }
    const Real w = problem_->angle;
    change[0] = at[1];
    change[1] = w * w * (line - at[0]) - problem_->drag * at[1];
    for (std::size_t stop = 0; stop < 2; ++stop) {
      if (problem_->stops.at(stop).present) {
        const Real side = stop == 0 ? 1.0L : -1.0L;
        change[1] += side * laws_.at(stop)(compression(at, stop, tau), rate(at, stop, tau));
      }
    }
    const Real x = 2.0L * tau - 1.0L;
    const std::array<Real, kMostTerms> legendre{1.0L, x, 0.5L * (3.0L * x * x - 1.0L), 0.5L * x * (5.0L * x * x - 3.0L),
                                                0.125L * ((35.0L * x * x - 30.0L) * x * x + 3.0L)};
    for (std::size_t j = 0; j < problem_->terms; ++j) {
      change[2 + j] = legendre.at(j) * at[0];
    }
    return change;
  }
  /// @param[out] error of the tolerance
  [[nodiscard]] State advanced(Real tau, Real h, Real& error) const {
    static constexpr std::array<std::array<Real, 6>, 6> a{
        {{1.0L / 5.0L},
         {3.0L / 40.0L, 9.0L / 40.0L},
         {44.0L / 45.0L, -56.0L / 15.0L, 32.0L / 9.0L},
         {19372.0L / 6561.0L, -25360.0L / 2187.0L, 64448.0L / 6561.0L, -212.0L / 729.0L},
         {9017.0L / 3168.0L, -355.0L / 33.0L, 46732.0L / 5247.0L, 49.0L / 176.0L, -5103.0L / 18656.0L},
         {35.0L / 384.0L, 0.0L, 500.0L / 1113.0L, 125.0L / 192.0L, -2187.0L / 6784.0L, 11.0L / 84.0L}}};
    static constexpr std::array<Real, 7> c{0.0L, 0.2L, 0.3L, 0.8L, 8.0L / 9.0L, 1.0L, 1.0L};
    static constexpr std::array<Real, 7> e{71.0L / 57600.0L,      0.0L,           -71.0L / 16695.0L, 71.0L / 1920.0L,
                                           -17253.0L / 339200.0L, 22.0L / 525.0L, -1.0L / 40.0L};
    std::array<State, 7> k{};
    State at = now_;
    k[0] = slope(now_, tau);
    for (std::size_t stage = 1; stage < 7; ++stage) {
      at = now_;
      for (std::size_t s = 0; s < stage; ++s) {
        for (std::size_t i = 0; i < kSize; ++i) {
          at[i] += h * a.at(stage - 1).at(s) * k.at(s)[i];
        }
      }
      k.at(stage) = slope(at, tau + c.at(stage) * h);
    }
    error = 0.0L;
    for (std::size_t i = 0; i < kSize; ++i) {
      Real sum = 0.0L;
      for (std::size_t s = 0; s < 7; ++s) {
        sum += h * e.at(s) * k.at(s)[i];
      }
      error = std::max(error, std::abs(sum) / (1e-13L * scale_));
    }
    return at;
  }
  [[nodiscard]] bool changes(const State& next, Real tau) const {
    for (std::size_t stop = 0; stop < 2; ++stop) {
      const PlainLaw& law = laws_.at(stop);
      if (problem_->stops.at(stop).present &&
          law.branch(compression(next, stop, tau), rate(next, stop, tau)) != branch_.at(stop)) {
        return true;
      }
    }
    return false;
  }
  /// Ends the step just behind the change.
  [[nodiscard]] Real cut(Real tau, Real step, State& next) const {
    Real low = 0.0L;
    Real high = step;
    Real error = 0.0L;
    for (int turn = 0; turn < 70 && high - low > 1e-18L; ++turn) {
      const Real middle = 0.5L * (low + high);
      const State there = advanced(tau, middle, error);
      (changes(there, tau + middle) ? high : low) = middle;
    }
    next = advanced(tau, high, error);
    return high;
  }
  void remember(Real tau) {
    for (std::size_t stop = 0; stop < 2; ++stop) {
      PlainLaw& law = laws_.at(stop);
      const Real d = compression(now_, stop, tau);
      if (!law.curved) {
        law.largest = std::max(law.largest, d);
      }
      branch_.at(stop) = law.branch(d, rate(now_, stop, tau));
    }
  }

  const local::Problem* problem_;
  std::array<PlainLaw, 2> laws_;
  Real scale_;
  State now_{};
  std::array<int, 2> branch_{-1, -1};
  long steps_ = 0;
};

/// @param length of the compression [m]; steps are 1 s, masses 1 kg
void draw_law(Source& source, double length, double speed, Drawn& drawn, std::size_t stop) {
  const double w = std::pow(10.0, uniform(source, -0.5, 2.0));
  PlainLaw& plain = drawn.plain.at(stop);
  local::Stop& support = drawn.problem.stops.at(stop);
  if (below(source, 2) == 0) {
    const std::size_t which = below(source, 4);
    plain.n = which == 0 ? 1.0 : which == 1 ? uniform(source, 1.0, 3.0) : 1.5;
    plain.k = static_cast<double>(w * w * std::pow(length, 1.0L - plain.n));
    plain.c = below(source, 3) == 0 ? 0.0 : std::pow(10.0, uniform(source, -2.0, 0.7)) / speed;
    drawn.law.at(stop) = std::make_unique<PowerLaw>(PowerLaw::Parameters{.stiffness = static_cast<double>(plain.k),
                                                                         .exponent = static_cast<double>(plain.n),
                                                                         .damping = static_cast<double>(plain.c)});
  } else {
    LoadingCurve::Parameters curve{.compression = {0.0}, .force = {0.0}};
    double steepest = 0.0;
    for (std::size_t i = 0; i < below(source, 4); ++i) {
      const double way = length * std::pow(10.0, uniform(source, -2.0, 0.0));
      const double slope = i > 0 && below(source, 3) == 0 ? 0.0 : w * w * uniform(source, i == 0 ? 0.1 : -0.2, 1.0);
      const double next = curve.force.back() + slope * way;
      curve.compression.push_back(curve.compression.back() + way);
      curve.force.push_back(next > 0.0 ? next : curve.force.back());
      steepest =
          std::max(steepest, (curve.force.back() - curve.force[i]) / (curve.compression.back() - curve.compression[i]));
    }
    curve.last_slope = w * w * uniform(source, 0.1, 1.0);
    steepest = std::max(steepest, curve.last_slope);
    curve.unloading = steepest * (below(source, 4) == 0 ? 1.0 : std::pow(10.0, uniform(source, 0.0, 1.5)));
    plain.curved = false;
    plain.compression = curve.compression;
    plain.force = curve.force;
    plain.last_slope = curve.last_slope;
    plain.unloading = curve.unloading;
    plain.largest = below(source, 2) == 0 ? 0.0 : length * std::pow(10.0, uniform(source, -2.0, 0.5));
    support.largest = static_cast<double>(plain.largest);
    drawn.law.at(stop) = std::make_unique<LoadingCurve>(curve);
  }
  support.contact_law = drawn.law.at(stop).get();
  support.carried = 1.0;
  support.step = 1.0;
  support.present = true;
}

Drawn draw(Source& source) {
  Drawn drawn;
  local::Problem& problem = drawn.problem;
  const double length = std::pow(10.0, uniform(source, -2.0, 0.0));
  const auto sign = [&source] { return below(source, 2) == 0 ? -1.0 : 1.0; };
  problem.hop_tolerance = 1e-10 * length;
  problem.together = 1e-15 * length;
  problem.pull_resolution = 1e-15 * length;
  problem.angle = uniform(source, 0.05, 1.5);
  problem.drag = below(source, 4) == 0 ? uniform(source, 0.0, 0.5) : 0.0;
  problem.powers = local::powers_for(problem.angle + problem.drag);
  problem.terms = 2 + below(source, kMostTerms - 1);
  problem.velocity = below(source, 6) == 0 ? 0.0 : sign() * length * std::pow(10.0, uniform(source, -3.0, 1.0));
  for (std::size_t k = 0; k < problem.terms; ++k) {
    problem.line[k] = sign() * length * std::pow(10.0, uniform(source, -2.0, 0.7));
  }
  drawn.scale = std::max(length, std::abs(problem.velocity));
  for (const double term : problem.line) {
    drawn.scale = std::max(drawn.scale, std::abs(term));
  }
  const std::size_t present = 1 + below(source, 3);
  for (std::size_t stop = 0; stop < 2; ++stop) {
    if (((present >> stop) & 1U) == 0) {
      continue;
    }
    local::Stop& support = problem.stops.at(stop);
    const double side = stop == 0 ? 1.0 : -1.0;
    draw_law(source, length * std::pow(10.0, uniform(source, -2.0, 0.0)), drawn.scale, drawn, stop);
    const std::size_t start = below(source, 4);  // off it, on it, in it
    support.at = start == 0 ? 0.0 : (start == 1 ? side : -side) * length * std::pow(10.0, uniform(source, -3.0, 0.3));
    if (present == 3) {
      support.at = -side * std::abs(support.at);
    }
    if (below(source, 4) == 0) {
      support.moves = true;
      for (double& power : support.path) {
        power = sign() * length * std::pow(10.0, uniform(source, -2.0, 0.0));
      }
    }
  }
  return drawn;
}

TEST(ContactLaws, FollowASlowReference) {
  constexpr int kProblems = 20000;
  constexpr int kMostTold = 5;
  Source source(20261130);
  double worst = 0.0;
  double worst_moment = 0.0;
  long steps = 0;
  int told = 0;
  int touched = 0;
  for (int i = 0; i < kProblems && told < kMostTold; ++i) {
    const Drawn drawn = draw(source);
    const local::Problem& problem = drawn.problem;
    Sums sums;
    const local::Outcome outcome = local::advance(problem, &sums);
    const Reference reference{drawn};
    steps += reference.steps();
    touched += sums.until() >= 0.0 ? 1 : 0;
    double error = std::max(std::abs(outcome.displacement - static_cast<double>(reference.end()[0])),
                            std::abs(outcome.velocity - static_cast<double>(reference.end()[1])));
    for (std::size_t stop = 0; stop < 2; ++stop) {
      const bool remembers = problem.stops.at(stop).present && problem.stops.at(stop).contact_law->remembers();
      error = std::max(
          error, remembers ? std::abs(outcome.largest.at(stop) - static_cast<double>(reference.largest(stop))) : 0.0);
    }
    double moment = 0.0;
    for (std::size_t j = 0; j < problem.terms; ++j) {
      moment = std::max(moment, std::abs(outcome.moments[j] - static_cast<double>(reference.end()[2 + j])));
    }
    worst = std::max(worst, error / drawn.scale);
    worst_moment = std::max(worst_moment, moment / drawn.scale);
    EXPECT_LE(error, 1e-9 * drawn.scale) << "problem " << i;
    EXPECT_LE(moment, 1e-9 * drawn.scale) << "problem " << i;
    if (error > 1e-9 * drawn.scale || moment > 1e-9 * drawn.scale) {
      ++told;
      std::printf("problem %d: error %.3g moment %.3g scale %.3g end %.17g reference %.17g\n", i, error, moment,
                  drawn.scale, outcome.displacement, static_cast<double>(reference.end()[0]));
    }
  }
  EXPECT_GT(touched, kProblems / 2);
  std::printf("%d touched; worst end %.2g, moment %.2g; %.0f reference steps each\n", touched, worst, worst_moment,
              static_cast<double>(steps) / kProblems);
}

TEST(ContactLaws, EndWhateverTheyAreGiven) {
  const PowerLaw curved{{.stiffness = 1e6, .damping = 0.1}};
  const LoadingCurve straight{LoadingCurve::bilinear(1e6, 2e6)};
  for (const ContactLaw* law : {static_cast<const ContactLaw*>(&curved), static_cast<const ContactLaw*>(&straight)}) {
    for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
      for (const double at : {0.0, 1e-3}) {
        local::Problem problem = arriving(*law);
        problem.angle = 1.0;
        problem.powers = local::powers_for(problem.angle);
        problem.stops[0].at = at;
        problem.line = {0.0, bad};
        EXPECT_FALSE(std::isfinite(local::advance(problem).displacement));
        problem.line = {};
        problem.velocity = bad;
        EXPECT_FALSE(std::isfinite(local::advance(problem).displacement));
      }
    }
  }
}

/// A mass that is at rest on a law where its forces balance stays there.
TEST(ContactLaws, KeepWhatRestsOnThem) {
  const PowerLaw curved{{.stiffness = 1e6, .damping = 0.1}};
  const LoadingCurve straight{LoadingCurve::bilinear(1e6, 2e6)};
  for (const ContactLaw* law : {static_cast<const ContactLaw*>(&curved), static_cast<const ContactLaw*>(&straight)}) {
    const double depth = law->compression_for(30.0);
    local::Problem problem = arriving(*law, 0.0);
    problem.angle = 1.0;
    problem.powers = local::powers_for(problem.angle);
    problem.stops[0].at = depth;
    problem.line = {-30.0 / kMass * kStep * kStep, 0.0};
    const local::Outcome outcome = local::advance(problem);
    EXPECT_NEAR(outcome.displacement, 0.0, 1e-15);
    EXPECT_NEAR(outcome.velocity, 0.0, 1e-13);
  }
}

/// With one slope for loading and unloading a curve is the linear spring.
TEST(ContactLaws, OneSlopeIsTheLinearSpring) {
  Source source(5);
  double worst = 0.0;
  for (int i = 0; i < 20000; ++i) {
    Drawn drawn = draw(source);
    local::Problem& problem = drawn.problem;
    local::Problem springs = problem;
    double scale = drawn.scale;
    std::array<std::unique_ptr<LoadingCurve>, 2> laws;
    for (std::size_t stop = 0; stop < 2; ++stop) {
      const double k = std::pow(10.0, uniform(source, -1.0, 4.0));
      const double way = std::pow(10.0, uniform(source, -3.0, 0.0));
      laws.at(stop) = std::make_unique<LoadingCurve>(
          i % 2 == 0 ? LoadingCurve::bilinear(k, k)
                     : LoadingCurve::table({0.0, way, 2.0 * way}, {0.0, k * way, 2.0 * k * way}, k));
      problem.stops.at(stop).contact_law = laws.at(stop).get();
      problem.stops.at(stop).largest = 0.0;
      springs.stops.at(stop).contact_law = nullptr;
      springs.stops.at(stop).stiffness = k;
      const double depth = (stop == 0 ? 1.0 : -1.0) * problem.stops.at(stop).at;  // it may be thrown out from there
      scale = std::max(scale, problem.stops.at(stop).present ? std::sqrt(k) * depth : 0.0);
    }
    Sums of_laws;
    Sums of_springs;
    const local::Outcome law = local::advance(problem, &of_laws);
    const local::Outcome spring = local::advance(springs, &of_springs);
    double error = std::max(std::abs(law.displacement - spring.displacement), std::abs(law.velocity - spring.velocity));
    for (std::size_t j = 0; j < problem.terms; ++j) {
      error = std::max(error, std::abs(law.moments[j] - spring.moments[j]));
    }
    for (std::size_t stop = 0; stop < 2; ++stop) {
      error = std::max(error, std::abs(of_laws.push(stop) - of_springs.push(stop)));
    }
    worst = std::max(worst, error / scale);
    EXPECT_LE(error, 1e-12 * scale) << "problem " << i;
  }
  std::printf("worst %.2g\n", worst);
}

}  // namespace
}  // namespace udar
