// Rays of segments at any offsets: what is accepted is within the segment, and is copied as it is.
#include "server/queries/shared_rays.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "server/queries/hit_codec.h"
#include "server/queries/ray_codec.h"
#include "server/queries/segment_answer.h"
#include "server/segments/segment.h"
#include "tests/support/random.h"

namespace sightline::server::queries {
namespace {

using tests::Random;

constexpr int kCases = 100'000;

class SharedRaysTest : public testing::Test {
 protected:
  /// Any number, most often one that nearly fits.
  std::uint64_t any(std::uint64_t near) {
    switch (random_.below(8)) {
      case 0:
        return random_.next();
      case 1:
        return ~std::uint64_t{0} - random_.below(64);
      case 2:
        return (std::uint64_t{1} << random_.below(64)) + random_.below(3) - 1;
      case 3:
        return near + 8 - random_.below(16);
      default:
        return random_.below(near + 1) / 8 * 8;
    }
  }

  static bool fits(std::uint64_t begin, std::uint64_t rows, std::size_t row, std::size_t element,
                   std::uint64_t segment) {
    if (begin % element != 0 || begin > segment) return false;
    return rows <= (segment - begin) / row;
  }

  Random random_{1};
  exec::MemoryAccount memory_{std::uint64_t{64} << 20};
  segments::SegmentAccount bytes_{memory_};
  const std::uint64_t size_ = 16 * segments::page_size();
  const std::shared_ptr<const segments::Segment> segment_ =
      *segments::Segment::make(size_, "a", *bytes_.hold({"a", "a:1"}, size_));
};

TEST_F(SharedRaysTest, AreAcceptedIfTheyAreWithinTheSegmentAndOnlyThen) {
  int accepted = 0;
  std::vector<double> copy;
  for (int i = 0; i < kCases; ++i) {
    v1::SharedRays message;
    message.set_float64(random_.below(2) == 0);
    const std::size_t real = message.float64() ? 8 : 4;
    message.set_count(random_.below(4) == 0 ? any(kMaxSharedRays) : random_.below(600));
    message.set_origins(any(size_));
    message.set_directions(any(size_));
    if (random_.below(2) == 0) message.set_tmin(any(size_));
    if (random_.below(2) == 0) message.set_tmax(any(size_));
    if (random_.below(2) == 0) message.set_masks(any(size_));
    const std::uint64_t n = message.count();
    const bool good = n <= kMaxSharedRays && fits(message.origins(), n, 3 * real, real, size_) &&
                      fits(message.directions(), n, 3 * real, real, size_) &&
                      (!message.has_tmin() || fits(message.tmin(), n, real, real, size_)) &&
                      (!message.has_tmax() || fits(message.tmax(), n, real, real, size_)) &&
                      (!message.has_masks() || fits(message.masks(), n, 4, 4, size_));
    const auto rays = SharedRays::decode(message, size_, kMaxSharedRays);
    ASSERT_EQ(rays.ok(), good) << message.ShortDebugString();
    if (!rays) continue;
    ++accepted;
    ASSERT_EQ(rays->size(), n);
    EXPECT_EQ(rays->copy(*segment_, 0, n, copy).size, n);
  }
  EXPECT_GT(accepted, kCases / 100);
}

TEST_F(SharedRaysTest, PointsToo) {
  int accepted = 0;
  std::vector<double> copy;
  for (int i = 0; i < kCases; ++i) {
    v1::SharedPoints message;
    message.set_float64(random_.below(2) == 0);
    const std::size_t real = message.float64() ? 8 : 4;
    message.set_count(random_.below(4) == 0 ? any(kMaxSharedRays) : random_.below(600));
    message.set_positions(any(size_));
    if (random_.below(2) == 0) message.set_max_distance(any(size_));
    if (random_.below(2) == 0) message.set_masks(any(size_));
    const std::uint64_t n = message.count();
    const bool good =
        n <= kMaxSharedRays && fits(message.positions(), n, 3 * real, real, size_) &&
        (!message.has_max_distance() || fits(message.max_distance(), n, real, real, size_)) &&
        (!message.has_masks() || fits(message.masks(), n, 4, 4, size_));
    const auto points = SharedRays::decode(message, size_, kMaxSharedRays);
    ASSERT_EQ(points.ok(), good) << message.ShortDebugString();
    if (!points) continue;
    ++accepted;
    EXPECT_EQ(points->copy(*segment_, 0, n, copy).size, n);
  }
  EXPECT_GT(accepted, kCases / 100);
}

TEST_F(SharedRaysTest, AnswersAreWrittenWithinTheSegmentAndDisjoint) {
  constexpr std::array kFields{v1::HIT_FIELD_T,       v1::HIT_FIELD_NODE, v1::HIT_FIELD_PRIMITIVE,
                               v1::HIT_FIELD_NORMAL,  v1::HIT_FIELD_HIT,  v1::HIT_FIELD_POSITION,
                               v1::HIT_FIELD_HIT_BITS};
  int accepted = 0;
  for (int i = 0; i < kCases; ++i) {
    CastQuery query;
    query.in_segment = true;
    v1::CastRaysRequest request;
    const std::uint64_t rays =
        random_.below(8) == 0 ? random_.below(kMaxSharedRays) : random_.below(300);
    const std::vector<SegmentRange> read{{"origins", random_.below(size_), random_.below(2000)}};
    struct Range {
      std::uint64_t begin, end;
    };
    std::vector<Range> ranges{{read[0].begin, read[0].end()}};
    bool good = true;
    const std::size_t first = random_.below(kFields.size());
    for (std::size_t k = 0; k <= random_.below(3); ++k) {
      const v1::HitField field = kFields[(first + k) % kFields.size()];
      v1::SharedColumn& column = *request.add_answer();
      column.set_field(field);
      column.set_offset(any(size_));
      query.fields.push_back(field);
      const std::size_t bytes = column_bytes(field, rays, rays);
      const Range range{column.offset(), column.offset() + bytes};
      good = good && fits(range.begin, bytes, 1, element_bytes(field), size_);
      for (const Range& other : ranges)
        good = good && (std::min(range.end, other.end) <= std::max(range.begin, other.begin) ||
                        range.begin == range.end || other.begin == other.end);
      ranges.push_back(range);
    }
    SegmentAnswer answer;
    const Status begun = answer.begin(request.answer(), query, rays, read, size_);
    ASSERT_EQ(begun.ok(), good) << rays << " " << request.ShortDebugString();
    if (!begun) continue;
    ++accepted;
    resize_columns(query.fields, rays, rays, answer.slice());
    answer.write(*segment_, 0, rays);
  }
  EXPECT_GT(accepted, kCases / 100);
}

TEST_F(SharedRaysTest, AreCopiedSliceBySlice) {
  std::array<float, 6> origins{0, 1, 2, 3, 4, 5}, directions{6, 7, 8, 9, 10, 11};
  const std::array<float, 2> tmax{12, 13};
  const std::array<std::uint32_t, 2> masks{14, 15};
  segment_->write(64, origins.data(), sizeof origins);
  segment_->write(128, directions.data(), sizeof directions);
  segment_->write(4, tmax.data(), sizeof tmax);
  segment_->write(16, masks.data(), sizeof masks);
  v1::SharedRays message;
  message.set_count(2);
  message.set_origins(64);
  message.set_directions(128);
  message.set_tmax(4);
  message.set_masks(16);
  const auto rays = SharedRays::decode(message, size_, 2);
  ASSERT_TRUE(rays);
  std::vector<double> copy;
  const auto view = rays->copy(*segment_, 1, 1, copy);
  const accel::geometry::Ray ray = view[0];
  segment_->write(64, directions.data(), sizeof directions);
  EXPECT_EQ(view[0].origin.x, 3) << "what is in the segment does not matter any more";
  EXPECT_EQ(ray.origin.z, 5);
  EXPECT_EQ(ray.direction.y, 10);
  EXPECT_EQ(ray.tmin, 0);
  EXPECT_EQ(ray.tmax, 13);
  EXPECT_EQ(ray.mask, 15u);
}

TEST_F(SharedRaysTest, TooManyAreRefusedWithTheLimit) {
  v1::SharedRays message;
  message.set_count(101);
  const auto rays = SharedRays::decode(message, size_, 100);
  ASSERT_FALSE(rays);
  EXPECT_EQ(rays.error().code, Code::kResourceExhausted);
  EXPECT_EQ(rays.error().reason, "TOO_MANY_RAYS");
  EXPECT_NE(rays.error().message.find("101"), std::string::npos);
  EXPECT_NE(rays.error().message.find("the limit is 100"), std::string::npos);
}

TEST(MaxSharedRays, LeavesRaysForOthers) {
  EXPECT_EQ(max_shared_rays(std::uint64_t{1} << 20), kMaxSharedRays);
  EXPECT_EQ(max_shared_rays(~std::uint64_t{0}), kMaxSharedRays);
  EXPECT_EQ(max_shared_rays(400'000), 100'000u);
  EXPECT_EQ(max_shared_rays(1), kMaxRaysPerRequest);
}

}  // namespace
}  // namespace sightline::server::queries
