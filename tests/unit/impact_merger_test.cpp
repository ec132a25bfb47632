// ranks: 1; size: short
/// @file
/// Impacts merged within a window against sums by hand.

#include "udar/io/impact_merger.hpp"

#include <gtest/gtest.h>
#include <petscsys.h>

#include <algorithm>
#include <cstddef>
#include <limits>
#include <random>
#include <span>
#include <vector>

namespace udar::io {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

ImpactRecord impact(double time, PetscInt node, PetscInt support, double velocity) {
  return {.time = time,
          .node = node,
          .x = 0.5 * static_cast<double>(node),
          .support = support,
          .velocity_before = velocity,
          .velocity_after = -0.5 * velocity,
          .impulse = 3.0 * velocity,
          .energy_loss = 0.25 * velocity * velocity};
}

TEST(ImpactMerger, JoinsWhatComesWithinTheWindowOfTheFirst) {
  ImpactMerger merger{10, 5, 1.0};
  merger.add(std::vector{impact(0.0, 12, 0, -4.0), impact(0.5, 12, 0, 6.0), impact(0.75, 12, 1, -1.0),
                         impact(0.875, 12, 0, -2.0), impact(1.0, 12, 0, -3.0)});
  EXPECT_EQ(merger.latest(), 1.0);
  EXPECT_TRUE(merger.take(0.875).empty()) << "another may still join the first";
  const std::vector<MergedImpact> first = merger.take(1.0);
  ASSERT_EQ(first.size(), 1U);
  EXPECT_EQ(first[0].time, 0.0);
  EXPECT_EQ(first[0].last_time, 0.875);
  EXPECT_EQ(first[0].node, 12);
  EXPECT_EQ(first[0].x, 6.0);
  EXPECT_EQ(first[0].impacts, 3);
  EXPECT_EQ(first[0].speed_max, 6.0);
  EXPECT_EQ(first[0].impulse, 0.0);
  EXPECT_EQ(first[0].energy_loss, 14.0);
  const std::vector<MergedImpact> rest = merger.take(kInfinity);
  ASSERT_EQ(rest.size(), 2U);
  EXPECT_EQ(rest[0].support, 1);
  EXPECT_EQ(rest[1].time, 1.0) << "a window after the first another begins";
  EXPECT_EQ(merger.size(), 0U);
}

TEST(ImpactMerger, GivesThemInOrderOfTimeAndNode) {
  ImpactMerger merger{0, 4, 0.5};
  merger.add(std::vector{impact(2.0, 3, 0, 1.0), impact(1.0, 2, 0, 1.0), impact(2.0, 1, 0, 1.0)});
  std::vector<PetscInt> nodes;
  for (const MergedImpact& entry : merger.take(kInfinity)) {
    nodes.push_back(entry.node);
  }
  EXPECT_EQ(nodes, (std::vector<PetscInt>{2, 1, 3}));
}

/// Taken early and often, saved and restored between, it gives what it gives at once.
TEST(ImpactMerger, DoesNotDependOnWhenItIsAsked) {
  std::mt19937 random{1};
  std::uniform_real_distribution<double> number{0.0, 1.0};
  std::vector<ImpactRecord> all;
  for (double time = 0.0; time < 20.0; time += 0.01 * number(random)) {
    all.push_back(
        impact(time, static_cast<PetscInt>(8.0 * number(random)), number(random) < 0.5 ? 0 : 1, number(random) - 0.5));
  }
  ImpactMerger at_once{0, 8, 0.3};
  at_once.add(all);
  const std::vector<MergedImpact> expected = at_once.take(kInfinity);

  std::vector<MergedImpact> found;
  ImpactMerger often{0, 8, 0.3};
  for (std::size_t done = 0; done < all.size();) {
    const std::size_t now = std::min<std::size_t>(37, all.size() - done);
    often.add(std::span{all}.subspan(done, now));
    done += now;
    const std::vector<MergedImpact> taken = often.take(done < all.size() ? often.latest() : kInfinity);
    found.insert(found.end(), taken.begin(), taken.end());
    EXPECT_LE(often.size(), 16U) << "one for each of the nodes and supports";
    MotionState state;
    often.save(PETSC_COMM_WORLD, state);
    often = ImpactMerger{0, 8, 0.3};
    often.restore(state);
  }
  ASSERT_EQ(found.size(), expected.size());
  ASSERT_GT(found.size(), 500U);
  PetscInt impacts = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].time, expected[i].time);
    EXPECT_EQ(found[i].node, expected[i].node);
    EXPECT_EQ(found[i].last_time, expected[i].last_time);
    EXPECT_EQ(found[i].impulse, expected[i].impulse) << "the same sum in the same order";
    EXPECT_EQ(found[i].energy_loss, expected[i].energy_loss);
    EXPECT_EQ(found[i].speed_max, expected[i].speed_max);
    impacts += found[i].impacts;
  }
  EXPECT_EQ(impacts, static_cast<PetscInt>(all.size()));
}

}  // namespace
}  // namespace udar::io
