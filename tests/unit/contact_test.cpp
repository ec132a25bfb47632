#include <gtest/gtest.h>

#include <limits>
#include <utility>

#include "support/steel_beam.hpp"
#include "udar/contact/impact_law.hpp"
#include "udar/contact/support.hpp"

namespace udar {
namespace {

TEST(ImpactLaw, ReversesAnArrivingMassByTheRestitution) {
  const ContactOutcome outcome = resolve_contact({.velocity = -4.0, .acceleration = -10.0, .mass = 3.0}, 0.5, 1e-10);
  EXPECT_TRUE(outcome.impact);
  EXPECT_FALSE(outcome.rests);
  EXPECT_DOUBLE_EQ(outcome.velocity, 2.0);
  EXPECT_DOUBLE_EQ(outcome.energy_loss, 0.5 * 3.0 * (16.0 - 4.0));
}

TEST(ImpactLaw, KeepsSeparatingMasses) {
  const ContactOutcome outcome = resolve_contact({.velocity = 1.0, .acceleration = -10.0, .mass = 3.0}, 0.5, 1e-10);
  EXPECT_FALSE(outcome.impact);
  EXPECT_FALSE(outcome.rests);
  EXPECT_DOUBLE_EQ(outcome.velocity, 1.0);
  EXPECT_EQ(outcome.energy_loss, 0.0);
}

TEST(ImpactLaw, RestsAtOnceWithoutRestitutionIfPressed) {
  const ContactOutcome pressed = resolve_contact({.velocity = -4.0, .acceleration = -1.0, .mass = 2.0}, 0.0, 1e-10);
  EXPECT_TRUE(pressed.rests);
  EXPECT_DOUBLE_EQ(pressed.energy_loss, 16.0);
  const ContactOutcome lifted = resolve_contact({.velocity = -4.0, .acceleration = 1.0, .mass = 2.0}, 0.0, 1e-10);
  EXPECT_FALSE(lifted.rests);
  EXPECT_EQ(lifted.velocity, 0.0);
}

TEST(ImpactLaw, RestsWhenTheNextHopIsNegligible) {
  // Hop height v^2 / (2 a) = 5e-11 m after the impact.
  const TouchingMass mass{.velocity = -2e-4, .acceleration = -100.0, .mass = 1.0};
  EXPECT_TRUE(resolve_contact(mass, 0.5, 6e-11).rests);
  EXPECT_FALSE(resolve_contact(mass, 0.5, 4e-11).rests);
}

TEST(ContactRuns, TakeEveryNodeWithinTheWidthEdgesIncluded) {
  const BeamChain beam{PETSC_COMM_WORLD, test::steel_beam(20)};
  const auto runs = contact_runs(beam, {{.position = 2.0, .width = 1.0}});
  ASSERT_EQ(runs.size(), 1U);
  EXPECT_EQ(runs.front().first, 3U);
  EXPECT_EQ(runs.front().last, 6U);
  EXPECT_EQ(contact_runs(beam, {{.position = 0.0, .width = 1.0}}).front().last, 2U);
}

TEST(ContactRuns, TakeTheNearestNodeOfAPointSupport) {
  const BeamChain beam{PETSC_COMM_WORLD, test::steel_beam(20)};
  for (const auto& [position, node] : {std::pair{2.2, 4U}, std::pair{2.3, 5U}, std::pair{2.25, 4U}}) {
    const ContactRun run = contact_runs(beam, {{.position = position}}).front();
    EXPECT_EQ(run.first, node);
    EXPECT_EQ(run.last, node + 1);
  }
}

TEST(ContactRuns, LeaveOutHeldNodes) {
  BeamParameters parameters = test::steel_beam(4);
  parameters.left = test::kPinned;
  const BeamChain beam{PETSC_COMM_WORLD, parameters};
  const auto runs = contact_runs(beam, {Support::floor(0.0, 1.0)});
  ASSERT_EQ(runs.size(), 1U);
  EXPECT_EQ(runs.front().first, 1U);
  EXPECT_EQ(runs.front().last, 5U);
}

TEST(ContactRuns, RefuseWhatCannotBeASupport) {
  const BeamChain beam{PETSC_COMM_WORLD, test::steel_beam(20)};
  EXPECT_THROW((void)contact_runs(beam, {{.position = -0.1}}), InputError);
  EXPECT_THROW((void)contact_runs(beam, {{.position = 10.1}}), InputError);
  EXPECT_THROW((void)contact_runs(beam, {{.position = 2.25, .width = 0.1}}), InputError);
  EXPECT_THROW((void)contact_runs(beam, {{.position = 2.0, .restitution = 1.1}}), InputError);
  EXPECT_THROW((void)contact_runs(beam, {{.position = 2.0, .height = std::numeric_limits<double>::quiet_NaN()}}),
               InputError);
}

}  // namespace
}  // namespace udar
