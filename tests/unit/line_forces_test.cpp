// ranks: 1; size: short
/// @file
/// Contact forces on the line over a step of the impact integrator, against closed forms.

#include "udar/integrators/line_forces.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <vector>

#include "support/steel_beam.hpp"

namespace udar {
namespace {

/// A free beam whose masses all have the same place at any time of a step, and a support under its middle at height 0.
struct LevelStep {
  static constexpr std::size_t kMiddle = 5;
  BeamChain beam{PETSC_COMM_WORLD, test::steel_beam(10)};
  FilteredStructure line{beam, {.filter_frequency = 50.0}};
  Contacts contacts{find_contacts(beam.points(), {{.position = 5.0, .restitution = 1.0}})};
  ContactState state{beam.points(), contacts, {.surface = ContactSurface::line}};
  LineContact contact{line, contacts};
  std::vector<double> start;
  std::vector<double> axis;
  Sweep sweep;

  /// @param from, to height at both ends of the step [m], reached evenly
  LevelStep(double from, double to) : start(2 * line.mass().size(), from), axis(line.mass().size(), 0.0) {
    sweep.count = axis.size();
    sweep.frequency = line.filter_frequency();
    sweep.begin = 2.0;
    sweep.step = 1e-2;
    sweep.start = start.data();
    sweep.axis = axis;
    sweep.mass = line.mass();
    for (std::size_t j = 0; j < sweep.terms; ++j) {
      const double moment = j == 0 ? 0.5 * (from + to) : j == 1 ? 0.5 * (to - from) : 0.0;
      sweep.moment_rows[j].assign(sweep.count, moment);
      sweep.series.rows[j].assign(sweep.count, 0.0);  // a free line without loads is where its masses are
    }
    sweep.series.steady[0].assign(sweep.count, 0.0);
  }

  [[nodiscard]] double impulse() const {
    std::vector<double> sums(1, 0.0);
    state.journal().add_impulses(sweep.begin + sweep.step, 1.0, sums);
    return sums[0];
  }
  /// Force that lifts the line by a metre at the support.
  [[nodiscard]] double stiffness() {
    std::vector<double> stretch(sweep.count, 0.0);
    contact.apply(0.0, std::vector<double>(sweep.count, -1.0), stretch, {}, {});
    return contact.forces()[0];
  }
};

TEST(LineForces, HoldTheLineOfMassesThatStay) {
  constexpr double kDepth = 0.01;
  LevelStep level{-kDepth, -kDepth};
  LineForces forces{level.sweep, level.contact, level.state};
  forces.begin();
  forces.apply();
  // On the support; rounding of a solve and of sums over eight Gauss points.
  EXPECT_NEAR(level.start[LevelStep::kMiddle] + level.sweep.series.rows[0][LevelStep::kMiddle], 0.0, 1e-14);
  for (std::size_t j = 1; j < level.sweep.terms; ++j) {
    EXPECT_NEAR(level.sweep.series.rows[j][LevelStep::kMiddle], 0.0, 1e-14) << j;
  }
  Tally tally;
  forces.tell(tally);
  EXPECT_EQ(tally.most[Tally::kink], 0.0);
  forces.write_journal();
  const double expected = level.stiffness() * kDepth * level.sweep.step;
  EXPECT_NEAR(level.impulse(), expected, 1e-12 * expected);
  ASSERT_TRUE(level.state.journal().line_contact());
  EXPECT_EQ(level.state.journal().line_contact()->from, level.sweep.begin);
  EXPECT_EQ(level.state.journal().line_contact()->until, level.sweep.begin + level.sweep.step);
}

TEST(LineForces, BeginWhereTheLineComesDown) {
  constexpr double kHeight = 0.01;
  LevelStep level{kHeight, -kHeight};  // meets the support in the middle of the step
  LineForces forces{level.sweep, level.contact, level.state};
  forces.begin();
  forces.apply();
  Tally tally;
  forces.tell(tally);
  EXPECT_GT(tally.most[Tally::kink], 0.0);
  EXPECT_NEAR(tally.first[kBins / 2], 0.5, 1e-12);  // a zero of a linear function of some 1e-2
  forces.write_journal();
  ASSERT_TRUE(level.state.journal().line_contact());
  EXPECT_NEAR(level.state.journal().line_contact()->from, level.sweep.begin + 0.5 * level.sweep.step, 1e-14);
  // The force rises evenly from the middle on. Gauss points 0.18 of the step apart miss its kink by at most
  // 0.18^2 / 8 of the rise in a step, which is 3 % of the impulse.
  const double expected = level.stiffness() * 2.0 * kHeight * level.sweep.step / 8.0;
  EXPECT_NEAR(level.impulse(), expected, 0.03 * expected);
  EXPECT_NEAR(level.state.local_line_gap().gap, 0.0, 1e-14);
}

TEST(LineForces, AreNoneAboveTheSupport) {
  LevelStep level{0.02, 0.01};
  LineForces forces{level.sweep, level.contact, level.state};
  forces.begin();
  forces.apply();
  forces.write_journal();
  EXPECT_EQ(level.impulse(), 0.0);
  EXPECT_FALSE(level.state.journal().line_contact());
  EXPECT_GT(level.state.local_line_gap().gap, 0.01);
}

}  // namespace
}  // namespace udar
