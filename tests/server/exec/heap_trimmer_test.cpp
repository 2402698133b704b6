// When freed memory is returned to the system.
#include "server/exec/heap_trimmer.h"

#include <gtest/gtest.h>

namespace sightline::server::exec {
namespace {

constexpr std::uint64_t kMib = std::uint64_t{1} << 20;

TEST(HeapTrimmer, TrimsOnceAfterMuchWasFreed) {
  HeapTrimmer trimmer;
  EXPECT_FALSE(trimmer.observe(100 * kMib));
  EXPECT_FALSE(trimmer.observe(10 * kMib)) << "freeing may go on";
  EXPECT_TRUE(trimmer.observe(10 * kMib));
  EXPECT_FALSE(trimmer.observe(10 * kMib));
}

TEST(HeapTrimmer, LeavesALittleAlone) {
  HeapTrimmer trimmer;
  EXPECT_FALSE(trimmer.observe(1000 * kMib));
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(trimmer.observe(990 * kMib));
  EXPECT_FALSE(trimmer.observe(900 * kMib));
  EXPECT_TRUE(trimmer.observe(901 * kMib)) << "what grows again does not put it off";
}

TEST(HeapTrimmer, CountsFromTheMostSinceTheLastTime) {
  HeapTrimmer trimmer;
  EXPECT_FALSE(trimmer.observe(64 * kMib));
  EXPECT_FALSE(trimmer.observe(32 * kMib));
  EXPECT_TRUE(trimmer.observe(32 * kMib));
  EXPECT_FALSE(trimmer.observe(31 * kMib));
  EXPECT_FALSE(trimmer.observe(31 * kMib)) << "of 32 MiB, one is little";
  EXPECT_FALSE(trimmer.observe(20 * kMib));
  EXPECT_TRUE(trimmer.observe(20 * kMib));
}

}  // namespace
}  // namespace sightline::server::exec
