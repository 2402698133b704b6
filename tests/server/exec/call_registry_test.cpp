// The limit on open calls, and the effect of stop().
#include "server/exec/call_registry.h"

#include <gtest/gtest.h>

namespace sightline::server::exec {
namespace {

CallKind things(std::size_t limit) {
  return {.limit = limit,
          .when_full = "{} things are open on the server",
          .full_reason = "TOO_MANY_THINGS",
          .when_stopped = "things are over"};
}

TEST(CallRegistry, RefusesCallsBeyondTheLimit) {
  CallRegistry calls(things(2));
  int a = 0, b = 0, c = 0;
  EXPECT_TRUE(calls.enter(&a, [] {}));
  EXPECT_TRUE(calls.enter(&b, {}));
  const Status refused = calls.enter(&c, [] {});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Code::kResourceExhausted);
  EXPECT_EQ(refused.error().reason, "TOO_MANY_THINGS");
  EXPECT_EQ(refused.error().message,
            "2 things are open on the server, the limit is 2; retry later");
  calls.leave(&c);
  calls.leave(&a);
  EXPECT_TRUE(calls.enter(&c, [] {}));
}

TEST(CallRegistry, StopsEachCallOnceAndRefusesNewCalls) {
  CallRegistry calls(things(3));
  int a = 0, b = 0, c = 0;
  EXPECT_TRUE(calls.enter(&a, [&] { ++a; }));
  EXPECT_TRUE(calls.enter(&b, [&] { ++b; }));
  EXPECT_TRUE(calls.enter(&c, {}));
  calls.leave(&b);
  EXPECT_FALSE(calls.stopped());
  calls.stop();
  calls.stop();
  EXPECT_TRUE(calls.stopped());
  EXPECT_EQ(a, 1);
  EXPECT_EQ(b, 0);
  const Status late = calls.enter(&b, [] {});
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().code, Code::kUnavailable);
  EXPECT_EQ(late.error().message, "things are over");
}

}  // namespace
}  // namespace sightline::server::exec
