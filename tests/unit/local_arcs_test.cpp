// ranks: 1; size: short
/// @file
/// Arcs and events of local motion, one by one, against closed forms.

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "udar/contact/elastic_touch.hpp"
#include "udar/local/arcs.hpp"

namespace udar {
namespace {

/// The line stays `line` above the mass's start.
local::Problem problem_of(double line, double velocity) {
  local::Problem problem;
  problem.angle = 1.0;
  problem.terms = 3;
  problem.powers = local::powers_for(problem.angle);
  problem.line = {line};
  problem.velocity = velocity;
  return problem;
}

TEST(ElasticTouch, PressesSlackensAndOpens) {
  constexpr double kDamping = 1.0;
  ElasticTouch touch;
  EXPECT_TRUE(touch.changes_on_face(false));
  touch.change(false, kDamping, -1.0);  // arrives with a damper: its force jumps
  EXPECT_TRUE(touch.pressing());
  EXPECT_FALSE(touch.starts_at_zero());
  EXPECT_EQ(touch.sign(), -1.0);
  touch.change(false, kDamping, 1.0);
  EXPECT_TRUE(touch.slack());
  EXPECT_TRUE(touch.starts_at_zero());
  EXPECT_EQ(touch.sign(), 1.0);
  touch.pass();
  EXPECT_FALSE(touch.starts_at_zero());
  touch.change(true, kDamping, 1.0);
  EXPECT_FALSE(touch.closed());
}

TEST(ElasticTouch, OpensWithItsForceWithoutDamper) {
  ElasticTouch touch;
  touch.change(false, 0.0, -1.0);
  EXPECT_TRUE(touch.starts_at_zero());  // the force grows from zero
  EXPECT_TRUE(touch.opens_with_force(0.0));
  EXPECT_FALSE(touch.opens_with_force(1.0));
}

TEST(RestArc, EndsWhereTheLineLiftsTheMass) {
  local::Problem problem = problem_of(-0.5, 0.0);
  problem.line[1] = 1.0;  // P = tau - 1/2 rises through the stop at 1/2
  problem.stops[0] = {.present = true};
  problem.resting = 0;
  const local::Mass mass = local::mass_at_start(problem);
  const local::RestArc arc = local::rest_arc(problem, mass);
  EXPECT_TRUE(arc.released);
  EXPECT_NEAR(arc.length, 0.5, 1e-15);
}

TEST(RestArc, PressesWithWhatTheLinePulls) {
  const local::Problem problem = [] {
    local::Problem made = problem_of(-0.5, 0.0);
    made.stops[0] = {.present = true};
    made.resting = 0;
    return made;
  }();
  local::Mass mass = local::mass_at_start(problem);
  const local::RestArc arc = local::rest_arc(problem, mass);
  EXPECT_FALSE(arc.released);
  local::Outcome outcome;
  local::ArcReport report;
  pass(problem, arc, mass, outcome, &report);
  EXPECT_TRUE(report.stops[0].pressed);
  EXPECT_NEAR(report.stops[0].push, 0.5, 1e-15);  // z2 times the stretch times the step
  EXPECT_EQ(mass.tau, 1.0);
}

TEST(FreeArc, IsTheOscillator) {
  const local::Problem problem = problem_of(0.25, 0.75);
  local::Mass mass = local::mass_at_start(problem);
  local::FreeArc arc;
  local::Outcome outcome;
  start_free_arc(problem, mass, arc);
  find_event(problem, mass, arc);
  EXPECT_EQ(arc.met, -1);
  pass(problem, arc, mass, outcome, nullptr);
  EXPECT_NEAR(mass.place, 0.25 * (1.0 - std::cos(1.0)) + 0.75 * std::sin(1.0), 1e-15);
  EXPECT_NEAR(mass.velocity, 0.25 * std::sin(1.0) + 0.75 * std::cos(1.0), 1e-15);
  EXPECT_NEAR(outcome.moments[0], 0.25 * (1.0 - std::sin(1.0)) + 0.75 * (1.0 - std::cos(1.0)), 1e-15);
}

TEST(FreeArc, EndsAtTheFirstOfTwoStops) {
  local::Problem problem = problem_of(0.0, 1.0);  // z = sin(tau)
  problem.stops[0] = {.at = -0.5, .present = true};
  problem.stops[1] = {.at = 0.5, .restitution = 0.25, .present = true};
  local::Mass mass = local::mass_at_start(problem);
  local::FreeArc arc;
  local::Outcome outcome;
  local::ArcReport report;
  start_free_arc(problem, mass, arc);
  find_event(problem, mass, arc);
  ASSERT_EQ(arc.met, 1);
  EXPECT_NEAR(arc.length, std::asin(0.5), 1e-15);
  pass(problem, arc, mass, outcome, &report);
  apply_event(problem, arc, mass, outcome, &report);
  EXPECT_TRUE(report.impact);
  EXPECT_EQ(mass.place, 0.5);
  EXPECT_NEAR(mass.velocity, -0.25 * std::cos(std::asin(0.5)), 1e-15);
  EXPECT_EQ(mass.standing, 1);
  EXPECT_EQ(outcome.impacts, 1);
}

TEST(FreeArc, OnASpringIsTheStifferOscillator) {
  constexpr double kStiffness = 3.0;  // z'' = -(1 + 3) z while it presses
  local::Problem problem = problem_of(0.0, -1.0);
  problem.until = 0.5;
  problem.stops[0] = {.present = true, .stiffness = kStiffness};
  const local::Outcome outcome = local::advance(problem);
  EXPECT_NEAR(outcome.displacement, -0.5 * std::sin(1.0), 1e-15);
  EXPECT_NEAR(outcome.velocity, -std::cos(1.0), 1e-15);
}

TEST(LocalMotion, TellsWhatHappensInOrder) {
  struct Listener final : local::Journal {
    std::vector<char> told;
    void impact(int /*stop*/, double /*tau*/, double /*before*/, double /*after*/) override { told.push_back('i'); }
    void rest(int /*stop*/, double /*tau*/, double /*speed*/) override { told.push_back('r'); }
    void pressed(int /*stop*/, double /*push*/, double /*work*/) override { told.push_back('p'); }
  };
  local::Problem problem = problem_of(-0.2, -1.0);
  problem.stops[0] = {.at = -0.1, .restitution = 0.0, .present = true};
  Listener listener;
  EXPECT_EQ(local::advance(problem, &listener).resting, 0);
  EXPECT_EQ(listener.told, (std::vector<char>{'i', 'r', 'p'}));
}

}  // namespace
}  // namespace udar
