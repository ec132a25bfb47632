// ranks: 1; size: short
/// @file
/// What happens in a step, however much it is: in order, and never all in memory.

#include "udar/motion/step_records.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <csignal>
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "support/steel_beam.hpp"
#include "support/world.hpp"
#include "udar/motion/contact_journal.hpp"

namespace udar {
namespace {

using Records = StepRecords<RestRecord>;
constexpr std::size_t kBlock = Records::kBlock;

RestRecord record(std::size_t i) {
  return {.time = 0.5 * static_cast<double>(i), .node = static_cast<PetscInt>(i), .release = i % 3 == 0};
}

void fill(Records& records, std::size_t count) {
  records.clear();
  for (std::size_t i = 0; i < count; ++i) {
    records.push_back(record(i));
  }
}

/// How many are not what was put there: from first to last, and back.
std::size_t wrong(const Records& records) {
  std::size_t wrong = 0;
  std::size_t at = 0;
  const auto differs = [](const RestRecord& found, std::size_t i) {
    const RestRecord put = record(i);
    return found.time == put.time && found.node == put.node && found.release == put.release ? 0U : 1U;
  };
  for (const RestRecord& found : records) {
    wrong += differs(found, at++);
  }
  for (std::size_t i = records.size(); i-- > 0;) {
    wrong += differs(records[i], i);
  }
  return wrong + (at == records.size() ? 0 : 1);
}

TEST(StepRecords, KeepTheirOrderAndHoldTwoBlocks) {
  const test::TemporaryFolder folder;
  Records records;
  records.set_folder(folder.path());
  for (const std::size_t count :
       {5 * kBlock + 7, std::size_t{0}, std::size_t{1}, kBlock - 1, kBlock, kBlock + 1, 2 * kBlock, 2 * kBlock + 1}) {
    fill(records, count);
    EXPECT_EQ(records.size(), count);
    EXPECT_EQ(wrong(records), 0U) << count;
    EXPECT_LE(records.held(), 2 * kBlock);
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path())) << "the file has no name";
}

TEST(StepRecords, StayInMemoryWhereTheDiskTakesNoMore) {
  const test::TemporaryFolder folder;
  Records records;
  records.set_folder(folder.path() + "/nowhere");
  fill(records, 3 * kBlock + 2);
  EXPECT_EQ(wrong(records), 0U);

  Records some;
  some.set_folder(folder.path());
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  rlimit limit = before;
  limit.rlim_cur = 2 * kBlock * sizeof(RestRecord) + 100;
  setrlimit(RLIMIT_FSIZE, &limit);
  fill(some, 5 * kBlock + 2);
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_GE(some.held(), 3 * kBlock) << "two blocks are in the file";
  EXPECT_EQ(wrong(some), 0U);
  fill(some, 5 * kBlock + 2);
  EXPECT_EQ(wrong(some), 0U);
  EXPECT_LE(some.held(), 2 * kBlock) << "in the next step there is room again";
}

TEST(ContactJournal, HoldsABlockOfMillionsOfImpacts) {
  const BeamChain beam{PETSC_COMM_WORLD, test::steel_beam(10)};
  ContactJournal journal{beam.points(), 2};
  constexpr std::size_t kImpacts = 200'000;
  std::vector<double> impulses(2, 0.0);
  double lost = 0.0;
  for (std::size_t i = 0; i < kImpacts; ++i) {
    const auto time = static_cast<double>(i % 1000);
    const auto support = static_cast<PetscInt>(i % 2);
    journal.record_impact(i % 11, {.time = time, .support = support, .impulse = 0.1 * time, .energy_loss = 0.3 * time});
    if (time < 500.0) {
      impulses[i % 2] += 0.1 * time;
      lost += 0.3 * time;
    }
  }
  std::vector<double> found(2, 0.0);
  journal.add_impulses(500.0, 1.0, found);
  EXPECT_EQ(found, impulses);
  EXPECT_EQ(journal.lost_before(500.0), lost);
  EXPECT_EQ(journal.impacts().size(), kImpacts);
  EXPECT_LE(journal.impacts().held(), 2 * StepRecords<ImpactRecord>::kBlock);
  journal.record_impact(0, {.time = 1.0, .support = 1, .impulse = 8.0, .energy_loss = 2.0});
  EXPECT_EQ(journal.lost_before(500.0), lost + 2.0) << "what comes later counts, too";
}

}  // namespace
}  // namespace udar
