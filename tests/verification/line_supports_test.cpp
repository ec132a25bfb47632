// ranks: 1 2; size: medium
/// @file
/// Supports that move and supports that give way hold the line: closed forms, the integrators against each other, few
/// against many contact nodes.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <numbers>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "support/line_ways.hpp"
#include "support/steel_beam.hpp"
#include "support/world.hpp"

namespace udar {
namespace {

constexpr double kRigid = std::numeric_limits<double>::infinity();
using test::kImpact;
using test::kOnLine;
using test::kRk;
using test::Way;

class LineSupports : public test::LineTest {
 protected:
  [[nodiscard]] static bool is(const char* type) { return std::string_view{GetParam().integrator} == type; }

 private:
  test::Option tolerance_{"-ts_rtol", "1e-10"};
};
INSTANTIATE_TEST_SUITE_P(All, LineSupports, testing::ValuesIn(test::kWays), test::name_of);

/// Lifted, lowered, and back, with jumps of the acceleration.
std::shared_ptr<const SupportMotion> shaken() {
  return std::make_shared<SupportMotion>(std::vector<double>{0.0, 0.2, 0.4, 0.6},
                                         std::vector<double>{0.0, 0.02, -0.015, 0.0},
                                         std::vector<double>{0.0, -0.0375, -0.05, 0.0});
}

/// Under the whole beam.
Support table(double stiffness, std::shared_ptr<const SupportMotion> motion = nullptr) {
  Support support{.position = 5.0, .width = 10.0};
  support.motion = std::move(motion);
  support.stiffness = stiffness;
  return support;
}

/// A mass whose line lies flat on a support: the filter's spring and that of the support, one after the other. With the
/// face at s the line is at z, and y'' = W^2 (s - y - g / k).
struct Springs {
  double wf;
  double support;  // stiffness over the mass it carries [1/s^2]
  [[nodiscard]] double weakness() const { return 1.0 / support; }
  [[nodiscard]] double square() const { return 1.0 / (1.0 / (wf * wf) + weakness()); }
  [[nodiscard]] double push(double y, double s) const {
    return square() * (s - y + test::kGravity / (wf * wf));
  }  // over m
};

/// The exact motion of such a mass that starts at rest on the support, while that moves by one cubic after the other.
class Riding {
 public:
  Riding(const Springs& springs, const SupportMotion& motion) : springs_{springs}, motion_{&motion} {
    double y = motion.at(0.0).height;
    double v = 0.0;
    for (const double begin : motion.time()) {
      const SupportMotion::State s = motion.at(begin);
      const double jerk = jerk_after(begin);
      const double w2 = springs.square();
      const double w = std::sqrt(w2);
      pieces_.push_back({.begin = begin,
                         .cosine = y - (s.height - s.acceleration / w2 - test::kGravity * springs.weakness()),
                         .sine = (v - (s.velocity - jerk / w2)) / w,
                         .jerk = jerk});
      const double end = begin + 0.2;
      y = position(end);
      v = velocity(end);
    }
  }
  [[nodiscard]] double position(double t) const { return at(t)[0]; }
  [[nodiscard]] double velocity(double t) const { return at(t)[1]; }
  [[nodiscard]] double push(double t) const { return springs_.push(position(t), motion_->at(t).height); }
  /// What the support brings in per mass until t: Gauss-Legendre between the rows.
  [[nodiscard]] double work(double t) const {
    constexpr std::array<double, 2> kAt{0.5 - 0.5 / std::numbers::sqrt3, 0.5 + 0.5 / std::numbers::sqrt3};
    constexpr int kParts = 4000;
    double sum = 0.0;
    for (const Piece& piece : pieces_) {
      const double length = std::clamp(t - piece.begin, 0.0, 0.2);
      for (int part = 0; part < kParts; ++part) {
        for (const double at : kAt) {
          const double now = piece.begin + length * (part + at) / kParts;
          sum += 0.5 * length / kParts * push(now) * motion_->at(now).velocity;
        }
      }
    }
    return sum;
  }

 private:
  struct Piece {
    double begin;
    double cosine;
    double sine;
    double jerk;
  };
  [[nodiscard]] double jerk_after(double row) const {
    return (motion_->at(row + 0.01).acceleration - motion_->at(row).acceleration) / 0.01;
  }
  [[nodiscard]] std::array<double, 2> at(double t) const {
    const Piece* now = pieces_.data();
    for (const Piece& piece : pieces_) {
      now = piece.begin <= t - 1e-12 ? &piece : now;
    }
    const double w2 = springs_.square();
    const double w = std::sqrt(w2);
    const double angle = w * (t - now->begin);
    const SupportMotion::State s = motion_->at(t, now->begin);
    return {s.height - s.acceleration / w2 - test::kGravity * springs_.weakness() + now->cosine * std::cos(angle) +
                now->sine * std::sin(angle),
            s.velocity - now->jerk / w2 + w * (now->sine * std::cos(angle) - now->cosine * std::sin(angle))};
  }

  Springs springs_;
  const SupportMotion* motion_;
  std::vector<Piece> pieces_;
};

TEST_P(LineSupports, ABeamThatLiesOnAShakenTableIsADrivenOscillator) {
  const test::Option end{"-ts_max_time", "0.75"};
  for (const double support : {kRigid, 4000.0}) {
    const auto motion = shaken();
    const Springs springs{.wf = 40.0, .support = support};
    const Riding exact{springs, *motion};
    const BeamParameters beam = test::steel_beam(6);
    const double mass = beam.segments[0].mass_per_length * beam.segments[0].length;
    test::Fall fall{beam, springs.wf, test::kGravity, {.height = 0.0}, {table(support * mass, motion)}, on_line()};
    test::Recorder record{0.05};
    fall.dynamics.add_observer(record);
    fall.dynamics.solve();
    ASSERT_EQ(record.times.size(), 16U);
    for (std::size_t k = 0; k < record.times.size(); ++k) {
      const double t = record.times[k];
      ASSERT_GT(exact.push(t), 0.0) << "it never leaves the table";
      const double y = exact.position(t);
      for (const double position : record.positions[k]) {
        EXPECT_NEAR(position, y, 1e-9) << t;
      }
      // The line is where the spring of the support is pressed to, and what that holds is in the ledger.
      const double pressed = exact.push(t) * springs.weakness();
      for (const double line : record.lines[k]) {
        EXPECT_NEAR(line, motion->at(t).height - pressed, 1e-9) << t;
      }
      const EnergyLedger& energy = record.energies[k];
      EXPECT_NEAR(energy.support_springs, 0.5 * mass * exact.push(t) * pressed, 1e-6) << t << " [J]";
      // Steps end at the rows of the table, where both are far better than inside: there impact is by its order, and rk
      // by the parabola through three instants, which is Simpson's rule at the end. Scale of the ledger: some 10 J.
      const bool row = std::abs(t / 0.2 - std::round(t / 0.2)) < 1e-9;
      EXPECT_NEAR(energy.support_work, mass * exact.work(t), row ? 1e-6 : 5e-5) << t << " [J]";
      EXPECT_NEAR(energy.drift(), 0.0, row ? (is("rk") ? 5e-9 : 1e-10) : (is("rk") ? 2e-8 : 2e-6)) << t;
    }
    const double impulse = mass * (exact.velocity(0.75) + test::kGravity * 0.75);
    EXPECT_NEAR(fall.dynamics.support_impulses()[0], impulse, 1e-8 * impulse);
    EXPECT_GT(std::abs(record.energies.back().support_work), 1.0) << "[J]";
    EXPECT_NEAR(fall.dynamics.counts().last_contact_time, 0.75, 1e-12);
    EXPECT_EQ(fall.dynamics.counts().first_contact_time, 0.0);
    double deepest = 0.0;
    for (int k = 0; k <= 7500; ++k) {
      deepest = std::max(deepest, exact.push(1e-4 * k) * springs.weakness());
    }
    EXPECT_NEAR(fall.dynamics.smallest_line_gap().gap, -deepest, 0.01 * deepest + 1e-10) << "from the moving face";
  }
}

/// Falls flat on a table: the filter's spring and that of the table in series from the touch of the line to its lift.
TEST_P(LineSupports, AFlatFallOnASpringBouncesOnTwoSpringsInSeries) {
  const test::Option end{"-ts_max_time", "0.8"};
  const BeamParameters beam = test::steel_beam(6);
  const double mass = beam.segments[0].mass_per_length * beam.segments[0].length;
  for (const double support : {400.0, 2500.0, 1e6}) {
    const Springs springs{.wf = 50.0, .support = support};
    const double w = std::sqrt(springs.square());
    const double touch = test::kGravity / (springs.wf * springs.wf);  // of the line: the mass is so far above
    const double sag = test::kGravity / springs.square();             // of the mass from there, where it would rest
    const double speed = std::sqrt(2.0 * test::kGravity * (1.0 - touch));
    const double first = speed / test::kGravity;
    const double contact = 2.0 * (std::numbers::pi - std::atan(speed / (w * sag))) / w;
    ASSERT_LT(first + contact, 0.75);
    test::Fall fall{beam, springs.wf, test::kGravity, {.height = 1.0}, {table(support * mass)}, on_line()};
    test::Recorder record{0.01};
    fall.dynamics.add_observer(record);
    fall.dynamics.solve();
    for (std::size_t k = 0; k < record.times.size(); ++k) {
      const double t = record.times[k];
      const double since = t - first;
      double expected = 1.0 - 0.5 * test::kGravity * t * t;
      double pressed = 0.0;
      if (since > contact) {
        expected = touch + speed * (since - contact) - 0.5 * test::kGravity * std::pow(since - contact, 2);
      } else if (since > 0.0) {
        expected = touch - sag + sag * std::cos(w * since) - speed / w * std::sin(w * since);
        pressed = springs.push(expected, 0.0) / support;
      }
      for (const double position : record.positions[k]) {
        EXPECT_NEAR(position, expected, 3e-7) << "k " << support << ", t " << t;
      }
      EXPECT_NEAR(record.energies[k].support_springs, 0.5 * mass * support * pressed * pressed, 1e-5 * mass) << t;
      EXPECT_NEAR(record.energies[k].drift(), 0.0, 5e-7) << "k " << support << ", t " << t;  // most within a step
    }
    EXPECT_NEAR(record.energies.back().drift(), 0.0, 2e-8);
    // Known to half a step, or between two Gauss points.
    EXPECT_NEAR(fall.dynamics.counts().first_contact_time, first, 0.02 / springs.wf);
    EXPECT_NEAR(fall.dynamics.counts().last_contact_time, first + contact, 0.02 / springs.wf);
    const double impulse = mass * (2.0 * speed + test::kGravity * contact);
    EXPECT_NEAR(fall.dynamics.support_impulses()[0], impulse, 1e-6 * impulse);
    // The line goes as deep as the table gives way; seen at steps' ends or Gauss points.
    const double deepest = springs.push(touch - sag - std::hypot(sag, speed / w), 0.0) / support;
    EXPECT_NEAR(fall.dynamics.smallest_line_gap().gap, -deepest, 0.01 * deepest);
  }
}

/// A beam that presses flat on a table of spring k and damper c from the start: m y'' = -k y - c y' - m g as long as
/// the table pushes. The middle of a step keeps the energy of springs, whatever the step, and is of second order.
TEST(MoreauOnSprings, AFlatBeamOnASpringWithDamperIsAnOscillator) {
  const BeamParameters beam = test::steel_beam(6);
  const double mass = beam.segments[0].mass_per_length * beam.segments[0].length;
  constexpr double kEnd = 0.02;
  constexpr double kSpeed = -1.0;
  const double w = 100.0;
  for (const double ratio : {0.0, 0.1, 0.5}) {
    const double decay = ratio * w;
    const double swing = w * std::sqrt(1.0 - ratio * ratio);
    const double sag = test::kGravity / (w * w);
    const double exact = -sag + std::exp(-decay * kEnd) * (sag * std::cos(swing * kEnd) +
                                                           (kSpeed + decay * sag) / swing * std::sin(swing * kEnd));
    double before = 0.0;
    for (const double step : {1e-3, 5e-4, 2.5e-4}) {
      const test::Option end{"-ts_max_time", "0.02"};
      Support support = table(w * w * mass);
      support.damping = 2.0 * decay * mass;
      test::Fall fall{{.beam = beam,
                       .filter = test::unfiltered(step),
                       .gravity = test::kGravity,
                       .initial = {.height = 0.0, .velocity = kSpeed},
                       .supports = {support}}};
      test::Recorder record{2e-3};
      fall.dynamics.add_observer(record);
      fall.dynamics.solve();
      double damped = 0.0;
      for (const EnergyLedger& energy : record.energies) {
        EXPECT_NEAR(energy.drift(), 0.0, 1e-12);
        EXPECT_GE(energy.lost_in_dampers, damped);
        damped = energy.lost_in_dampers;
      }
      EXPECT_EQ(damped > 0.0, ratio > 0.0);
      const double error = std::abs(record.positions.back().front() - exact);
      if (before > 0.0) {
        EXPECT_NEAR(std::log2(before / error), 2.0, 0.05) << ratio;
      }
      before = error;
    }
    EXPECT_LT(before, 2e-6);
  }
}

/// From above it touches and leaves within a step each: the rebound is exact to the first order.
TEST(MoreauOnSprings, AFlatBeamReboundsFromASpring) {
  const BeamParameters beam = test::steel_beam(6);
  const double mass = beam.segments[0].mass_per_length * beam.segments[0].length;
  const double w = 100.0;
  const test::Option end{"-ts_max_time", "0.1"};
  for (const double step : {4e-4, 1e-4, 2.5e-5}) {
    test::Fall fall{{.beam = beam,
                     .filter = test::unfiltered(step),
                     .gravity = test::kGravity,
                     .initial = {.height = 0.01, .velocity = -1.0},
                     .supports = {table(w * w * mass)}}};
    test::Recorder record{1e-3};
    fall.dynamics.add_observer(record);
    fall.dynamics.solve();
    const double speed = std::hypot(1.0, std::sqrt(2.0 * test::kGravity * 0.01));
    const double touch = (speed - 1.0) / test::kGravity;
    const double sag = test::kGravity / (w * w);
    const double leave = touch + 2.0 * (std::numbers::pi - std::atan(speed / (w * sag))) / w;
    const double since = 0.1 - leave;
    ASSERT_GT(since, 0.0);
    const double exact = speed * since - 0.5 * test::kGravity * since * since;
    const double error = std::abs(record.positions.back().front() - exact);
    EXPECT_LT(error, 0.6 * step);
    EXPECT_LT(std::abs(record.energies.back().drift()), 30.0 * step);
  }
}

/// What the supports may do in a fall that is compared between ways to compute it.
std::vector<Support> moving_and_giving() {
  Support moving{.position = 2.0};
  moving.motion = shaken();
  Support giving{.position = 8.0, .width = 1.0};
  giving.stiffness = 2e6;
  Support both{.position = 5.0, .width = 0.5};
  both.motion = moving.motion;
  both.stiffness = 3e5;
  Support above{.position = 5.0, .height = 0.4, .side = SupportSide::above};
  above.stiffness = 1e6;
  return {moving, giving, both, above};
}

struct Ended {
  MassState masses;
  std::vector<double> impulses;
  double work = 0.0;
  double drift = 0.0;
};

Ended tilted_fall(const Way& way, const char* rtol, std::vector<Support> supports, double until = 0.9) {
  const test::Option type{"-ts_type", way.integrator};
  const test::Option tolerance{"-ts_rtol", rtol};
  const std::string end_time = std::to_string(until);
  const test::Option end{"-ts_max_time", end_time.c_str()};
  InitialState initial{.height = 0.3, .slope = 0.01, .velocity = 2.0};
  test::Fall fall{test::steel_beam(20), 60.0, test::kGravity, initial, std::move(supports), test::on_line(way.dense)};
  test::Recorder record{0.02};
  fall.dynamics.add_observer(record);
  fall.dynamics.solve();
  double momentum = (initial.velocity - test::kGravity * until) * fall.beam.total_mass();
  for (const double impulse : fall.dynamics.support_impulses()) {
    momentum += impulse;
  }
  EXPECT_NEAR(test::momentum_of(fall.line, fall.dynamics), momentum, 1e-4 * fall.beam.total_mass());
  EXPECT_GT(fall.dynamics.counts().first_contact_time, 0.0);
  return {.masses = fall.dynamics.masses(),
          .impulses = fall.dynamics.support_impulses(),
          .work = record.energies.back().support_work,
          .drift = record.largest_drift()};
}

double apart(const Ended& a, const Ended& b) {
  double most = 0.0;
  for (std::size_t i = 0; i < a.masses.position.size(); ++i) {
    most = std::max(most, std::abs(a.masses.position[i] - b.masses.position[i]));
  }
  MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_DOUBLE, MPI_MAX, PETSC_COMM_WORLD);
  return most;
}

TEST(LineSupportsOfAllKinds, ImpactAndRkAgreeAndKeepTheLedger) {
  const Ended by_rk = tilted_fall(kRk, "1e-10", moving_and_giving());
  const Ended by_impact = tilted_fall(kImpact, "1e-10", moving_and_giving());
  EXPECT_LT(apart(by_rk, by_impact), 1e-6) << "[m]";
  EXPECT_LT(by_rk.drift, 1e-7);
  EXPECT_LT(by_impact.drift, 1e-7);
  EXPECT_NEAR(by_rk.work, by_impact.work, 1e-6 * std::abs(by_rk.work));
  EXPECT_GT(std::abs(by_rk.work), 1.0) << "[J]";
  for (const double impulse : by_rk.impulses) {
    EXPECT_GT(std::abs(impulse), 1.0) << "every support is met [N s]";
  }
}

TEST(LineSupportsOfAllKinds, FewAndManyContactNodesFallAlike) {
  Support floor = Support::floor(0.0, 1.0);
  floor.motion = shaken();
  floor.stiffness = 2e6;
  for (const char* integrator : {"rk", "impact"}) {
    const Ended few = tilted_fall({.integrator = integrator, .dense = 100}, "1e-8", {floor}, 0.7);
    const Ended many = tilted_fall({.integrator = integrator, .dense = 0}, "1e-8", {floor}, 0.7);
    EXPECT_LT(apart(few, many), 1e-6) << integrator << " [m]";
    EXPECT_NEAR(few.work, many.work, 1e-5 * std::abs(few.work)) << integrator;
    EXPECT_GT(std::abs(few.work), 1.0) << integrator << " [J]";
    EXPECT_LT(many.drift, 1e-5) << integrator;
  }
}

TEST(LineSupportsOfAllKinds, TimesOfContactAreThoseOfTheLine) {
  const test::Option type{"-ts_type", "rk"};
  const test::Option adapt{"-ts_adapt_type", "none"};
  const test::Option step{"-ts_dt", "0.007"};
  const test::Option end{"-ts_max_time", "0.6"};
  std::array<RunCounts, 2> counts;
  for (std::size_t k = 0; k < counts.size(); ++k) {
    test::Fall fall{
        test::steel_beam(6), 40.0, test::kGravity, {.height = 0.3}, {table(k == 0 ? kRigid : 1e16)}, kOnLine};
    fall.dynamics.solve();
    counts[k] = fall.dynamics.counts();
  }
  EXPECT_GT(counts[0].first_contact_time, 0.2);
  EXPECT_NEAR(counts[0].first_contact_time, counts[1].first_contact_time, 1e-12);
  EXPECT_NEAR(counts[0].last_contact_time, counts[1].last_contact_time, 1e-12);
}

TEST(LineSupportsOfAllKinds, EverStifferSpringsAreRigidInTheEnd) {
  const auto fall = [](double stiffness) {
    Support left{.position = 2.0};
    Support right{.position = 8.0, .width = 1.0};
    left.stiffness = stiffness;
    right.stiffness = stiffness;
    return tilted_fall(kRk, "1e-10", {left, right}, 0.7);
  };
  const Ended rigid = fall(kRigid);
  double before = 0.0;
  for (const double stiffness : {1e9, 1e10, 1e11}) {
    const double off = apart(fall(stiffness), rigid);
    if (before > 0.0) {
      EXPECT_NEAR(before / off, 10.0, 1.0) << "as the compliance";
    }
    before = off;
  }
  EXPECT_LT(apart(fall(1e16), rigid), 1e-8) << "[m], the adapted steps are others";
}

/// The unfiltered beam under a load that jumps within steps: the force's impulse, and the work it does, are those of
/// the table. A rigid bar of one element falls by them as a ball does.
TEST(Moreau, ALoadMayJumpWithinAStep) {
  const test::Option end{"-ts_max_time", "1"};
  const NodalLoad pulse{.position = 5.0,
                        .table = time_table({0.1234, 0.1234, 0.4567, 0.4567}, {0.0, 3000.0, 3000.0, 0.0})};
  test::Fall bar{{.beam = test::steel_beam(8),
                  .filter = test::unfiltered(0.01),
                  .gravity = 0.0,
                  .loads = {pulse},
                  .initial = {.height = 1.0, .velocity = 0.5}}};
  test::Recorder record{0.1};
  bar.dynamics.add_observer(record);
  bar.dynamics.solve();
  const double before = 0.5 * bar.beam.total_mass();
  const double impulse = 3000.0 * (0.4567 - 0.1234);
  EXPECT_NEAR(test::momentum_of(bar.line, bar.dynamics), before + impulse, 1e-11 * impulse);
  EXPECT_LT(record.largest_drift(), 1e-11);
}

/// The unfiltered beam on a table that moves: Newton's law and energy of the relative velocity.
TEST(MoreauOnMovingSupports, ABeamRidesOnAShakenTable) {
  const double until = 0.75;
  const auto motion = shaken();
  const double mass = BeamChain{PETSC_COMM_WORLD, test::steel_beam(6)}.total_mass();
  double worst_before = 0.0;
  for (const double step : {1e-3, 5e-4}) {
    const test::Option end{"-ts_max_time", "0.75"};
    Support support = table(kRigid, motion);
    support.restitution = 0.0;
    test::Fall ride{{.beam = test::steel_beam(6),
                     .filter = test::unfiltered(step),
                     .gravity = test::kGravity,
                     .initial = {.height = 0.0},
                     .supports = {support}}};
    ImpactDynamics& dynamics = ride.dynamics;
    test::Recorder record{0.05};
    dynamics.add_observer(record);
    dynamics.solve();
    double worst = 0.0;
    for (std::size_t k = 0; k < record.times.size(); ++k) {
      const double t = record.times[k];
      for (const double position : record.positions[k]) {
        worst = std::max(worst, std::abs(position - motion->at(t).height));
      }
      EXPECT_NEAR(record.energies[k].drift(), 0.0, 1e-10) << t << ", exact but for round-off";
      // m (g + s'') s' in all.
      const SupportMotion::State s = motion->at(t);
      const double work = mass * (test::kGravity * s.height + 0.5 * s.velocity * s.velocity);
      EXPECT_NEAR(record.energies[k].support_work, work, 30.0 * step * mass * test::kGravity * 0.02) << t << " [J]";
    }
    EXPECT_LT(worst, 20.0 * step * step) << "some s'' h^2 [m]";
    if (worst_before > 0.0) {
      EXPECT_NEAR(worst_before / worst, 4.0, 0.2) << "second order while nothing hits";
    }
    worst_before = worst;
    EXPECT_NEAR(dynamics.support_impulses()[0], mass * test::kGravity * until, 1e-3 * mass);
    EXPECT_LT(dynamics.energy().lost_in_impacts, 0.5 * (step / 1e-3)) << "[J]: it does not fall on the table";
  }
}

TEST(MoreauOnMovingSupports, TheRelativeVelocityTurnsRound) {
  // A table that rises evenly meets a flat beam: v+ = s' - e (v- - s'); the motion of a beam that lies on it is above.
  for (const double e : {1.0, 0.4, 0.0}) {
    const double step = 1e-4;
    const double rise = 2.0;
    const test::Option end{"-ts_max_time", "0.3"};
    Support support =
        table(kRigid, std::make_shared<SupportMotion>(std::vector<double>{0.0, 1.0}, std::vector<double>{0.0, rise},
                                                      std::vector<double>{rise, rise}));
    support.restitution = e;
    test::Fall chase{{.beam = test::steel_beam(6),
                      .filter = test::unfiltered(step),
                      .gravity = 0.0,
                      .initial = {.height = 0.2, .velocity = 0.5},  // it runs away, and is caught up with
                      .supports = {support}}};
    ImpactDynamics& dynamics = chase.dynamics;
    test::Recorder record{0.05};
    dynamics.add_observer(record);
    dynamics.solve();
    EXPECT_NEAR(dynamics.counts().first_contact_time, 0.2 / 1.5, 2.0 * step);
    if (e > 0.0) {  // else masses stay, and by rounding some move towards the table
      EXPECT_EQ(dynamics.counts().impacts, 7) << "every mass is hit once, from behind";
    }
    const double after = rise + e * 1.5;
    const double mass = chase.beam.total_mass();
    for (const double v : dynamics.masses().velocity) {
      EXPECT_NEAR(v, after, 1e-9);
    }
    EXPECT_NEAR(dynamics.support_impulses()[0], mass * (after - 0.5), 1e-9 * mass);
    EXPECT_NEAR(record.energies.back().support_work, mass * (after - 0.5) * rise, 1e-9 * mass);
    EXPECT_NEAR(record.energies.back().lost_in_impacts, 0.5 * mass * 2.25 * (1.0 - e * e), 1e-9 * mass);
    EXPECT_LT(record.largest_drift(), 1e-12);
  }
}

}  // namespace
}  // namespace udar
