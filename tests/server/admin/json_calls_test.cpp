// The time that a call in JSON asks for.
#include "server/admin/json_calls.h"

#include <gtest/gtest.h>

#include <chrono>

namespace sightline::server::admin {
namespace {

using std::chrono::nanoseconds;

TEST(JsonTimeout, IsInTheFormOfGrpc) {
  using namespace std::chrono_literals;
  EXPECT_EQ(*parse_timeout("7n"), 7ns);
  EXPECT_EQ(*parse_timeout("7u"), 7us);
  EXPECT_EQ(*parse_timeout("0250m"), 250ms);
  EXPECT_EQ(*parse_timeout("99999999S"), 99'999'999s);
  EXPECT_EQ(*parse_timeout("2M"), 2min);
  EXPECT_EQ(*parse_timeout("2H"), 2h);
  EXPECT_EQ(*parse_timeout("99999999H"), nanoseconds(24h * 365)) << "a year at most";
}

TEST(JsonTimeout, AnythingElseIsRefused) {
  for (const char* text : {"", "S", "5", "0S", "00000000n", "-1S", "+1S", "1.5S", "1 S", " 1S",
                           "123456789S", "1h", "1s", "1SS", "\xff"}) {
    const auto time = parse_timeout(text);
    ASSERT_FALSE(time) << text;
    EXPECT_EQ(time.error().reason, "BAD_TIMEOUT");
  }
}

}  // namespace
}  // namespace sightline::server::admin
