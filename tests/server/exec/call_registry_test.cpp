// The limit on open calls, and the effect of stop().
#include "server/exec/call_registry.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace sightline::server::exec {
namespace {

const Caller kCallerA{"a", "a:1"}, kCallerB{"b", "b:1"};

CallKind things(std::size_t limit) {
  return {.limit = limit,
          .when_full = "{} things are open on the server",
          .full_reason = "TOO_MANY_THINGS",
          .when_stopped = "things are over",
          .shared = false};
}

TEST(CallRegistry, RefusesCallsBeyondTheLimit) {
  CallRegistry calls(things(2));
  int a = 0, b = 0, c = 0;
  EXPECT_TRUE(calls.enter(&a, kCallerA, {}));
  EXPECT_TRUE(calls.enter(&b, kCallerB, {}));
  const Status refused = calls.enter(&c, kCallerA, {});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Code::kResourceExhausted);
  EXPECT_EQ(refused.error().reason, "TOO_MANY_THINGS");
  EXPECT_EQ(refused.error().message,
            "2 things are open on the server, the limit is 2; retry later");
  calls.leave(&c);
  calls.leave(&a);
  EXPECT_TRUE(calls.enter(&c, kCallerA, {}));
}

TEST(CallRegistry, StopsEachCallOnceAndRefusesNewCalls) {
  CallRegistry calls(things(3));
  int a = 0, b = 0, c = 0;
  EXPECT_TRUE(calls.enter(&a, kCallerA, {.on_stop = [&] { ++a; }}));
  EXPECT_TRUE(calls.enter(&b, kCallerB, {.on_stop = [&] { ++b; }}));
  EXPECT_TRUE(calls.enter(&c, kCallerA, {}));
  calls.leave(&b);
  EXPECT_FALSE(calls.stopped());
  calls.stop();
  calls.stop();
  EXPECT_TRUE(calls.stopped());
  EXPECT_EQ(a, 1);
  EXPECT_EQ(b, 0);
  const Status late = calls.enter(&b, kCallerB, {});
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().code, Code::kUnavailable);
  EXPECT_EQ(late.error().message, "things are over");
}

TEST(CallRegistry, GivesEachCallerAShare) {
  CallKind kind = things(16);
  kind.shared = true;
  CallRegistry calls(kind);
  std::vector<int> keys(16);
  const auto enter = [&](int key, const std::string& principal, const std::string& port) {
    return calls.enter(&keys[static_cast<std::size_t>(key)], {principal, principal + port}, {});
  };
  EXPECT_TRUE(enter(0, "a", ":1"));
  EXPECT_TRUE(enter(1, "a", ":1"));
  const Status third = enter(2, "a", ":1");
  ASSERT_FALSE(third) << "a connection has an eighth";
  EXPECT_NE(third.error().message.find("your connection"), std::string::npos);
  for (int i = 2; i < 12; ++i) EXPECT_TRUE(enter(i, "a", std::to_string(i)));
  const Status more = enter(12, "a", "99");
  ASSERT_FALSE(more) << "a principal has three quarters";
  EXPECT_NE(more.error().message.find("your address"), std::string::npos);
  EXPECT_TRUE(enter(12, "b", ":1"));
}

TEST(CallRegistry, EndsCallsThatAreLateOnce) {
  CallRegistry calls(things(3));
  PeerWait late, patient;
  int ended = 0, other = 0;
  EXPECT_TRUE(calls.enter(&late, kCallerA, {.on_late = [&] { ++ended; }}, &late));
  EXPECT_TRUE(calls.enter(&patient, kCallerA, {.on_late = [&] { ++other; }}, &patient));
  const auto now = CallRegistry::Clock::now();
  calls.end_late(now + std::chrono::hours(1));
  EXPECT_EQ(ended, 0) << "it does not wait";
  late.begin(std::chrono::seconds(10));
  patient.begin(std::chrono::hours(2));
  calls.end_late(now);
  EXPECT_EQ(ended, 0);
  calls.end_late(now + std::chrono::hours(1));
  calls.end_late(now + std::chrono::hours(1));
  EXPECT_EQ(ended, 1);
  patient.end();
  calls.end_late(now + std::chrono::hours(9));
  EXPECT_EQ(other, 0) << "its peer has done its part";
  EXPECT_EQ(calls.open(), 2u) << "a call leaves by itself";
}

TEST(CallRegistry, TheCallThatHasWaitedLongestGivesWay) {
  CallKind kind = things(2);
  kind.gives_way = std::chrono::seconds(0);
  CallRegistry calls(kind);
  PeerWait first, second;
  int a = 0, b = 0, c = 0, d = 0;
  EXPECT_TRUE(calls.enter(&a, kCallerA, {.on_late = [&] { ++a; }}, &first));
  EXPECT_TRUE(calls.enter(&b, kCallerA, {.on_late = [&] { ++b; }}, &second));
  EXPECT_FALSE(calls.enter(&c, kCallerB, {})) << "none waits";
  first.begin(std::chrono::hours(1));
  second.begin(std::chrono::hours(1));
  EXPECT_TRUE(calls.enter(&c, kCallerB, {}));
  EXPECT_EQ(a, 1);
  EXPECT_EQ(b, 0);
  calls.leave(&a);
  EXPECT_TRUE(calls.enter(&d, kCallerB, {})) << "the second gives way too; a place is freed once";
  EXPECT_EQ(b, 1);
}

}  // namespace
}  // namespace sightline::server::exec
