// What the product's rule decides by lengths alone.
#include "accel/split/scan_split.h"

#include <gtest/gtest.h>

namespace sightline::accel::split {
namespace {

TEST(ScanSplit, DuplicationAndLengthDecideWhetherACellIsOverDuplicated) {
  EXPECT_TRUE(is_over_duplicated({.duplication = 3}, 64));
  EXPECT_FALSE(is_over_duplicated({.duplication = 3}, 63));
  EXPECT_FALSE(is_over_duplicated({.duplication = 1.9}, 100000));
}

TEST(ScanSplit, ClipsWhereOneInFourStraddlesInListsThatAreNotShort) {
  EXPECT_TRUE(scan_fast().clips(8, 32));
  EXPECT_FALSE(scan_fast().clips(7, 32));
  EXPECT_FALSE(scan_fast().clips(31, 31));
  EXPECT_TRUE(scan_fast().clips(250'000, 1'000'000));
  EXPECT_TRUE(scan_best().clips(1, 0));
}

}  // namespace
}  // namespace sightline::accel::split
