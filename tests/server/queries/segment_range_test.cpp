// Columns of segments: where they may be.
#include "server/queries/segment_range.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

namespace sightline::server::queries {
namespace {

constexpr std::uint64_t kSegment = 4096, kMost = std::numeric_limits<std::uint64_t>::max();

std::string reason(std::uint64_t begin, std::uint64_t bytes, std::size_t element) {
  const auto range = check_range("t", begin, bytes, element, kSegment);
  return range ? std::string() : range.error().reason;
}

TEST(SegmentRange, IsWithinTheSegment) {
  EXPECT_EQ(reason(0, kSegment, 8), "");
  EXPECT_EQ(reason(kSegment - 8, 8, 8), "");
  EXPECT_EQ(reason(kSegment, 0, 8), "");
  EXPECT_EQ(reason(kSegment, 8, 8), "COLUMN_OUTSIDE");
  EXPECT_EQ(reason(8, kSegment, 8), "COLUMN_OUTSIDE");
  EXPECT_EQ(reason(0, kSegment + 1, 1), "COLUMN_OUTSIDE");
  EXPECT_EQ(reason(kMost - 7, 8, 8), "COLUMN_OUTSIDE") << "the end wraps around to 0";
  EXPECT_EQ(reason(kMost - 7, 16, 8), "COLUMN_OUTSIDE");
  EXPECT_EQ(reason(0, kMost, 1), "COLUMN_OUTSIDE");
}

TEST(SegmentRange, BeginsAtAMultipleOfItsElement) {
  EXPECT_EQ(reason(4, 8, 4), "");
  EXPECT_EQ(reason(4, 8, 8), "COLUMN_ALIGNMENT");
  EXPECT_EQ(reason(1, 8, 1), "");
  EXPECT_EQ(reason(2, 8, 4), "COLUMN_ALIGNMENT");
}

TEST(SegmentRange, ErrorsNameTheColumnAndTheLimit) {
  const auto outside = check_range("normal", 4000, 200, 4, kSegment);
  ASSERT_FALSE(outside);
  EXPECT_EQ(outside.error().code, Code::kInvalidArgument);
  for (const char* part : {"normal", "4000", "200", "4096"})
    EXPECT_NE(outside.error().message.find(part), std::string::npos) << part;
}

TEST(SegmentRange, AreDisjoint) {
  const std::vector<SegmentRange> others{{"a", 16, 16}, {"empty", 64, 0}, {"b", 80, 8}};
  for (const SegmentRange& good : std::vector<SegmentRange>{
           {"c", 0, 16}, {"c", 32, 48}, {"c", 88, 1000}, {"c", 20, 0}, {"c", 60, 8}}) {
    EXPECT_TRUE(check_disjoint(good, others)) << good.begin;
  }
  for (const SegmentRange& bad : std::vector<SegmentRange>{
           {"c", 0, 17}, {"c", 31, 1}, {"c", 16, 16}, {"c", 0, 4096}, {"c", 87, 1}}) {
    const Status disjoint = check_disjoint(bad, others);
    ASSERT_FALSE(disjoint) << bad.begin;
    EXPECT_EQ(disjoint.error().reason, "COLUMNS_OVERLAP");
  }
}

}  // namespace
}  // namespace sightline::server::queries
