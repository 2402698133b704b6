// Hits as columns.
#include "server/queries/hit_codec.h"

#include <gtest/gtest.h>

#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "server/queries/derived_columns.h"
#include "server/queries/ray_codec.h"

namespace sightline::server::queries {
namespace {

/// Clients of gRPC take no larger message unless they are told to.
constexpr std::size_t kMessageOfGrpc = std::size_t{4} << 20;

template <class T>
std::vector<T> values(const std::string& column) {
  std::vector<T> out(column.size() / sizeof(T));
  std::memcpy(out.data(), column.data(), column.size());
  return out;
}

void encode_hits(std::span<const accel::geometry::Hit> hits, std::size_t first,
                 v1::CastRaysResponse& reply) {
  const accel::geometry::HitColumns columns = view_hits(reply, first, hits.size());
  for (std::size_t i = 0; i < hits.size(); ++i) columns.set(i, hits[i]);
}

/// All hits at once.
void encode_all(std::span<const accel::geometry::Hit> hits, std::span<const v1::HitField> fields,
                v1::CastRaysResponse& reply) {
  resize_columns(fields, hits.size(), hits.size(), reply);
  encode_hits(hits, 0, reply);
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
  encode_all(hits, fields, reply);
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
  encode_all(std::vector<accel::geometry::Hit>(5), std::vector{v1::HIT_FIELD_T, v1::HIT_FIELD_NODE},
             reply);
  encode_all(std::vector<accel::geometry::Hit>(2), std::vector{v1::HIT_FIELD_HIT}, reply);
  ASSERT_EQ(reply.columns_size(), 1);
  EXPECT_EQ(reply.columns(0).field(), v1::HIT_FIELD_HIT);
  EXPECT_EQ(reply.columns(0).data().size(), 2u);
}

TEST(EncodeHits, TheLargestReplyAndItsNamesFitAMessage) {
  std::vector<v1::HitField> fields;
  for (int f = v1::HitField_MIN + 1; f <= v1::HitField_MAX; ++f)
    fields.push_back(static_cast<v1::HitField>(f));
  v1::CastRaysResponse reply;
  encode_all(std::vector<accel::geometry::Hit>(kMaxRaysPerRequest), fields, reply);
  EXPECT_LT(reply.ByteSizeLong() + kMaxNameBytes + 1024, kMessageOfGrpc);
}

TEST(EncodeHits, ABitIsARay) {
  using accel::geometry::HitState;
  std::vector<accel::geometry::Hit> hits(11);
  for (const std::size_t i : {0u, 3u, 7u, 8u, 10u}) hits[i].state = HitState::kHit;
  hits[9].state = HitState::kInvalid;
  v1::CastRaysResponse reply;
  encode_all(hits, std::vector{v1::HIT_FIELD_HIT_BITS}, reply);
  EXPECT_EQ(values<std::uint8_t>(reply.columns(0).data()),
            (std::vector<std::uint8_t>{0b10001001, 0b101}));
}

TEST(EncodeHits, SlicesMakeTheSameColumnsAsOneBatch) {
  std::vector<accel::geometry::Hit> hits(29);
  for (std::size_t i = 0; i < hits.size(); ++i) {
    hits[i].t = static_cast<double>(i);
    hits[i].node = i;
    if (i % 3 == 0) hits[i].state = accel::geometry::HitState::kHit;
  }
  const std::vector fields{v1::HIT_FIELD_T, v1::HIT_FIELD_NODE, v1::HIT_FIELD_NORMAL,
                           v1::HIT_FIELD_HIT_BITS};
  v1::CastRaysResponse whole, sliced;
  encode_all(hits, fields, whole);
  resize_columns(fields, hits.size(), hits.size(), sliced);
  const std::span all(hits);
  encode_hits(all.first(16), 0, sliced);
  encode_hits(all.subspan(16, 8), 16, sliced);
  encode_hits(all.subspan(24), 24, sliced);
  EXPECT_EQ(sliced.SerializeAsString(), whole.SerializeAsString());
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
  resize_columns(fields, rays.size(), rays.size(), reply);
  encode_tallies(rays, 0, reply);
  EXPECT_EQ(values<std::uint32_t>(reply.columns(0).data()),
            (std::vector<std::uint32_t>{3, 0, 0xffffffff}));
  EXPECT_EQ(values<std::uint8_t>(reply.columns(1).data()), (std::vector<std::uint8_t>{1, 0, 2}));
  EXPECT_EQ(values<std::uint32_t>(reply.columns(2).data()), (std::vector<std::uint32_t>{9, 9, 9}));
}

TEST(EncodeLists, WritesOffsetsAndRows) {
  const std::vector rays{tally(2, accel::geometry::HitState::kHit, true),
                         tally(0, accel::geometry::HitState::kMiss),
                         tally(1, accel::geometry::HitState::kHit)};
  std::vector<accel::geometry::Hit> hits(3);
  for (std::size_t k = 0; k < 3; ++k) hits[k].t = static_cast<double>(k);
  const std::vector fields{v1::HIT_FIELD_OFFSET, v1::HIT_FIELD_HIT, v1::HIT_FIELD_T};
  v1::CastRaysResponse reply;
  encode_lists(rays, hits, fields, reply);
  EXPECT_EQ(values<std::uint32_t>(reply.columns(0).data()),
            (std::vector<std::uint32_t>{0, 2, 2, 3}));
  EXPECT_EQ(values<std::uint8_t>(reply.columns(1).data()), (std::vector<std::uint8_t>{3, 0, 1}));
  EXPECT_EQ(values<double>(reply.columns(2).data()), (std::vector<double>{0, 1, 2}));
  encode_lists({}, {}, fields, reply);
  EXPECT_EQ(values<std::uint32_t>(reply.columns(0).data()), std::vector<std::uint32_t>{0});
}

TEST(EncodeLists, TheLargestReplyAndItsNamesFitAMessage) {
  const std::vector fields{v1::HIT_FIELD_OFFSET, v1::HIT_FIELD_HIT,       v1::HIT_FIELD_T,
                           v1::HIT_FIELD_NODE,   v1::HIT_FIELD_PRIMITIVE, v1::HIT_FIELD_BARYCENTRIC,
                           v1::HIT_FIELD_NORMAL, v1::HIT_FIELD_WORK,      v1::HIT_FIELD_POSITION,
                           v1::HIT_FIELD_NAME};
  v1::CastRaysResponse reply;
  encode_lists(std::vector<scenegraph::RayTally>(kMaxRaysPerRequest),
               std::vector<accel::geometry::Hit>(kMaxHitsPerReply), fields, reply);
  EXPECT_LT(reply.ByteSizeLong() + kMaxNameBytes + 1024, kMessageOfGrpc);
}

}  // namespace
}  // namespace sightline::server::queries
