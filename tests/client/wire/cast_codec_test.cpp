// Rays in requests, and answers that are not as they must be.
#include "client/wire/cast_codec.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

namespace sightline::client::wire {
namespace {

TEST(CastCodec, ARequestSaysHowManyRaysItsColumnsHold) {
  v1::Rays rays;
  resize_columns<float>(5, {}, rays);
  EXPECT_EQ(rays.count(), 5U);
  EXPECT_EQ(rays.origins().size(), 5 * 3 * sizeof(float));
  trim<float>(2, {}, rays);
  EXPECT_EQ(rays.count(), 2U);
  resize_columns<double>(7, {.interval = true, .masks = true}, rays);
  EXPECT_EQ(rays.count(), 7U);
  EXPECT_TRUE(rays.float64());
  EXPECT_EQ(rays.tmin().size(), 7 * sizeof(double));
}

TEST(CastCodec, ARequestSaysWhetherItMayBeAnsweredInPart) {
  v1::CastRaysRequest request;
  describe("projects/p/scenes/s", {.t = true}, {}, request);
  EXPECT_FALSE(request.allow_partial());
  EXPECT_EQ(request.time_budget_ms(), 0U);
  describe("projects/p/scenes/s", {.t = true},
           {.time_budget = std::chrono::milliseconds(1), .allow_partial = true}, request);
  EXPECT_TRUE(request.allow_partial());
  EXPECT_EQ(request.time_budget_ms(), 1U);
}

TEST(CastCodec, PointsAreDescribedAsRaysAre) {
  v1::Points points;
  resize_columns<float>(5, PointShape{.max_distance = true}, points);
  EXPECT_EQ(points.count(), 5U);
  EXPECT_EQ(points.max_distance().size(), 5 * sizeof(float));
  trim<float>(2, PointShape{.max_distance = true}, points);
  EXPECT_EQ(points.positions().size(), 2 * 3 * sizeof(float));
  v1::QueryPointsRequest request;
  describe("projects/p/scenes/s", {.t = true},
           {.kind = QueryKind::kAll, .root = 7, .max_hits = 3, .allow_partial = true}, request);
  EXPECT_EQ(request.kind(), v1::QUERY_KIND_ALL);
  EXPECT_EQ(request.fields_size(), 2) << "t and hit";
  EXPECT_EQ(request.root(), 7U);
  EXPECT_EQ(request.max_hits(), 3U);
  EXPECT_TRUE(request.allow_partial());
}

TEST(CastCodec, AnIncompleteAnswerNamesWhatWasAsked) {
  EXPECT_EQ(view_hits(v1::QueryPointsResponse(), {.t = true}, 3).error().message,
            "the server's answer to 3 points lacks a column, or rows of one");
}

v1::CastRaysResponse reply_with_names(const std::vector<std::uint32_t>& rows) {
  v1::CastRaysResponse reply;
  v1::HitColumn& column = *reply.add_columns();
  column.set_field(v1::HIT_FIELD_NAME);
  column.set_data(std::string(reinterpret_cast<const char*>(rows.data()), 4 * rows.size()));
  reply.add_names("");
  reply.add_names("door");
  return reply;
}

TEST(CastCodec, NamesAreRowsOfAList) {
  const auto reply = reply_with_names({1, 0, 1});
  const auto hits = view_hits(reply, {.name = true}, 3);
  ASSERT_TRUE(hits);
  EXPECT_EQ(hits->names[hits->name[0]], "door");
  EXPECT_EQ(hits->names[hits->name[1]], "");
}

TEST(CastCodec, ARowBeyondTheNamesIsAnError) {
  EXPECT_EQ(view_hits(reply_with_names({1, 2}), {.name = true}, 2).error().code, Code::kInternal);
  EXPECT_EQ(view_hits(reply_with_names({1}), {.name = true}, 2).error().code, Code::kInternal);
}

}  // namespace
}  // namespace sightline::client::wire
