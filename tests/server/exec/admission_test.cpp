// The limit on work in flight.
#include "server/exec/admission.h"

#include <gtest/gtest.h>

#include <limits>
#include <utility>

namespace sightline::server::exec {
namespace {

TEST(Admission, CountsRaysAndBytesInFlight) {
  Admission admission({100, 1000});
  {
    const auto first = admission.admit(60, 500);
    ASSERT_TRUE(first);
    EXPECT_EQ(admission.in_flight().rays, 60u);
    EXPECT_EQ(admission.in_flight().bytes, 500u);
  }
  EXPECT_EQ(admission.in_flight().rays, 0u);
  EXPECT_EQ(admission.in_flight().bytes, 0u);
}

TEST(Admission, RefusesOverTheLimitAndNamesIt) {
  Admission admission({100, 1000});
  const auto first = admission.admit(60, 500);
  const auto second = admission.admit(41, 1);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, Code::kResourceExhausted);
  EXPECT_NE(second.error().message.find("60 rays"), std::string::npos);
  EXPECT_NE(second.error().message.find("41 more"), std::string::npos);
  EXPECT_NE(second.error().message.find("limit of 100"), std::string::npos);
  EXPECT_FALSE(admission.admit(1, 501));
  EXPECT_TRUE(admission.admit(40, 500));
}

TEST(Admission, SumsDoNotWrapAround) {
  Admission admission({100, 1000});
  const auto first = admission.admit(1, 1);
  EXPECT_FALSE(admission.admit(std::numeric_limits<std::uint64_t>::max(), 0));
  EXPECT_FALSE(admission.admit(0, std::numeric_limits<std::uint64_t>::max()));
}

const Caller kGreedy{"a", "a:1"}, kOther{"a", "a:2"}, kThird{"b", "b:1"};

TEST(Admission, AConnectionAloneMayUseUpTheLimit) {
  Admission admission({100, 1000});
  const auto all = admission.admit(kGreedy, 100, 1000);
  EXPECT_TRUE(all);
  EXPECT_FALSE(admission.admit(kGreedy, 1, 0));
}

TEST(Admission, AConnectionThatUsesUpTheLimitDoesNotShutOutOthers) {
  Admission admission({100, 1000});
  const auto all = admission.admit(kGreedy, 100, 1000);
  auto other = admission.admit(kOther, 15, 150);
  EXPECT_TRUE(other);
  EXPECT_TRUE(admission.admit(kThird, 10, 100)) << "the rest of the reserve";
  EXPECT_FALSE(admission.admit(kThird, 11, 100)) << "more than the reserve";
  EXPECT_FALSE(admission.admit(1, 0)) << "a request without a caller has no reserve";
  other = admission.admit(kOther, 5, 5);
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
  auto first = admission.admit(10, 10);
  Admission::Ticket ticket = std::move(*first);
  Admission::Ticket other = std::move(ticket);
  EXPECT_EQ(admission.in_flight().rays, 10u);
  other = {};
  EXPECT_EQ(admission.in_flight().rays, 0u);
}

}  // namespace
}  // namespace sightline::server::exec
