#include <gtest/gtest.h>

#include <limits>

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

TEST(ContactPoints, TakeEveryNodeWithinTheWidthEdgesIncluded) {
  const BeamChain beam{PETSC_COMM_WORLD, test::steel_beam(20)};
  const auto points = contact_points(beam, {{.position = 2.0, .width = 1.0}});
  ASSERT_EQ(points.size(), 3U);
  EXPECT_EQ(points.front().local_node, 3);
  EXPECT_EQ(points.back().local_node, 5);
  EXPECT_EQ(contact_points(beam, {{.position = 0.0, .width = 1.0}}).size(), 2U);
}

TEST(ContactPoints, TakeTheNearestNodeOfAPointSupport) {
  const BeamChain beam{PETSC_COMM_WORLD, test::steel_beam(20)};
  EXPECT_EQ(contact_points(beam, {{.position = 2.2}}).front().local_node, 4);
  EXPECT_EQ(contact_points(beam, {{.position = 2.3}}).front().local_node, 5);
  EXPECT_EQ(contact_points(beam, {{.position = 2.25}}).front().local_node, 4);
}

TEST(ContactPoints, LeaveOutAHeldEnd) {
  BeamParameters parameters = test::steel_beam(4);
  parameters.left = test::kPinned;
  const BeamChain beam{PETSC_COMM_WORLD, parameters};
  EXPECT_EQ(contact_points(beam, {Support::floor(0.0, 1.0)}).size(), 4U);
}

TEST(ContactPoints, RefuseWhatCannotBeASupport) {
  const BeamChain beam{PETSC_COMM_WORLD, test::steel_beam(20)};
  EXPECT_THROW((void)contact_points(beam, {{.position = -0.1}}), InputError);
  EXPECT_THROW((void)contact_points(beam, {{.position = 10.1}}), InputError);
  EXPECT_THROW((void)contact_points(beam, {{.position = 2.25, .width = 0.1}}), InputError);
  EXPECT_THROW((void)contact_points(beam, {{.position = 2.0, .restitution = 1.1}}), InputError);
  EXPECT_THROW((void)contact_points(beam, {{.position = 2.0, .height = std::numeric_limits<double>::quiet_NaN()}}),
               InputError);
}

}  // namespace
}  // namespace udar
