// The limit on work in flight.
#include "server/exec/admission.h"

#include <gtest/gtest.h>

#include <limits>
#include <utility>

namespace sightline::server::exec {
namespace {

const Caller kA{"a", "a:1"}, kB{"b", "b:1"};

TEST(Admission, CountsRaysAndBytesInFlight) {
  Admission admission({100, 1000});
  {
    const auto first = admission.admit(kA, 60, 500);
    ASSERT_TRUE(first);
    EXPECT_EQ(admission.in_flight().rays, 60u);
    EXPECT_EQ(admission.in_flight().bytes, 500u);
  }
  EXPECT_EQ(admission.in_flight().rays, 0u);
  EXPECT_EQ(admission.in_flight().bytes, 0u);
}

TEST(Admission, RefusesOverTheLimitAndNamesIt) {
  Admission admission({100, 1000});
  const auto first = admission.admit(kA, 60, 500);
  const auto second = admission.admit(kA, 41, 1);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, Code::kResourceExhausted);
  EXPECT_NE(second.error().message.find("60 rays"), std::string::npos);
  EXPECT_NE(second.error().message.find("41 more"), std::string::npos);
  EXPECT_NE(second.error().message.find("limit of 100"), std::string::npos);
  EXPECT_FALSE(admission.admit(kB, 1, 501));
  EXPECT_TRUE(admission.admit(kB, 40, 500));
}

TEST(Admission, SumsDoNotWrapAround) {
  Admission admission({100, 1000});
  const auto first = admission.admit(kA, 1, 1);
  EXPECT_FALSE(admission.admit(kA, std::numeric_limits<std::uint64_t>::max(), 0));
  EXPECT_FALSE(admission.admit(kA, 0, std::numeric_limits<std::uint64_t>::max()));
}

const Caller kGreedy{"a", "a:1"}, kOther{"a", "a:2"}, kThird{"b", "b:1"};

TEST(Admission, AConnectionAloneMayUseUpTheLimit) {
  Admission admission({100, 1000});
  const auto all = admission.admit(kGreedy, 100, 0);
  EXPECT_TRUE(all);
  EXPECT_FALSE(admission.admit(kGreedy, 1, 0));
}

TEST(Admission, AConnectionThatUsesUpTheLimitDoesNotShutOutOthers) {
  Admission admission({100, 1000});
  const auto all = admission.admit(kGreedy, 100, 0);
  auto other = admission.admit(kOther, 15, 0);
  EXPECT_TRUE(other);
  EXPECT_TRUE(admission.admit(kThird, 10, 0)) << "the rest of the reserve";
  EXPECT_FALSE(admission.admit(kThird, 11, 0)) << "more than the reserve";
  other = admission.admit(kOther, 5, 0);
  EXPECT_TRUE(other);
}

TEST(Admission, TheReserveIsForThoseWithinTheirShare) {
  Admission admission({100, 1000});
  const auto first = admission.admit(kGreedy, 45, 0), second = admission.admit(kOther, 55, 0);
  EXPECT_TRUE(admission.admit(kGreedy, 5, 0));
  EXPECT_FALSE(admission.admit(kGreedy, 6, 0)) << "above half";
  EXPECT_FALSE(admission.admit(kOther, 1, 0)) << "above half";
}

TEST(Admission, ConnectionsWithNothingInFlightHaveNoShare) {
  Admission admission({100, 1000});
  { const auto gone = admission.admit(kOther, 1, 1); }
  const auto all = admission.admit(kGreedy, 100, 0);
  EXPECT_FALSE(admission.admit(kGreedy, 1, 0));
  EXPECT_EQ(admission.in_flight().rays, 100u);
}

TEST(Admission, ATicketCanBeMovedAndIsReleasedOnce) {
  Admission admission({100, 1000});
  auto first = admission.admit(kA, 10, 10);
  Admission::Ticket ticket = std::move(*first);
  Admission::Ticket other = std::move(ticket);
  EXPECT_EQ(admission.in_flight().rays, 10u);
  other = {};
  EXPECT_EQ(admission.in_flight().rays, 0u);
}

TEST(Admission, OneClientCannotTakeAllBytes) {
  Admission admission({100, 1000});
  const auto first = admission.admit(kA, 0, 500);
  const auto second = admission.admit(kA, 0, 1);
  ASSERT_FALSE(second) << "a connection has a half";
  EXPECT_NE(second.error().message.find("your connection has 500 bytes"), std::string::npos);
  const auto third = admission.admit({"a", "a:2"}, 0, 250);
  EXPECT_TRUE(third);
  const auto fourth = admission.admit({"a", "a:3"}, 0, 1);
  ASSERT_FALSE(fourth) << "a principal has three quarters";
  EXPECT_NE(fourth.error().message.find("your address has 750 bytes"), std::string::npos);
  EXPECT_EQ(fourth.error().reason, kQueueFull);
  EXPECT_TRUE(admission.admit(kB, 0, 250));
}

TEST(Admission, ChargesTheMemoryAccount) {
  MemoryAccount memory(400);
  Admission admission({100, 1000}, &memory);
  {
    const auto first = admission.admit(kA, 0, 300);
    ASSERT_TRUE(first);
    EXPECT_EQ(memory.used(Held::kCalls), 300u);
    const auto second = admission.admit(kB, 0, 200);
    ASSERT_FALSE(second);
    EXPECT_EQ(second.error().reason, kMemoryBudget);
    EXPECT_EQ(admission.in_flight().bytes, 300u);
    EXPECT_FALSE(admission.admit(kA, 101, 50));
    EXPECT_EQ(memory.used(), 300u) << "what is refused is not charged";
  }
  EXPECT_EQ(memory.used(), 0u);
}

}  // namespace
}  // namespace sightline::server::exec
