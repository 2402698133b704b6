// Numbers as people read them.
#include "client/cli/amounts.h"

#include <gtest/gtest.h>

#include <limits>

namespace sightline::client::cli {
namespace {

TEST(Amounts, DigitsAreInThrees) {
  EXPECT_EQ(grouped(0), "0");
  EXPECT_EQ(grouped(999), "999");
  EXPECT_EQ(grouped(1000), "1,000");
  EXPECT_EQ(grouped(1234567), "1,234,567");
  EXPECT_EQ(grouped(std::numeric_limits<std::uint64_t>::max()), "18,446,744,073,709,551,615");
}

TEST(Amounts, SharesNeverReadAsNoneOrAllUnlessTheyAre) {
  EXPECT_EQ(part_of(0, 0), "0 of 0");
  EXPECT_EQ(part_of(0, 5000), "0 of 5,000 (0 %)");
  EXPECT_EQ(part_of(1, 75730), "1 of 75,730 (below 0.1 %)");
  EXPECT_EQ(part_of(1211, 75730), "1,211 of 75,730 (1.6 %)");
  EXPECT_EQ(part_of(75729, 75730), "75,729 of 75,730 (99.9 %)");
  EXPECT_EQ(part_of(75730, 75730), "75,730 of 75,730 (100 %)");
}

TEST(Amounts, BytesGoInThousands) {
  EXPECT_EQ(bytes_text(0), "0 B");
  EXPECT_EQ(bytes_text(999), "999 B");
  EXPECT_EQ(bytes_text(1000), "1.0 kB");
  EXPECT_EQ(bytes_text(999'949), "999.9 kB");
  EXPECT_EQ(bytes_text(999'950), "1.0 MB");
  EXPECT_EQ(bytes_text(81'036'012), "81.0 MB");
  EXPECT_EQ(bytes_text(12'000'000'000'000'000), "12000.0 TB");
}

}  // namespace
}  // namespace sightline::client::cli
