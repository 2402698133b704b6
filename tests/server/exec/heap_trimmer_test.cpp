// When freed memory is returned to the system.
#include "server/exec/heap_trimmer.h"

#include <gtest/gtest.h>

namespace sightline::server::exec {
namespace {

constexpr std::uint64_t kMib = std::uint64_t{1} << 20;

TEST(HeapTrimmer, TrimsOnceAfterMuchWasFreed) {
  HeapTrimmer trimmer;
  EXPECT_FALSE(trimmer.observe(100 * kMib, 0));
  EXPECT_FALSE(trimmer.observe(10 * kMib, 0)) << "freeing may go on";
  EXPECT_TRUE(trimmer.observe(10 * kMib, 0));
  EXPECT_FALSE(trimmer.observe(10 * kMib, 0));
}

TEST(HeapTrimmer, LeavesALittleAlone) {
  HeapTrimmer trimmer;
  EXPECT_FALSE(trimmer.observe(1000 * kMib, 0));
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(trimmer.observe(990 * kMib, 0));
  EXPECT_FALSE(trimmer.observe(900 * kMib, 0));
  EXPECT_TRUE(trimmer.observe(901 * kMib, 0)) << "what grows again does not put it off";
}

TEST(HeapTrimmer, CountsFromTheMostSinceTheLastTime) {
  HeapTrimmer trimmer;
  EXPECT_FALSE(trimmer.observe(64 * kMib, 0));
  EXPECT_FALSE(trimmer.observe(32 * kMib, 0));
  EXPECT_TRUE(trimmer.observe(32 * kMib, 0));
  EXPECT_FALSE(trimmer.observe(31 * kMib, 0));
  EXPECT_FALSE(trimmer.observe(31 * kMib, 0)) << "of 32 MiB, one is little";
  EXPECT_FALSE(trimmer.observe(20 * kMib, 0));
  EXPECT_TRUE(trimmer.observe(20 * kMib, 0));
}

TEST(HeapTrimmer, ReturnsWhatBuildingTookForAWhile) {
  HeapTrimmer trimmer;
  EXPECT_FALSE(trimmer.observe(10 * kMib, 30 * kMib));
  EXPECT_FALSE(trimmer.observe(60 * kMib, 160 * kMib));
  for (std::uint64_t call = 1; call < HeapTrimmer::kSteadyCalls; ++call)
    EXPECT_FALSE(trimmer.observe(60 * kMib, 160 * kMib)) << "building may go on";
  EXPECT_TRUE(trimmer.observe(60 * kMib, 160 * kMib));
}

int passes(HeapTrimmer& trimmer, int calls, std::uint64_t held, std::uint64_t resident) {
  int count = 0;
  for (int call = 0; call < calls; ++call) count += trimmer.observe(held, resident) ? 1 : 0;
  return count;
}

TEST(HeapTrimmer, AsksEverMoreSeldomForWhatIsNotReturned) {
  HeapTrimmer trimmer;
  EXPECT_FALSE(trimmer.observe(10 * kMib, 30 * kMib));
  EXPECT_EQ(passes(trimmer, 4096, 10 * kMib, 160 * kMib), 10) << "after 4, 8, 16 and so on";
  // A flood's memory, in use at the last pass, was freed and is returned: the next is seen at once.
  EXPECT_EQ(passes(trimmer, 8192, 10 * kMib, 160 * kMib), 1);
  EXPECT_EQ(passes(trimmer, 16, 10 * kMib, 35 * kMib), 0);
  EXPECT_EQ(passes(trimmer, 4, 10 * kMib, 160 * kMib), 1);
}

TEST(HeapTrimmer, AsksAgainSoonWhereMemoryGrew) {
  HeapTrimmer trimmer;
  EXPECT_FALSE(trimmer.observe(10 * kMib, 30 * kMib));
  EXPECT_GT(passes(trimmer, 1024, 10 * kMib, 160 * kMib), 4);
  EXPECT_EQ(passes(trimmer, 4, 10 * kMib, 200 * kMib), 1);
}

TEST(HeapTrimmer, LeavesMemoryToThoseWhoBuild) {
  HeapTrimmer trimmer;
  for (std::uint64_t held = 10; held < 150; held += 10)
    EXPECT_FALSE(trimmer.observe(held * kMib, (2 * held + 100) * kMib));
}

TEST(HeapTrimmer, TheSystemSaysWhatIsResident) { EXPECT_GT(resident_bytes(), kMib); }

}  // namespace
}  // namespace sightline::server::exec
