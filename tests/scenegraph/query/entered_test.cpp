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

TEST(RecentlyEntered, RecordsTheLastFew) {
  RecentlyEntered recent;
  EXPECT_FALSE(recent.contains_or_add(3));
  EXPECT_TRUE(recent.contains_or_add(3));
  for (std::uint32_t id = 10; id < 18; ++id) EXPECT_FALSE(recent.contains_or_add(id));
  EXPECT_TRUE(recent.contains_or_add(17));
  EXPECT_FALSE(recent.contains_or_add(3));
}

}  // namespace
}  // namespace sightline::scenegraph::query
