// The account of segments: the shares of principals in their number and bytes.
#include "server/segments/segment_account.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "server/exec/call_registry.h"

namespace sightline::server::segments {
namespace {

class SegmentAccountTest : public testing::Test {
 protected:
  exec::MemoryAccount memory_{std::uint64_t{64} << 20};
  SegmentAccount account_{memory_};
};

TEST_F(SegmentAccountTest, APrincipalHasAShareOfTheBytes) {
  const std::uint64_t all = memory_.limit() / kShareOfLimit;
  EXPECT_LT(account_.share(), all);
  auto most = account_.hold({"a", "a:1"}, account_.share());
  ASSERT_TRUE(most);
  const auto more = account_.hold({"a", "a:2"}, 1);
  ASSERT_FALSE(more);
  EXPECT_EQ(more.error().code, Code::kResourceExhausted);
  EXPECT_EQ(more.error().reason, exec::kMemoryBudget);
  EXPECT_NE(more.error().message.find(std::to_string(account_.share())), std::string::npos);
  EXPECT_TRUE(account_.hold({"b", "b:1"}, all - account_.share()));
  const auto beyond = account_.hold({"b", "b:1"}, all - account_.share() + 1);
  ASSERT_FALSE(beyond);
  EXPECT_EQ(memory_.used(), account_.share());
  *most = {};
  EXPECT_EQ(memory_.used(), 0u);
  EXPECT_TRUE(account_.hold({"a", "a:1"}, 1));
}

TEST_F(SegmentAccountTest, APrincipalHasAShareOfTheNumber) {
  const auto limits = exec::ShareLimits::of(kMaxSegments, exec::kConnectionCallShare);
  std::vector<SegmentAccount::Held> held;
  for (std::size_t i = 0; i < limits.principal; ++i) {
    const std::string connection = "a:" + std::to_string(i / limits.connection);
    auto one = account_.hold({"a", connection}, 1);
    ASSERT_TRUE(one) << i;
    held.push_back(std::move(*one));
  }
  EXPECT_EQ(account_.count(), limits.principal);
  const auto refused = account_.hold({"a", "a:new"}, 1);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Code::kResourceExhausted);
  EXPECT_EQ(refused.error().reason, kTooManySegments);
  EXPECT_NE(refused.error().message.find(std::to_string(limits.principal)), std::string::npos);
  EXPECT_TRUE(account_.hold({"b", "b:1"}, 1));
  held.pop_back();
  EXPECT_TRUE(account_.hold({"a", "a:new"}, 1));
  held.clear();
  EXPECT_EQ(account_.count(), 0u);
}

TEST_F(SegmentAccountTest, IsRefusedWhereTheBudgetIsUsedUp) {
  const auto others = memory_.record(exec::Held::kMeshes, memory_.limit());
  const auto refused = account_.hold({"a", "a:1"}, 4096);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, exec::kMemoryBudget);
  EXPECT_EQ(memory_.used(exec::Held::kSegments), 0u);
}

}  // namespace
}  // namespace sightline::server::segments
