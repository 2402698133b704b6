// Numbers for people.
#include "client/load/report/text.h"

#include <gtest/gtest.h>

namespace sightline::client::load::report {
namespace {

TEST(ReportText, HasThreeDigitsAndAUnit) {
  EXPECT_EQ(short_number(0), "0");
  EXPECT_EQ(short_number(12), "12");
  EXPECT_EQ(short_number(999.6), "1 k");
  EXPECT_EQ(short_number(1'234'567), "1.23 M");
  EXPECT_EQ(bytes(12'300'000), "12.3 MB");
  EXPECT_EQ(duration(0.0123), "12.3 ms");
  EXPECT_EQ(duration(1.5e-6), "1.5 µs");
  EXPECT_EQ(duration(0), "0");
  EXPECT_EQ(duration(83), "83 s");
  EXPECT_EQ(percent(0.126), "13 %");
  EXPECT_EQ(percent(0.0126), "1.3 %");
  EXPECT_EQ(percent(0), "0 %");
}

TEST(ReportText, IsEscaped) {
  EXPECT_EQ(escape("<a href=\"x\">&"), "&lt;a href=&quot;x&quot;&gt;&amp;");
}

}  // namespace
}  // namespace sightline::client::load::report
