// Ray batches and hits as messages.
#include "server/queries/query_codec.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

namespace sightline::server::queries {
namespace {

template <class T>
std::string column(std::vector<T> values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

template <class T>
std::vector<T> values(const std::string& column) {
  std::vector<T> out(column.size() / sizeof(T));
  std::memcpy(out.data(), column.data(), column.size());
  return out;
}

v1::Rays two_rays() {
  v1::Rays rays;
  rays.set_origins(column<float>({1, 2, 3, 4, 5, 6}));
  rays.set_directions(column<float>({0, 0, 1, 0, 1, 0}));
  return rays;
}

TEST(DecodeRays, FillsDefaults) {
  std::vector<accel::geometry::Ray> rays;
  ASSERT_TRUE(decode_rays(two_rays(), rays));
  ASSERT_EQ(rays.size(), 2u);
  EXPECT_EQ(rays[1].origin, (accel::geometry::Vec3d{4, 5, 6}));
  EXPECT_EQ(rays[1].direction, (accel::geometry::Vec3d{0, 1, 0}));
  EXPECT_EQ(rays[1].tmin, 0);
  EXPECT_EQ(rays[1].tmax, accel::geometry::kInfinity);
  EXPECT_EQ(rays[1].mask, accel::geometry::kAllMasks);
}

TEST(DecodeRays, ReadsDoublesAndEveryColumn) {
  v1::Rays columns;
  columns.set_float64(true);
  columns.set_origins(column<double>({0.1, 0.2, 0.3}));
  columns.set_directions(column<double>({1, 0, 0}));
  columns.set_tmin(column<double>({-1}));
  columns.set_tmax(column<double>({1e300}));
  columns.set_masks(column<std::uint32_t>({6}));
  std::vector<accel::geometry::Ray> rays(7);
  ASSERT_TRUE(decode_rays(columns, rays));
  ASSERT_EQ(rays.size(), 1u);
  EXPECT_EQ(rays[0].origin, (accel::geometry::Vec3d{0.1, 0.2, 0.3}));
  EXPECT_EQ(rays[0].tmin, -1);
  EXPECT_EQ(rays[0].tmax, 1e300);
  EXPECT_EQ(rays[0].mask, 6u);
}

TEST(DecodeRays, PassesNanToTheTracer) {
  v1::Rays columns = two_rays();
  columns.set_tmin(column<float>({std::numeric_limits<float>::quiet_NaN(), 0}));
  std::vector<accel::geometry::Ray> rays;
  ASSERT_TRUE(decode_rays(columns, rays));
  EXPECT_TRUE(std::isnan(rays[0].tmin));
}

TEST(DecodeRays, KeepsNothingOfTheBatchBefore) {
  v1::Rays columns = two_rays();
  columns.set_masks(column<std::uint32_t>({1, 2}));
  std::vector<accel::geometry::Ray> rays;
  ASSERT_TRUE(decode_rays(columns, rays));
  ASSERT_TRUE(decode_rays(two_rays(), rays));
  EXPECT_EQ(rays[0].mask, accel::geometry::kAllMasks);
}

TEST(DecodeRays, NamesTheColumnItsBytesAndTheExpectedBytes) {
  const auto message_with = [](auto edit) {
    v1::Rays columns = two_rays();
    edit(columns);
    std::vector<accel::geometry::Ray> rays;
    const Status status = decode_rays(columns, rays);
    EXPECT_FALSE(status);
    EXPECT_EQ(status.error().code, Code::kInvalidArgument);
    return status.error().message;
  };
  const auto origins = message_with([](v1::Rays& r) { r.set_origins(std::string(25, '\0')); });
  EXPECT_NE(origins.find("origins has 25 bytes, expected a multiple of 12"), std::string::npos)
      << origins;
  const auto directions =
      message_with([](v1::Rays& r) { r.set_directions(std::string(12, '\0')); });
  EXPECT_NE(directions.find("directions has 12 bytes, expected 24"), std::string::npos)
      << directions;
  const auto tmin = message_with([](v1::Rays& r) { r.set_tmin(std::string(4, '\0')); });
  EXPECT_NE(tmin.find("tmin has 4 bytes, expected 8"), std::string::npos) << tmin;
  const auto tmax = message_with([](v1::Rays& r) { r.set_tmax(std::string(16, '\0')); });
  EXPECT_NE(tmax.find("tmax has 16 bytes, expected 8"), std::string::npos) << tmax;
  const auto masks = message_with([](v1::Rays& r) { r.set_masks(std::string(7, '\0')); });
  EXPECT_NE(masks.find("masks has 7 bytes, expected 8"), std::string::npos) << masks;
}

TEST(DecodeRays, AcceptsTheLimitAndNoMore) {
  v1::Rays columns;
  columns.set_origins(std::string(kMaxRaysPerRequest * 12, '\0'));
  columns.set_directions(std::string(kMaxRaysPerRequest * 12, '\0'));
  std::vector<accel::geometry::Ray> rays;
  EXPECT_TRUE(decode_rays(columns, rays));
  columns.mutable_origins()->append(12, '\0');
  columns.mutable_directions()->append(12, '\0');
  const Status status = decode_rays(columns, rays);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, Code::kResourceExhausted);
  EXPECT_NE(status.error().message.find("16385 rays, the limit is 16384"), std::string::npos);
}

TEST(DecodeRays, ABatchMayBeEmpty) {
  std::vector<accel::geometry::Ray> rays(3);
  ASSERT_TRUE(decode_rays({}, rays));
  EXPECT_TRUE(rays.empty());
}

TEST(EncodeHits, WritesEveryColumn) {
  accel::geometry::Hit hit{
      .t = 2.5, .node = 7, .primitive = 3, .u = 0.25f, .v = 0.5f, .normal = {0, 0, 1}, .work = 12};
  hit.state = accel::geometry::HitState::kHit;
  const std::vector<accel::geometry::Hit> hits{hit, {}};
  const std::vector fields{v1::HIT_FIELD_T,           v1::HIT_FIELD_NODE,   v1::HIT_FIELD_PRIMITIVE,
                           v1::HIT_FIELD_BARYCENTRIC, v1::HIT_FIELD_NORMAL, v1::HIT_FIELD_HIT,
                           v1::HIT_FIELD_WORK};
  v1::CastRaysResponse reply;
  encode_hits(hits, fields, reply);
  ASSERT_EQ(reply.columns_size(), 7);
  EXPECT_EQ(values<double>(reply.columns(0).data()),
            (std::vector<double>{2.5, accel::geometry::kInfinity}));
  EXPECT_EQ(values<std::uint64_t>(reply.columns(1).data()), (std::vector<std::uint64_t>{7, 0}));
  EXPECT_EQ(values<std::uint32_t>(reply.columns(2).data()), (std::vector<std::uint32_t>{3, 0}));
  EXPECT_EQ(values<float>(reply.columns(3).data()), (std::vector<float>{0.25f, 0.5f, 0, 0}));
  EXPECT_EQ(values<float>(reply.columns(4).data()), (std::vector<float>{0, 0, 1, 0, 0, 0}));
  EXPECT_EQ(values<std::uint8_t>(reply.columns(5).data()), (std::vector<std::uint8_t>{1, 0}));
  EXPECT_EQ(values<std::uint32_t>(reply.columns(6).data()), (std::vector<std::uint32_t>{12, 0}));
}

TEST(EncodeHits, OverwritesAReusedReply) {
  v1::CastRaysResponse reply;
  encode_hits(std::vector<accel::geometry::Hit>(5),
              std::vector{v1::HIT_FIELD_T, v1::HIT_FIELD_NODE}, reply);
  encode_hits(std::vector<accel::geometry::Hit>(2), std::vector{v1::HIT_FIELD_HIT}, reply);
  ASSERT_EQ(reply.columns_size(), 1);
  EXPECT_EQ(reply.columns(0).field(), v1::HIT_FIELD_HIT);
  EXPECT_EQ(reply.columns(0).data().size(), 2u);
}

TEST(EncodeHits, TheLargestReplyStaysBelowAMebibyte) {
  std::vector<v1::HitField> fields;
  for (int f = v1::HitField_MIN + 1; f <= v1::HitField_MAX; ++f)
    fields.push_back(static_cast<v1::HitField>(f));
  v1::CastRaysResponse reply;
  encode_hits(std::vector<accel::geometry::Hit>(kMaxRaysPerRequest), fields, reply);
  EXPECT_LT(reply.ByteSizeLong() + 1024, std::size_t{1} << 20);
}

scenegraph::RayTally tally(std::uint32_t count, accel::geometry::HitState state,
                           bool cut_off = false) {
  return {.count = count, .work = 9, .state = state, .cut_off = cut_off};
}

TEST(EncodeTallies, WritesCounts) {
  const std::vector rays{tally(3, accel::geometry::HitState::kHit),
                         tally(0, accel::geometry::HitState::kMiss),
                         tally(scenegraph::kInvalidCount, accel::geometry::HitState::kInvalid)};
  const std::vector fields{v1::HIT_FIELD_COUNT, v1::HIT_FIELD_HIT, v1::HIT_FIELD_WORK};
  v1::CastRaysResponse reply;
  encode_tallies(rays, {}, fields, reply);
  EXPECT_EQ(values<std::uint32_t>(reply.columns(0).data()),
            (std::vector<std::uint32_t>{3, 0, 0xffffffff}));
  EXPECT_EQ(values<std::uint8_t>(reply.columns(1).data()), (std::vector<std::uint8_t>{1, 0, 2}));
  EXPECT_EQ(values<std::uint32_t>(reply.columns(2).data()), (std::vector<std::uint32_t>{9, 9, 9}));
}

TEST(EncodeTallies, WritesLists) {
  const std::vector rays{tally(2, accel::geometry::HitState::kHit, true),
                         tally(0, accel::geometry::HitState::kMiss),
                         tally(1, accel::geometry::HitState::kHit)};
  std::vector<accel::geometry::Hit> hits(3);
  for (std::size_t k = 0; k < 3; ++k) hits[k].t = static_cast<double>(k);
  const std::vector fields{v1::HIT_FIELD_OFFSET, v1::HIT_FIELD_HIT, v1::HIT_FIELD_T};
  v1::CastRaysResponse reply;
  encode_tallies(rays, hits, fields, reply);
  EXPECT_EQ(values<std::uint32_t>(reply.columns(0).data()),
            (std::vector<std::uint32_t>{0, 2, 2, 3}));
  EXPECT_EQ(values<std::uint8_t>(reply.columns(1).data()), (std::vector<std::uint8_t>{3, 0, 1}));
  EXPECT_EQ(values<double>(reply.columns(2).data()), (std::vector<double>{0, 1, 2}));
  encode_tallies({}, {}, fields, reply);
  EXPECT_EQ(values<std::uint32_t>(reply.columns(0).data()), std::vector<std::uint32_t>{0});
}

TEST(EncodeTallies, TheLargestListStaysBelowAMebibyte) {
  const std::vector fields{v1::HIT_FIELD_OFFSET, v1::HIT_FIELD_HIT,       v1::HIT_FIELD_T,
                           v1::HIT_FIELD_NODE,   v1::HIT_FIELD_PRIMITIVE, v1::HIT_FIELD_BARYCENTRIC,
                           v1::HIT_FIELD_NORMAL, v1::HIT_FIELD_WORK};
  v1::CastRaysResponse reply;
  encode_tallies(std::vector<scenegraph::RayTally>(kMaxRaysPerRequest),
                 std::vector<accel::geometry::Hit>(kMaxHitsPerReply), fields, reply);
  EXPECT_LT(reply.ByteSizeLong() + 1024, std::size_t{1} << 20);
}

}  // namespace
}  // namespace sightline::server::queries
