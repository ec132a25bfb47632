/// @file
/// Supports of all kinds against closed forms, by every integrator that knows them. Most tests let balls bounce: the
/// two masses of a beam of one element, which has no bending, move each by itself.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "support/steel_beam.hpp"
#include "support/world.hpp"

namespace udar {
namespace {

constexpr double kGravity = 9.81;

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
  test::Fall fall{balls(), 80.0, kGravity, {.height = 1.0}, {ground}};
  test::Recorder record;
  fall.dynamics.add_observer(record);
  fall.dynamics.solve();
  const std::array<double, 12> heights{0.1, 0.1, 0.0, -0.1, -0.2, 0.3, 0.3, 0.3, 0.3, 0.3, 0.3, 0.3};
  const auto hits = by_ball(record.impacts);
  for (PetscInt node = fall.beam.begin(); node < fall.beam.end(); ++node) {
    const auto ball = static_cast<std::size_t>(node);
    const double t0 = std::sqrt(2.0 * (1.0 - heights[ball]) / kGravity);
    ASSERT_FALSE(hits[ball].empty()) << node;
    EXPECT_NEAR(hits[ball][0].time, t0, within(1e-10)) << node;
    EXPECT_NEAR(hits[ball][0].velocity_before, -kGravity * t0, within(1e-9)) << node;
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
  test::Fall fall{balls(), 80.0, kGravity, initial, {floor}};
  test::Recorder record{1.8};
  fall.dynamics.add_observer(record);
  fall.dynamics.solve();
  const auto hits = by_ball(record.impacts);
  for (PetscInt node = fall.beam.begin(); node < fall.beam.end(); ++node) {
    const double height = 0.6 + 0.1 * fall.beam.position(node);
    double speed = std::sqrt(2.0 * kGravity * height);
    double time = speed / kGravity;
    ASSERT_GE(hits[static_cast<std::size_t>(node)].size(), 2U);
    for (const ImpactRecord& hit : hits[static_cast<std::size_t>(node)]) {
      const double e = speed > 2.0 ? 0.8 * std::pow(speed / 2.0, -0.25) : 0.8;
      EXPECT_NEAR(hit.time, time, within(1e-9)) << node;
      EXPECT_NEAR(hit.velocity_after, e * speed, 10.0 * within(1e-9)) << node;
      EXPECT_NEAR(hit.energy_loss, 0.5 * kBall * speed * speed * (1.0 - e * e), 10.0 * within(1e-9)) << node;
      speed *= e;
      time += 2.0 * speed / kGravity;
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
  test::Fall fall{balls(), 40.0, kGravity, initial, {Support::floor(0.0, 0.9), ceiling}};
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
      const double above = speed * speed - 2.0 * kGravity * (1.0 - place);
      const bool up = speed > 0.0 && above > 0.0;
      const double arrived = up ? std::sqrt(above) : -std::sqrt(speed * speed + 2.0 * kGravity * place);
      time += (speed - arrived) / kGravity;
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

}  // namespace
}  // namespace udar
