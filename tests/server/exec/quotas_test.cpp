// What each principal may use.
#include "server/exec/quotas.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

namespace sightline::server::exec {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr Quotas::Clock::time_point kNow{};
const Caller kAda{"ada", "ada:1"}, kBob{"bob", "bob:1"};

QuotaConfig everybody(const QuotaLimits& limits) { return {.others = limits, .principals = {}}; }

TEST(Quotas, WithoutAnyNothingIsCounted) {
  Quotas quotas({});
  std::vector<Quotas::Use> uses;
  for (int i = 0; i < 100; ++i) {
    auto use = quotas.begin_work(kAda, 1u << 30, 1u << 30);
    ASSERT_TRUE(use);
    uses.push_back(std::move(*use));
  }
  EXPECT_EQ(quotas.principals(), 0u);
  EXPECT_TRUE(quotas.tallies().empty());
}

TEST(Quotas, RaysASecondAreRefusedWithTheLimitAndTheWait) {
  Quotas quotas(everybody({1000, 0, 0, 0}));
  ASSERT_TRUE(quotas.begin_work(kAda, 3000, 0, kNow));
  const auto refused = quotas.begin_work(kAda, 1, 0, kNow);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Code::kResourceExhausted);
  EXPECT_EQ(refused.error().reason, kQuotaRays);
  for (const std::string part : {"ada", "rays-per-second", "1000", "2001 ms"})
    EXPECT_NE(refused.error().message.find(part), std::string::npos) << refused.error().message;
  EXPECT_TRUE(quotas.begin_work(kBob, 1, 0, kNow)) << "another principal has its own";
  EXPECT_TRUE(quotas.begin_work(kAda, 0, 50, kNow)) << "no rays";
  EXPECT_TRUE(quotas.begin_work(kAda, 1, 0, kNow + milliseconds(2001)));
}

TEST(Quotas, BytesASecond) {
  Quotas quotas(everybody({0, 100, 0, 0}));
  ASSERT_TRUE(quotas.begin_work(kAda, 1'000'000, 200, kNow));
  EXPECT_EQ(quotas.begin_work(kAda, 0, 1, kNow).error().reason, kQuotaBytes);
  EXPECT_TRUE(quotas.begin_work(kAda, 0, 1, kNow + seconds(2)));
}

TEST(Quotas, SpendingIsNoWork) {
  Quotas quotas(everybody({0, 100, 1, 0}));
  const auto work = quotas.begin_work(kAda, 0, 50, kNow);
  ASSERT_TRUE(work);
  EXPECT_TRUE(quotas.spend(kAda, 0, 60, kNow));
  EXPECT_EQ(quotas.spend(kAda, 0, 1, kNow).error().reason, kQuotaBytes);
}

TEST(Quotas, ARefusalTakesNothing) {
  Quotas quotas(everybody({100, 100, 0, 0}));
  ASSERT_TRUE(quotas.begin_work(kAda, 0, 200, kNow));
  for (int i = 0; i < 10; ++i) ASSERT_FALSE(quotas.begin_work(kAda, 100, 100, kNow));
  EXPECT_TRUE(quotas.begin_work(kAda, 100, 100, kNow + milliseconds(1001)));
}

TEST(Quotas, WorkAtATimeEndsWithItsUse) {
  Quotas quotas(everybody({0, 0, 2, 0}));
  auto first = quotas.begin_work(kAda, 1, 1, kNow);
  const auto second = quotas.begin_work(kAda, 1, 1, kNow);
  ASSERT_TRUE(first && second);
  EXPECT_EQ(quotas.begin_work(kAda, 1, 1, kNow).error().reason, kQuotaWork);
  EXPECT_TRUE(quotas.begin_work(kBob, 1, 1, kNow));
  *first = {};
  EXPECT_TRUE(quotas.begin_work(kAda, 1, 1, kNow));
}

TEST(Quotas, BytesStoredAreGivenBack) {
  Quotas quotas(everybody({0, 0, 0, 100}));
  auto stored = quotas.store(kAda, 60, kNow);
  ASSERT_TRUE(stored);
  const auto refused = quotas.store(kAda, 41, kNow);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, kQuotaStored);
  for (const std::string part : {"60", "100", "41"})
    EXPECT_NE(refused.error().message.find(part), std::string::npos) << refused.error().message;
  EXPECT_FALSE(quotas.store(kAda, ~std::uint64_t{0}, kNow)) << "must not wrap around";
  EXPECT_TRUE(quotas.store(kAda, 40, kNow));
  Quotas::Use moved = std::move(*stored);
  moved = {};
  EXPECT_TRUE(quotas.store(kAda, 100, kNow));
}

TEST(Quotas, NamedPrincipalsHaveTheirOwnLimitsAndTallies) {
  Quotas quotas({.others = {10, 0, 0, 0}, .principals = {{"ada", {0, 0, 1, 0}}}});
  const auto work = quotas.begin_work(kAda, 1'000'000, 0, kNow);
  ASSERT_TRUE(work);
  EXPECT_FALSE(quotas.begin_work(kAda, 1, 0, kNow));
  EXPECT_TRUE(quotas.begin_work(kBob, 100, 0, kNow));
  EXPECT_FALSE(quotas.begin_work(kBob, 1, 0, kNow));
  EXPECT_FALSE(quotas.begin_work(kBob, 1, 0, kNow));
  const auto tallies = quotas.tallies();
  ASSERT_EQ(tallies.size(), 2u);
  EXPECT_EQ(tallies[0].principal, "others");
  EXPECT_EQ(tallies[0].quota, Quota::kRays);
  EXPECT_EQ(tallies[0].limit, 10u);
  EXPECT_EQ(tallies[0].refused, 2u);
  EXPECT_EQ(tallies[1].principal, "ada");
  EXPECT_EQ(tallies[1].quota, Quota::kWork);
  EXPECT_EQ(tallies[1].used, 1u);
  EXPECT_EQ(tallies[1].refused, 1u);
}

TEST(Quotas, ForgetsPrincipalsThatAreIdle) {
  Quotas quotas(everybody({1000, 0, 0, 0}));
  for (int i = 0; i < 10'000; ++i) {
    const std::string name = std::to_string(i);
    ASSERT_TRUE(quotas.begin_work({name, name}, 1, 1, kNow + seconds(i)));
  }
  EXPECT_LT(quotas.principals(), 200u);
}

TEST(Quotas, RemembersPrincipalsThatHoldSomething) {
  Quotas quotas(everybody({1000, 0, 0, 50}));
  std::vector<Quotas::Use> held;
  for (int i = 0; i < 200; ++i) {
    auto use = quotas.store({std::to_string(i), {}}, 50, kNow + seconds(i));
    ASSERT_TRUE(use);
    held.push_back(std::move(*use));
  }
  EXPECT_FALSE(quotas.store({"0", {}}, 1, kNow + seconds(1000)));
}

}  // namespace
}  // namespace sightline::server::exec
