// The instances that a ray has entered.
#include "scenegraph/query/entered.h"

#include <gtest/gtest.h>

namespace sightline::scenegraph::query {
namespace {

TEST(EnteredOnce, RecordsEachUntilItIsCleared) {
  EnteredOnce entered;
  for (int ray = 0; ray < 5; ++ray) {
    entered.clear();
    for (std::uint32_t id = 0; id < 1000; ++id) ASSERT_TRUE(entered.add(id * 4096)) << id;
    for (std::uint32_t id = 0; id < 1000; ++id) ASSERT_FALSE(entered.add(id * 4096)) << id;
    EXPECT_TRUE(entered.add(0xffffffff));
  }
}

TEST(RecentLanes, RecordTheLastFew) {
  RecentLanes recent;
  EXPECT_EQ(recent.add(3, 0b0110), 0b0110u);
  EXPECT_EQ(recent.add(3, 0b0011), 0b0001u);
  EXPECT_EQ(recent.add(3, 0b0111), 0u);
  for (std::uint32_t id = 10; id < 26; ++id) EXPECT_EQ(recent.add(id, 1), 1u);
  EXPECT_EQ(recent.add(25, 1), 0u);
  EXPECT_EQ(recent.add(3, 0b0111), 0b0111u);
}

}  // namespace
}  // namespace sightline::scenegraph::query
