// The bound on open calls, and their end.
#include "server/exec/open_calls.h"

#include <gtest/gtest.h>

namespace sightline::server::exec {
namespace {

TEST(CallRegistry, LetsInSoManyAtATime) {
  CallRegistry calls(2, "things", "TOO_MANY_THINGS");
  int a = 0, b = 0, c = 0;
  EXPECT_TRUE(calls.enter(&a, [] {}));
  EXPECT_TRUE(calls.enter(&b, [] {}));
  const Status refused = calls.enter(&c, [] {});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Code::kResourceExhausted);
  EXPECT_EQ(refused.error().reason, "TOO_MANY_THINGS");
  EXPECT_NE(refused.error().message.find("2 things are open on the server, the limit is 2"),
            std::string::npos);
  calls.leave(&a);
  EXPECT_TRUE(calls.enter(&c, [] {}));
}

TEST(CallRegistry, TellsThoseThatAreOpenAndLetsNoOtherIn) {
  CallRegistry calls(3, "things", "TOO_MANY_THINGS");
  int a = 0, b = 0;
  EXPECT_TRUE(calls.enter(&a, [&] { ++a; }));
  EXPECT_TRUE(calls.enter(&b, [&] { ++b; }));
  calls.leave(&b);
  calls.stop();
  calls.stop();
  EXPECT_EQ(a, 1);
  EXPECT_EQ(b, 0);
  EXPECT_EQ(calls.enter(&b, [] {}).error().code, Code::kUnavailable);
}

}  // namespace
}  // namespace sightline::server::exec
