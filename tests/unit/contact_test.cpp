// ranks: 1; size: short
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "support/steel_beam.hpp"
#include "support/world.hpp"
#include "udar/contact/impact_law.hpp"
#include "udar/contact/support.hpp"
#include "udar/motion/observer.hpp"

namespace udar {
namespace {

TEST(EnergyLedger, IsJudgedByWhatIsStoredAndNotByWhereHeightsCountFrom) {
  // A spring that a force of 2 N presses by 1 m, 1000 m above y = 0; 0.1 J are missing.
  EnergyLedger ledger{.line_strain = 1.9,
                      .load_potential = -2.0 * 1001.0,
                      .initial = -2.0 * 1000.0,
                      .initial_potential = -2.0 * 1000.0};
  EXPECT_DOUBLE_EQ(ledger.turned_over(), 2.0);
  ledger.scale = ledger.turned_over();
  EXPECT_NEAR(ledger.drift(), -0.05, 1e-12);
  EXPECT_EQ(EnergyLedger{}.drift(), 0.0);
}

TEST(EnergyLedger, HasNoDriftThatPassesWhereAnEnergyIsNoNumber) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(std::isnan((EnergyLedger{.kinetic = kNone, .scale = 1.0}.drift())));
  EXPECT_TRUE(std::isnan((EnergyLedger{.kinetic = 1.0, .scale = kNone}.drift())));
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(std::isfinite((EnergyLedger{.kinetic = kInfinite, .scale = kInfinite}.drift())));
}

TEST(ImpactLaw, ReversesAnArrivingMassByTheRestitution) {
  const ContactOutcome outcome = resolve_contact({.velocity = -4.0, .acceleration = -10.0, .mass = 3.0}, {0.5}, 1e-10);
  EXPECT_TRUE(outcome.impact);
  EXPECT_FALSE(outcome.rests);
  EXPECT_DOUBLE_EQ(outcome.velocity, 2.0);
  EXPECT_DOUBLE_EQ(outcome.energy_loss, 0.5 * 3.0 * (16.0 - 4.0));
}

TEST(ImpactLaw, KeepsSeparatingMasses) {
  const ContactOutcome outcome = resolve_contact({.velocity = 1.0, .acceleration = -10.0, .mass = 3.0}, {0.5}, 1e-10);
  EXPECT_FALSE(outcome.impact);
  EXPECT_FALSE(outcome.rests);
  EXPECT_DOUBLE_EQ(outcome.velocity, 1.0);
  EXPECT_EQ(outcome.energy_loss, 0.0);
}

TEST(ImpactLaw, RestsAtOnceWithoutRestitutionIfPressed) {
  const ContactOutcome pressed = resolve_contact({.velocity = -4.0, .acceleration = -1.0, .mass = 2.0}, {0.0}, 1e-10);
  EXPECT_TRUE(pressed.rests);
  EXPECT_DOUBLE_EQ(pressed.energy_loss, 16.0);
  const ContactOutcome lifted = resolve_contact({.velocity = -4.0, .acceleration = 1.0, .mass = 2.0}, {0.0}, 1e-10);
  EXPECT_FALSE(lifted.rests);
  EXPECT_EQ(lifted.velocity, 0.0);
}

TEST(ImpactLaw, RestsWithoutRestitutionWhereNothingPullsButRounding) {
  for (const double acceleration : {0.0, 1e-15, -1e-15}) {
    const TouchingMass mass{.velocity = -4.0, .acceleration = acceleration, .resolution = 1e-14, .mass = 2.0};
    EXPECT_TRUE(resolve_contact(mass, {0.0}, 1e-10).rests) << acceleration;
    EXPECT_FALSE(resolve_contact(mass, {0.5}, 1e-10).rests) << acceleration;
  }
  EXPECT_FALSE(
      resolve_contact({.velocity = -4.0, .acceleration = 2e-14, .resolution = 1e-14, .mass = 2.0}, {0.0}, 1e-10).rests);
}

TEST(ImpactLaw, RestsWhenTheNextHopIsNegligible) {
  // Hop height v^2 / (2 a) = 5e-11 m after the impact.
  const TouchingMass mass{.velocity = -2e-4, .acceleration = -100.0, .mass = 1.0};
  EXPECT_TRUE(resolve_contact(mass, {0.5}, 6e-11).rests);
  EXPECT_FALSE(resolve_contact(mass, {0.5}, 4e-11).rests);
}

TEST(ImpactLaw, IsTheSamePerStepAndFromAbove) {
  const ImpactLaw law{.restitution = 0.8, .yield_speed = 2.0};
  EXPECT_DOUBLE_EQ(law.after(-1.0), 0.8);
  EXPECT_DOUBLE_EQ(law.after(-32.0), 12.8);  // e = 0.8 / 2
  EXPECT_DOUBLE_EQ(law.per_step(0.5).after(-16.0), 6.4);
}

TEST(ContactRuns, TakeEveryNodeWithinTheWidthEdgesIncluded) {
  const BeamChain beam{PETSC_COMM_WORLD, test::steel_beam(20)};
  const std::vector<ContactSet> runs = find_contacts(beam.points(), {{.position = 2.0, .width = 1.0}}).sets;
  ASSERT_EQ(runs.size(), 1U);
  EXPECT_EQ(runs.front().first, 3U);
  EXPECT_EQ(runs.front().last, 6U);
  EXPECT_EQ(find_contacts(beam.points(), {{.position = 0.0, .width = 1.0}}).sets.front().last, 2U);
}

TEST(ContactRuns, TakeTheNearestNodeOfAPointSupport) {
  const BeamChain beam{PETSC_COMM_WORLD, test::steel_beam(20)};
  for (const auto& [position, node] : {std::pair{2.2, 4U}, std::pair{2.3, 5U}, std::pair{2.25, 4U}}) {
    const ContactSet run = find_contacts(beam.points(), {{.position = position}}).sets.front();
    EXPECT_EQ(run.first, node);
    EXPECT_EQ(run.last, node + 1);
  }
}

TEST(ContactRuns, LeaveOutFixedNodes) {
  BeamParameters parameters = test::steel_beam(4);
  parameters.left = test::kPinned;
  const BeamChain beam{PETSC_COMM_WORLD, parameters};
  const std::vector<ContactSet> runs = find_contacts(beam.points(), {Support::floor(0.0, 1.0)}).sets;
  ASSERT_EQ(runs.size(), 1U);
  EXPECT_EQ(runs.front().first, 1U);
  EXPECT_EQ(runs.front().last, 5U);
}

/// Five points a metre apart, in this order: 0, 3, 1, 4, 2 m; the one at 1 m never moves.
PlacedPoints five_points() {
  PointTable table{.mass = {1.0, 2.0, 3.0, 4.0, 5.0}, .place = {}, .fixed = {2}, .number = {}};
  for (const double x : {0.0, 3.0, 1.0, 4.0, 2.0}) {
    table.place.push_back({.x = x});
  }
  return {PETSC_COMM_WORLD, 1, table};
}

TEST(ContactRuns, OfPointsOutOfOrderAreSeveral) {
  const PlacedPoints points = five_points();
  Support support{.position = 2.0, .width = 4.0, .profile = {.x = {0.0, 4.0}, .height = {0.0, 8.0}}};
  support.width = 2.5;  // from 0.75 to 3.25 m: points 1, 2 and 4
  support.stiffness = 100.0;
  const Contacts contacts = find_contacts(points, {support});
  EXPECT_EQ(contacts.touched, std::vector<PetscInt>{3});
  ASSERT_EQ(contacts.sets.size(), 2U);
  EXPECT_EQ(contacts.sets[0].first, 1U);
  EXPECT_EQ(contacts.sets[0].last, 2U);
  EXPECT_EQ(contacts.sets[1].first, 4U);
  EXPECT_EQ(contacts.sets[1].last, 5U);
  EXPECT_EQ(contacts.sets[0].height(1), 6.0);
  EXPECT_EQ(contacts.sets[1].height(4), 4.0);
  for (const ContactSet& set : contacts.sets) {
    EXPECT_EQ(set.carried, 10.0);
    EXPECT_EQ(set.stiffness, 10.0);
  }
  // The floor takes all but the fixed one; a second support on springs would share points.
  EXPECT_EQ(find_contacts(points, {Support::floor(0.0, 1.0)}).sets.size(), 2U);
  EXPECT_THROW((void)find_contacts(points, {support, Support::floor(0.0, 1.0)}), InputError);
  EXPECT_EQ(find_contacts(points, {{.position = 3.9}}).sets.front().first, 3U);
}

TEST(ContactRuns, RefuseWhatCannotBeASupport) {
  const BeamChain beam{PETSC_COMM_WORLD, test::steel_beam(20)};
  EXPECT_THROW((void)find_contacts(beam.points(), {{.position = -0.1}}), InputError);
  EXPECT_THROW((void)find_contacts(beam.points(), {{.position = 10.1}}), InputError);
  EXPECT_THROW((void)find_contacts(beam.points(), {{.position = 2.25, .width = 0.1}}), InputError);
  EXPECT_THROW((void)find_contacts(beam.points(), {{.position = 2.0, .restitution = 1.1}}), InputError);
  EXPECT_THROW(
      (void)find_contacts(beam.points(), {{.position = 2.0, .height = std::numeric_limits<double>::quiet_NaN()}}),
      InputError);
}

TEST(ContactRuns, ShareASpringByTheMassItCarries) {
  BeamParameters parameters = test::steel_beam(40);
  parameters.mass_patches = {{1.1, 2.9}};
  const BeamChain beam{PETSC_COMM_WORLD, parameters};
  Support support{.position = 2.0, .width = 1.8};
  support.stiffness = 3e5;
  support.damping = 40.0;
  const ContactSet run = find_contacts(beam.points(), {support}).sets.front();
  double stiffness = 0.0;
  double damping = 0.0;
  for (std::size_t node = run.first; node < run.last; ++node) {
    stiffness += run.stiffness * beam.mass(static_cast<PetscInt>(node));
    damping += run.damping * beam.mass(static_cast<PetscInt>(node));
  }
  EXPECT_NEAR(stiffness, 3e5, 1e-7);  // round-off of eight sums
  EXPECT_NEAR(damping, 40.0, 1e-11);
}

TEST(ContactRuns, RefuseAMovingSupportBesideAnotherOnItsSide) {
  const BeamChain beam{PETSC_COMM_WORLD, test::steel_beam(20)};
  Support moving{.position = 2.0, .width = 1.0};
  moving.motion = std::make_shared<SupportMotion>(std::vector<double>{0.0, 1.0}, std::vector<double>{0.0, 1.0});
  EXPECT_THROW((void)find_contacts(beam.points(), {moving, Support::floor(0.0, 1.0)}), InputError);
  Support ceiling = Support::floor(3.0, 1.0);
  ceiling.side = SupportSide::above;
  EXPECT_NO_THROW((void)find_contacts(beam.points(), {moving, ceiling}));
}

TEST(ImpactLaw, LosesMoreAboveTheYieldSpeed) {
  EXPECT_DOUBLE_EQ((ImpactLaw{0.8, 2.0}.ratio(2.0)), 0.8);
  EXPECT_DOUBLE_EQ((ImpactLaw{0.8, 2.0}.ratio(32.0)), 0.4);
  EXPECT_EQ(ImpactLaw{0.8}.ratio(1e300), 0.8);
  EXPECT_DOUBLE_EQ(resolve_contact({.velocity = -32.0, .acceleration = 0.0, .mass = 1.0}, {0.8, 2.0}, 1e-10).velocity,
                   0.4 * 32.0);
}

TEST(SupportMotion, IsACubicBetweenItsRowsAndStillBeside) {
  const SupportMotion motion{{1.0, 2.0, 4.0}, {0.5, 1.5, 0.5}};
  EXPECT_EQ(motion.at(2.0).velocity, 0.0);  // it turns there
  EXPECT_EQ(motion.at(0.3).height, 0.5);
  EXPECT_EQ(motion.at(0.3).velocity, 0.0);
  EXPECT_EQ(motion.at(5.0).height, 0.5);
  EXPECT_EQ(motion.at(5.0).acceleration, 0.0);
  const auto cubic = motion.cubic(2.25, 1.5);
  for (const double tau : {0.0, 0.3, 1.0}) {
    const double t = 2.25 + 1.5 * tau;
    const double s = (t - 2.0) / 2.0;  // Hermite's polynomials
    const double expected = 1.5 * (1 + 2 * s) * (1 - s) * (1 - s) + 0.5 * s * s * (3 - 2 * s);
    EXPECT_NEAR(cubic[0] + tau * (cubic[1] + tau * (cubic[2] + tau * cubic[3])), expected, 1e-15);
    EXPECT_NEAR(motion.at(t).height, expected, 1e-15);
  }
  EXPECT_NO_THROW(motion.require_smooth(10.0));
  EXPECT_THROW((SupportMotion{{0.0, 1.0}, {0.0, 1.0}, {0.0, 2.0}}.require_smooth(1.5)), InputError);
  EXPECT_NO_THROW((SupportMotion{{0.0, 1.0}, {0.0, 1.0}, {0.0, 2.0}}.require_smooth(1.0)));
  // Where heights go on rising: the harmonic mean of the slopes 1 and 1/2, weighted with the lengths, 9 / (5 / 1 + 4 /
  // 0.5).
  const SupportMotion rising{{0.0, 1.0, 3.0}, {0.0, 1.0, 2.0}};
  EXPECT_DOUBLE_EQ(rising.at(1.0).velocity, 9.0 / (5.0 / 1.0 + 4.0 / 0.5));
}

TEST(SupportMotion, StaysBetweenItsRowsWhereverTheyAre) {
  std::mt19937_64 random{20};
  std::uniform_real_distribution<double> height{-1.0, 1.0};
  std::uniform_real_distribution<double> decades{-5.0, 1.0};
  for (int table = 0; table < 200; ++table) {
    std::vector<double> times{0.0};
    std::vector<double> heights{height(random)};
    const auto rows = 2 + static_cast<std::size_t>(table % 9);
    while (times.size() < rows) {
      times.push_back(times.back() + std::pow(10.0, decades(random)));
      heights.push_back(table % 4 == 0 ? heights.back() : height(random) * std::pow(10.0, decades(random)));
    }
    const SupportMotion motion{times, heights};
    for (std::size_t i = 0; i + 1 < rows; ++i) {
      const auto [low, high] = std::minmax(heights[i], heights[i + 1]);
      const double rounding = 8.0 * std::numeric_limits<double>::epsilon() * std::max(std::abs(low), std::abs(high));
      for (int k = 0; k <= 40; ++k) {
        const double at = std::lerp(times[i], times[i + 1], 0.025 * k);
        const double y = motion.at(at, times[i]).height;
        ASSERT_GE(y, low - rounding) << "table " << table << ", t = " << at;
        ASSERT_LE(y, high + rounding) << "table " << table << ", t = " << at;
      }
    }
  }
}

TEST(SupportMotion, RefusesVelocitiesAndRowsThatNoSupportHas) {
  const auto refusal = [](std::vector<double> time, std::vector<double> height, std::vector<double> velocity) {
    return test::failure_of<InputError>([&] { static_cast<void>(SupportMotion{time, height, velocity}); });
  };
  const std::string swing = refusal({0.0, 0.1, 0.2}, {0.0, 0.003, 0.0}, {0.0, -1e15, 0.0});
  EXPECT_NE(swing.find("row 2 of numbers (t = 0.1 s)"), std::string::npos) << swing;
  EXPECT_NE(swing.find("0.003 m"), std::string::npos) << swing;
  const std::string jump = refusal({0.0, 0.1, 0.1000000000001, 0.2}, {0.0, 0.003, 0.0, 0.0}, {});
  EXPECT_NE(jump.find("rows 2 and 3 of numbers"), std::string::npos) << jump;
  EXPECT_NE(jump.find("speed of light"), std::string::npos) << jump;
  // A cubic that leaves its rows by less than the whole table's range is the user's own will: 4/27 of a slope here.
  EXPECT_NO_THROW((SupportMotion{{0.0, 1.0, 2.0}, {0.0, 0.0, 1.0}, {0.0, 0.9 * 27.0 / 4.0, 0.0}}));
  EXPECT_THROW((SupportMotion{{0.0, 1.0, 2.0}, {0.0, 0.0, 1.0}, {0.0, 1.1 * 27.0 / 4.0, 0.0}}), InputError);
}

}  // namespace
}  // namespace udar
