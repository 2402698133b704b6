// Limits that make no sense are refused.
#include "server/store/limits.h"

#include <gtest/gtest.h>

namespace sightline::server::store {
namespace {

TEST(StoreLimits, AreGoodByDefault) { EXPECT_TRUE(StoreLimits().check().ok()); }

TEST(StoreLimits, NamesALimitOfNothing) {
  StoreLimits limits;
  limits.batches_in_flight = 0;
  const Status checked = limits.check();
  ASSERT_FALSE(checked.ok());
  EXPECT_EQ(checked.error().message, "batches_in_flight is 0, the least is 1");
}

}  // namespace
}  // namespace sightline::server::store
