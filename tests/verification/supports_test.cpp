// ranks: 1 2 3; size: medium
/// @file
/// Supports of all kinds against closed forms, by every integrator that knows them. Most tests let balls bounce: the
/// two masses of a beam of one element, which has no bending, move each by itself.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <functional>
#include <limits>
#include <memory>
#include <numbers>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "support/dense.hpp"
#include "support/steel_beam.hpp"
#include "support/world.hpp"

namespace udar {
namespace {

/// Every test runs with `-ts_type` rk and impact, those of rigid supports at rest with chebyshev, too.
class OnSupports : public testing::TestWithParam<const char*> {
 protected:
  [[nodiscard]] static bool is(const char* type) { return std::string_view{GetParam()} == type; }
  /// The impact integrator is of finite order: asked for 1e-9 in every step, some hundred steps make 1e-7 of it.
  [[nodiscard]] static double within(double exact) { return is("impact") ? std::max(exact, 1e-7) : exact; }

 private:
  test::Option type_{"-ts_type", GetParam()};
  test::Option tolerance_{"-ts_rtol", is("rk") ? "1e-10" : is("impact") ? "1e-9" : "1e-14"};
};
class OnRigidSupports : public OnSupports {};

const auto kName = [](const auto& tested) { return std::string{tested.param}; };
INSTANTIATE_TEST_SUITE_P(All, OnSupports, testing::Values("rk", "impact"), kName);
INSTANTIATE_TEST_SUITE_P(All, OnRigidSupports, testing::Values("rk", "chebyshev", "impact"), kName);

/// Twelve balls: nodes 0 and 1 at x = 0 and 1 m, 2 and 3 at 2 and 3 m, ...
BeamParameters balls() {
  BeamParameters beam;
  for (int k = 0; k < 6; ++k) {
    if (k > 0) {
      beam.segments.push_back({.length = 1.0, .elements = 1});
    }
    beam.segments.push_back({.length = 1.0, .elements = 1, .bending_stiffness = 1e6, .mass_per_length = 2.0});
  }
  return beam;
}
constexpr double kBall = 1.0;  // kg

/// The impacts of every ball, in order; null of those of other ranks.
std::vector<std::vector<ImpactRecord>> by_ball(const std::vector<ImpactRecord>& impacts) {
  std::vector<std::vector<ImpactRecord>> sorted(12);
  for (const ImpactRecord& hit : impacts) {
    sorted[static_cast<std::size_t>(hit.node)].push_back(hit);
  }
  return sorted;
}

TEST_P(OnRigidSupports, BallsFallAsDeepAsTheGroundIs) {
  const test::Option end{"-ts_max_time", "0.9"};
  Support ground = Support::floor(0.0, 0.6);
  ground.profile = {.x = {1.0, 4.5, 5.0, 9.0}, .height = {0.1, -0.25, 0.3, 0.3}};
  test::Fall fall{balls(), 80.0, test::kGravity, {.height = 1.0}, {ground}};
  test::Recorder record;
  fall.dynamics.add_observer(record);
  fall.dynamics.solve();
  const std::array<double, 12> heights{0.1, 0.1, 0.0, -0.1, -0.2, 0.3, 0.3, 0.3, 0.3, 0.3, 0.3, 0.3};
  const auto hits = by_ball(record.impacts);
  for (PetscInt node = fall.beam.begin(); node < fall.beam.end(); ++node) {
    const auto ball = static_cast<std::size_t>(node);
    const double t0 = std::sqrt(2.0 * (1.0 - heights[ball]) / test::kGravity);
    ASSERT_FALSE(hits[ball].empty()) << node;
    EXPECT_NEAR(hits[ball][0].time, t0, within(1e-10)) << node;
    EXPECT_NEAR(hits[ball][0].velocity_before, -test::kGravity * t0, within(1e-9)) << node;
    if (2.2 * t0 < 0.9) {
      ASSERT_GE(hits[ball].size(), 2U) << node;
      EXPECT_NEAR(hits[ball][1].time, 2.2 * t0, within(1e-10)) << node;
    }
  }
}

TEST_P(OnRigidSupports, BallsAboveTheYieldSpeedLoseMore) {
  const test::Option end{"-ts_max_time", "1.8"};
  Support floor = Support::floor(0.0, 0.8);
  floor.yield_speed = 2.0;
  InitialState initial{.height = 0.6};
  initial.shape = {.x = {0.0, 11.0}, .offset = {0.0, 1.1}, .velocity = {}};  // speeds from 3.4 to 5.8 m/s
  test::Fall fall{balls(), 80.0, test::kGravity, initial, {floor}};
  test::Recorder record{1.8};
  fall.dynamics.add_observer(record);
  fall.dynamics.solve();
  const auto hits = by_ball(record.impacts);
  for (PetscInt node = fall.beam.begin(); node < fall.beam.end(); ++node) {
    const double height = 0.6 + 0.1 * fall.beam.position(node);
    double speed = std::sqrt(2.0 * test::kGravity * height);
    double time = speed / test::kGravity;
    ASSERT_GE(hits[static_cast<std::size_t>(node)].size(), 2U);
    for (const ImpactRecord& hit : hits[static_cast<std::size_t>(node)]) {
      const double e = speed > 2.0 ? 0.8 * std::pow(speed / 2.0, -0.25) : 0.8;
      EXPECT_NEAR(hit.time, time, within(1e-9)) << node;
      EXPECT_NEAR(hit.velocity_after, e * speed, 10.0 * within(1e-9)) << node;
      EXPECT_NEAR(hit.energy_loss, 0.5 * kBall * speed * speed * (1.0 - e * e), 10.0 * within(1e-9)) << node;
      speed *= e;
      time += 2.0 * speed / test::kGravity;
    }
  }
  EXPECT_LT(std::abs(record.energies.back().drift()), within(1e-9));
}

/// Two masses in a channel: closed form from stop to stop.
TEST_P(OnRigidSupports, BallsBounceBetweenFloorAndCeiling) {
  const test::Option end{"-ts_max_time", "1.6"};
  Support ceiling = Support::floor(1.0, 0.7);
  ceiling.side = SupportSide::above;
  InitialState initial{.height = 0.5, .velocity = 6.0};
  initial.shape = {.x = {0.0, 11.0}, .offset = {-0.2, 0.2}, .velocity = {-1.0, 1.0}};
  test::Fall fall{balls(), 40.0, test::kGravity, initial, {Support::floor(0.0, 0.9), ceiling}};
  test::Recorder record{1.6};
  fall.dynamics.add_observer(record);
  fall.dynamics.solve();
  const auto hits = by_ball(record.impacts);
  for (PetscInt node = fall.beam.begin(); node < fall.beam.end(); ++node) {
    double place = 0.3 + 0.4 * fall.beam.position(node) / 11.0;
    double speed = 5.0 + 2.0 * fall.beam.position(node) / 11.0;
    double time = 0.0;
    ASSERT_GE(hits[static_cast<std::size_t>(node)].size(), 4U);
    for (const ImpactRecord& hit : hits[static_cast<std::size_t>(node)]) {
      const double above = speed * speed - 2.0 * test::kGravity * (1.0 - place);
      const bool up = speed > 0.0 && above > 0.0;
      const double arrived = up ? std::sqrt(above) : -std::sqrt(speed * speed + 2.0 * test::kGravity * place);
      time += (speed - arrived) / test::kGravity;
      EXPECT_NEAR(hit.time, time, within(1e-9)) << node;
      EXPECT_EQ(hit.support, up ? 1 : 0) << node;
      // The squares: where a ball just reaches the ceiling its last speed is all error.
      EXPECT_NEAR(std::abs(hit.velocity_before) * hit.velocity_before, std::abs(arrived) * arrived,
                  10.0 * within(1e-9));
      speed = -(up ? 0.7 : 0.9) * arrived;
      place = up ? 1.0 : 0.0;
    }
  }
  EXPECT_LT(std::abs(record.energies.back().drift()), within(1e-9));
}

/// First zero of a function that is positive at `from`, by bisection after a search with small strides.
double first_root(const std::function<double(double)>& f, double from, double until) {
  const double stride = (until - from) / 4096.0;
  double low = from;
  while (low < until && f(low + stride) > 0.0) {
    low += stride;
  }
  double high = low + stride;
  for (int k = 0; k < 200; ++k) {
    const double middle = 0.5 * (low + high);
    (f(middle) > 0.0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

Support table(std::vector<double> time, std::vector<double> height, std::vector<double> velocity, double e) {
  Support support{.position = 5.5, .width = 11.0, .restitution = e};
  support.motion = std::make_shared<SupportMotion>(std::move(time), std::move(height), std::move(velocity));
  return support;
}

/// A ball on a table that goes up and down: it may bounce once a period, leaving with g T / 2, where the table moves
/// with (g T / 2) (1 - e) / (1 + e) (Holmes, J. Sound Vib. 84 (1982) 173).
TEST_P(OnSupports, BallOnAVibratingTableKeepsItsPeriod) {
  const test::Option end{"-ts_max_time", "1.3"};
  constexpr double kRestitution = 0.6;
  constexpr double kPeriod = 0.2;
  constexpr double kAmplitude = 0.009;
  constexpr int kRows = 200;  // per period: off the sine by (2 pi / 200)^4 / 384 of its amplitude
  const double speed = 0.5 * test::kGravity * kPeriod;
  const double w = 2.0 * std::numbers::pi / kPeriod;
  const double phase = std::acos(speed * (1.0 - kRestitution) / (1.0 + kRestitution) / (kAmplitude * w));
  std::vector<double> time;
  std::vector<double> height;
  std::vector<double> velocity;
  for (int k = 0; k <= 7 * kRows; ++k) {
    time.push_back(kPeriod * k / kRows);
    height.push_back(kAmplitude * std::sin(w * time.back() + phase));
    velocity.push_back(kAmplitude * w * std::cos(w * time.back() + phase));
  }
  const InitialState initial{.height = height.front(), .velocity = speed};
  test::Fall fall{balls(), 80.0, test::kGravity, initial, {table(time, height, velocity, kRestitution)}};
  test::Recorder record{0.05};
  fall.dynamics.add_observer(record);
  fall.dynamics.solve();
  const auto hits = by_ball(record.impacts);
  for (PetscInt node = fall.beam.begin(); node < fall.beam.end(); ++node) {
    ASSERT_EQ(hits[static_cast<std::size_t>(node)].size(), 6U);
    for (std::size_t k = 0; k < 6; ++k) {
      const ImpactRecord& hit = hits[static_cast<std::size_t>(node)][k];
      EXPECT_NEAR(hit.time, kPeriod * static_cast<double>(k + 1), within(1e-8));
      EXPECT_NEAR(hit.velocity_before, -speed, within(1e-7));
      EXPECT_NEAR(hit.velocity_after, speed, within(1e-7));
      EXPECT_NEAR(hit.impulse, 2.0 * speed * kBall, within(1e-7));
    }
  }
  for (std::size_t k = 0; k < record.times.size(); ++k) {
    EXPECT_LT(std::abs(record.energies[k].drift()), within(1e-9)) << record.times[k];
  }
  // What restitution takes every time, the table brings.
  const double table_speed = kAmplitude * w * std::cos(phase);
  EXPECT_NEAR(record.energies.back().support_work, 12.0 * 6.0 * 2.0 * speed * kBall * table_speed,
              100.0 * within(1e-7));
}

/// A table that rises evenly meets balls that rise, too.
/// Supports throw a beam that nothing else moves: by micrometres as by metres.
TEST_P(OnSupports, MotionIsInProportionToThatOfTheSupports) {
  const test::Option end{"-ts_max_time", "0.15"};
  const auto positions = [](double size) {
    std::vector<Support> supports;
    for (const double x : {2.0, 8.0}) {
      supports.push_back({.position = x, .restitution = 0.5});
      supports.back().motion = std::make_shared<SupportMotion>(std::vector<double>{0.0, 0.03, 0.08, 0.2},
                                                               std::vector<double>{0.0, size, 0.3 * size, 0.0});
    }
    test::Fall fall{test::steel_beam(10), 100.0, 0.0, {.height = 0.5 * size}, supports};
    test::Recorder record{0.03};
    fall.dynamics.add_observer(record);
    fall.dynamics.solve();
    EXPECT_GT(fall.dynamics.counts().impacts, 0);
    return record.positions;
  };
  const auto large = positions(1.0);
  const auto small = positions(1e-6);
  for (std::size_t k = 0; k < large.size(); ++k) {
    for (std::size_t i = 0; i < large[k].size(); ++i) {
      EXPECT_NEAR(1e6 * small[k][i], large[k][i], within(1e-8));
    }
  }
}

TEST_P(OnSupports, BallsThatATableCatchesUpWithAreHit) {
  const test::Option end{"-ts_max_time", "0.3"};
  test::Fall fall{
      balls(), 80.0, 0.0, {.height = 0.2, .velocity = 0.5}, {table({0.0, 1.0}, {0.0, 2.0}, {2.0, 2.0}, 0.5)}};
  test::Recorder record{0.3};
  fall.dynamics.add_observer(record);
  fall.dynamics.solve();
  EXPECT_EQ(fall.dynamics.counts().impacts, 12);
  EXPECT_EQ(record.impacts.size(), static_cast<std::size_t>(fall.beam.local_nodes()));
  for (const ImpactRecord& hit : record.impacts) {
    EXPECT_NEAR(hit.time, 0.2 / 1.5, within(1e-10));
    EXPECT_NEAR(hit.velocity_before, 0.5, within(1e-10));
    EXPECT_NEAR(hit.velocity_after, 2.75, within(1e-10));
    EXPECT_NEAR(hit.energy_loss, 0.5 * kBall * 2.25 * 0.75, within(1e-9));
  }
  EXPECT_LT(std::abs(record.energies.back().drift()), within(1e-9));
}

/// A table of one cubic: a ball falls on it, sticks, rides on it and flies off where it falls faster than the ball.
TEST_P(OnSupports, BallRidesOnATableAndFliesOff) {
  const test::Option end{"-ts_max_time", "1.0"};
  // s = 3 t^2 - 4 t^3 in the first second: s'' = 6 - 24 t = -g at t = (6 + g) / 24 = 0.66 s; then at rest.
  const double flies = (6.0 + test::kGravity) / 24.0;
  const auto s = [](double t) { return t * t * (3.0 - 4.0 * t); };
  const auto rate = [](double t) { return t * (6.0 - 12.0 * t); };
  test::Fall fall{balls(), 80.0, test::kGravity, {.height = 0.4}, {table({0.0, 1.0}, {0.0, -1.0}, {0.0, -6.0}, 0.0)}};
  test::Recorder record{0.04};
  fall.dynamics.add_observer(record);
  fall.dynamics.solve();
  const double lands = first_root([&](double t) { return 0.4 - 0.5 * test::kGravity * t * t - s(t); }, 0.0, 1.0);
  ASSERT_LT(lands, flies);
  for (const ImpactRecord& hit : record.impacts) {
    EXPECT_NEAR(hit.time, lands, within(1e-11));
    EXPECT_NEAR(hit.velocity_after, rate(lands), within(1e-10));
  }
  const auto balls_here = static_cast<std::size_t>(fall.beam.local_nodes());
  ASSERT_EQ(record.rests.size(), 2 * balls_here);
  for (const RestRecord& rest : record.rests) {
    // The pull is wf^2 = 6400 times a stretch known to 1e-8 m, and changes by 24 m/s^3.
    EXPECT_NEAR(rest.time, rest.release ? flies : lands, rest.release ? 30.0 * within(1e-10) : within(1e-10));
  }
  for (std::size_t k = 0; k < record.times.size(); ++k) {
    const double t = record.times[k];
    const double after = t - flies;
    const double expected = t < lands   ? 0.4 - 0.5 * test::kGravity * t * t
                            : after < 0 ? s(t)
                                        : s(flies) + rate(flies) * after - 0.5 * test::kGravity * after * after;
    for (const double position : record.positions[k]) {
      EXPECT_NEAR(position, expected, within(1e-11)) << t;
    }
    EXPECT_LT(std::abs(record.energies[k].drift()), within(1e-10)) << t;
  }
  const double lost = 0.5 * std::pow(rate(lands) + test::kGravity * lands, 2);
  EXPECT_NEAR(record.energies.back().lost_in_impacts, 12.0 * kBall * lost, 100.0 * within(1e-10));
}

Support spring(double stiffness, double damping) {
  Support support{.position = 5.5, .width = 11.0};
  support.stiffness = stiffness;
  support.damping = damping;
  return support;
}

/// A ball falls on a spring with damper: m g'' = -m gravity - k g - c g' until that force would pull.
TEST_P(OnSupports, BallOnASpringFollowsTheClosedForm) {
  const test::Option end{"-ts_max_time", "1.0"};
  for (const auto& [stiffness, ratio] : {std::pair{400.0, 0.0}, {4e4, 0.0}, {400.0, 0.3}, {4e4, 0.3}}) {
    const double w = std::sqrt(stiffness);  // of each ball of 1 kg
    const double decay = ratio * w;
    const double turn = std::sqrt(w * w - decay * decay);
    const double hits = std::sqrt(2.0 * 0.5 / test::kGravity);
    const double arrives = -test::kGravity * hits;
    // Gap t after the touch: about the static -g / w^2.
    const double sine = (arrives + decay * test::kGravity / (w * w)) / turn;
    const auto gap = [&](double t) {
      return -test::kGravity / (w * w) +
             std::exp(-decay * t) * (test::kGravity / (w * w) * std::cos(turn * t) + sine * std::sin(turn * t));
    };
    const auto rate = [&](double t) {
      return std::exp(-decay * t) * ((turn * sine - decay * test::kGravity / (w * w)) * std::cos(turn * t) -
                                     (turn * test::kGravity / (w * w) + decay * sine) * std::sin(turn * t));
    };
    const double touch = first_root([&](double t) { return -w * w * gap(t) - 2.0 * decay * rate(t); }, 1e-9 / w,
                                    2.0 * std::numbers::pi / w);
    test::Fall fall{balls(), 80.0, test::kGravity, {.height = 0.5}, {spring(12.0 * stiffness, 12.0 * 2.0 * decay)}};
    test::Recorder record{0.01};
    fall.dynamics.add_observer(record);
    fall.dynamics.solve();
    std::size_t in_contact = 0;
    for (std::size_t k = 0; k < record.times.size(); ++k) {
      const double t = record.times[k];
      const double since = t - hits - touch;
      if (since > rate(touch) / test::kGravity) {
        break;  // it falls again
      }
      const double expected = t < hits      ? 0.5 - 0.5 * test::kGravity * t * t
                              : since < 0.0 ? gap(t - hits)
                                            : gap(touch) + rate(touch) * since - 0.5 * test::kGravity * since * since;
      in_contact += t > hits && since < 0.0 ? 1 : 0;
      for (const double position : record.positions[k]) {
        EXPECT_NEAR(position, expected, within(1e-9)) << "k " << stiffness << ", zeta " << ratio << ", t " << t;
      }
      EXPECT_LT(std::abs(record.energies[k].drift()), within(1e-9))
          << "k " << stiffness << ", zeta " << ratio << ", t " << t;
    }
    EXPECT_GE(in_contact, stiffness < 1e3 ? 10U : 1U);
    EXPECT_NEAR(fall.dynamics.counts().first_contact_time, hits, within(1e-9));
  }
}

std::shared_ptr<const SupportMotion> swung() {
  return std::make_shared<SupportMotion>(std::vector<double>{0.0, 0.3, 0.5, 0.7, 0.9},
                                         std::vector<double>{0.0, 0.1, -0.1, 0.05, 0.0});
}

TEST_P(OnSupports, BeamOnMovingAndGivingSupportsKeepsTheLedger) {
  const test::Option end{"-ts_max_time", "0.8"};
  Support moving{.position = 2.0, .width = 1.0, .restitution = 0.5};
  moving.motion = swung();
  Support giving{.position = 8.0, .width = 1.0};
  giving.stiffness = 1e6;
  giving.damping = 1e3;
  Support both{.position = 5.0, .width = 0.5, .height = -0.1};
  both.motion = moving.motion;
  both.stiffness = 1e5;
  test::Fall fall{test::steel_beam(40), 100.0, test::kGravity, {.height = 0.6}, {moving, giving, both}};
  test::Recorder record{0.02};
  fall.dynamics.add_observer(record);
  fall.dynamics.solve();
  EXPECT_LT(record.largest_drift(), 1e-6);
  EXPECT_GT(record.energies.back().lost_in_dampers, 1.0);
  EXPECT_GT(std::abs(record.energies.back().support_work), 1.0);
  // Momentum: what the supports and gravity gave is what the masses have.
  double given = -test::kGravity * fall.beam.total_mass() * 0.8;
  for (const double impulse : fall.dynamics.support_impulses()) {
    given += impulse;
  }
  EXPECT_NEAR(test::momentum_of(fall.line, fall.dynamics), given, 1e-6 * fall.beam.total_mass() * test::kGravity);
}

/// The tip mass of a cantilever of one element: q'' + (alpha + beta lambda^2) q' + lambda^2 q = 0.
TEST_P(OnSupports, DampedModeDecaysInClosedForm) {
  if (test::world_size() > 1) {
    GTEST_SKIP() << "one element cannot be dealt to several ranks";
  }
  const test::Option end{"-ts_max_time", "2.0"};
  const test::TipMass tip{.filter_frequency = 9.0};
  const double lambda = tip.lambda();
  InitialState initial{.height = 0.0};
  initial.shape = {.x = {0.0, 10.0}, .offset = {0.0, 0.2}, .velocity = {0.0, 0.5}};
  for (const Damping damping :
       {Damping{.mass = 0.8}, Damping{.stiffness = 0.05}, Damping{.mass = 0.3, .stiffness = 0.02}}) {
    test::Fall fall{tip.beam, tip.filter_frequency, 0.0, initial, {}, {}, {}, damping};
    test::Recorder record{0.1};
    fall.dynamics.add_observer(record);
    fall.dynamics.solve();
    const double decay = 0.5 * (damping.mass + damping.stiffness * lambda * lambda);
    const double turn = std::sqrt(lambda * lambda - decay * decay);
    for (std::size_t k = 0; k < record.times.size(); ++k) {
      const double t = record.times[k];
      const double expected =
          std::exp(-decay * t) * (0.2 * std::cos(turn * t) + (0.5 + decay * 0.2) / turn * std::sin(turn * t));
      EXPECT_NEAR(record.positions[k][1], expected, within(1e-9)) << t;
      EXPECT_LT(std::abs(record.energies[k].drift()), 2.0 * within(1e-8)) << t;  // of a square
    }
    EXPECT_GT(record.energies.back().lost_in_dampers, 0.3 * record.energies.front().total());
  }
}

/// A damper never gives energy: not by the rate of a load, nor by what an integrator makes of it.
void expect_losses_alone(const test::Recorder& record) {
  for (std::size_t k = 1; k < record.energies.size(); ++k) {
    EXPECT_GE(record.energies[k].lost_in_dampers, record.energies[k - 1].lost_in_dampers) << record.times[k];
  }
}

/// Two masses on springs under a force that jumps within 0.1 ms: m q'' + beta lambda^2 m q' + lambda^2 m q = gamma F.
TEST_P(OnSupports, StepLoadOnADampedOscillatorFollowsTheClosedForm) {
  if (test::world_size() > 1) {
    GTEST_SKIP() << "one element cannot be dealt to several ranks";
  }
  const test::Option end{"-ts_max_time", "0.6"};
  const double wf = 300.0;
  const double w = 10.0;  // of 50 kg on 5000 N/m
  const double gamma = wf * wf / (wf * wf + w * w);
  const double ramp = 1e-4;
  BeamParameters beam;
  beam.segments.push_back({.length = 1.0, .elements = 1, .bending_stiffness = 1e7, .mass_per_length = 100.0});
  beam.left = {.translational_stiffness = 5e3, .rotational_stiffness = 0.0};
  beam.right = beam.left;
  std::vector<NodalLoad> loads;
  for (const double x : {0.0, 1.0}) {
    loads.push_back({.position = x, .table = time_table({0.0, ramp, 10.0}, {0.0, 50.0, 50.0})});
  }
  for (const double stiffness : {0.02, 0.06}) {
    test::Fall fall{beam, wf, 0.0, {.height = 0.0}, {}, {}, loads, {.stiffness = stiffness}};
    test::Recorder record{0.01};
    fall.dynamics.add_observer(record);
    fall.dynamics.solve();
    const double decay = 0.5 * stiffness * gamma * w * w;
    const double turn = std::sqrt(gamma * w * w - decay * decay);
    // Of a force per mass that grows by 1 m/s^2 a second.
    const auto ramped = [&](double t) {
      const double square = gamma * w * w;
      return t <= 0.0 ? 0.0
                      : gamma / square *
                            (t - 2.0 * decay / square +
                             std::exp(-decay * t) * (2.0 * decay / square * std::cos(turn * t) +
                                                     (2.0 * decay * decay / square - 1.0) / turn * std::sin(turn * t)));
    };
    double peak = 0.0;
    for (std::size_t k = 0; k < record.times.size(); ++k) {
      const double t = record.times[k];
      const double expected = (ramped(t) - ramped(t - ramp)) / ramp;
      peak = std::max(peak, expected);
      for (const double y : record.positions[k]) {
        EXPECT_NEAR(y, expected, 0.02 * within(1e-8)) << "beta " << stiffness << ", t " << t;
      }
    }
    EXPECT_GT(peak, 0.01);
    EXPECT_GT(record.energies.back().lost_in_dampers, 0.1);
    expect_losses_alone(record);
  }
}

/// Free decay of a cantilever, every mode by itself, with dampers up to 31 times as fast as the filter.
TEST(StrongDamping, IsTheSumOfDampedModes) {
  if (test::world_size() > 1) {
    GTEST_SKIP() << "the modes are those of one rank";
  }
  const test::Option type{"-ts_type", "impact"};
  const test::Option end{"-ts_max_time", "0.05"};
  const double wf = 4000.0;
  BeamParameters parameters;
  parameters.segments.push_back(
      {.length = 1.0, .elements = 20, .bending_stiffness = 350.0, .mass_per_length = 1.57});  // steel, 20 by 10 mm
  parameters.left = test::kClamped;
  for (const double stiffness : {7.7e-4, 7.7e-3}) {
    test::Fall fall{parameters, wf, 0.0, {.height = 0.0, .velocity = 0.1}, {}, {}, {}, {.stiffness = stiffness}};
    test::Recorder record{0.001};
    fall.dynamics.add_observer(record);
    fall.dynamics.solve();
    const test::Eigen modes = test::lumped_modes(fall.beam);
    double error = 0.0;
    double peak = 0.0;
    for (std::size_t k = 0; k < record.times.size(); ++k) {
      double tip = 0.0;
      for (std::size_t j = 0; j < modes.values.size(); ++j) {
        const double square = wf * wf * modes.values[j] / (wf * wf + modes.values[j]);
        const double decay = 0.5 * stiffness * square;
        const std::complex<double> turn = std::sqrt(std::complex<double>{decay * decay - square});
        double speed = 0.0;
        for (std::size_t i = 0; i < 21; ++i) {
          speed += 0.1 * fall.line.mass()[i] * modes.vectors(i, j);
        }
        const double t = record.times[k];
        tip += speed * modes.vectors(20, j) *
               ((std::exp((turn - decay) * t) - std::exp((-turn - decay) * t)) / (2.0 * turn)).real();
      }
      peak = std::max(peak, std::abs(tip));
      error = std::max(error, std::abs(record.positions[k][20] - tip));
    }
    EXPECT_LT(error, 1e-4 * peak) << stiffness;  // found: 2e-6 and 3e-6; 1e-3 is asked for
    EXPECT_LT(record.largest_drift(), 1e-6);
    expect_losses_alone(record);
  }
}

TEST_P(OnSupports, DampedFallKeepsTheLedgerAndComesToRest) {
  const test::Option end{"-ts_max_time", "1.2"};
  const test::Option tolerance{"-ts_rtol", is("rk") ? "1e-9" : "1e-8"};
  Support moving{.position = 2.0, .width = 1.0, .restitution = 0.3};
  moving.motion = swung();
  const Support pad{.position = 8.0, .width = 1.0, .restitution = 0.3};
  const NodalLoad load{.position = 5.0, .table = time_table({0.1, 0.15, 0.4, 0.7}, {0.0, -3e4, 2e4, 0.0})};
  test::Fall fall{test::steel_beam(30), 100.0, test::kGravity, {.height = 0.3},
                  {moving, pad},        {},    {load},         {.mass = 0.5, .stiffness = 2e-3}};
  test::Recorder record{0.02};
  fall.dynamics.add_observer(record);
  fall.dynamics.solve();
  EXPECT_LT(record.largest_drift(), 1e-5);
  EXPECT_GT(fall.dynamics.counts().rests, 0);
  EXPECT_GT(record.energies.back().lost_in_dampers, 1.0);
  expect_losses_alone(record);
}

}  // namespace
}  // namespace udar
