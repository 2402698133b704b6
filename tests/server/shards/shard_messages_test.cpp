// Messages between servers that answer for shards: what is asked for sides, and which answers are
// taken.
#include "server/shards/shard_messages.h"

#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <vector>

namespace sightline::server::shards {
namespace {

using scenegraph::Side;
using scenegraph::SideQuestion;
using scenegraph::SideRule;

constexpr SideQuestion kWinding{SideRule::kWinding, 3}, kNormal{SideRule::kNormal, 1};

template <class T>
void add_column(HitColumns& columns, v1::HitField field, const std::vector<T>& values) {
  v1::HitColumn& column = *columns.Add();
  column.set_field(field);
  column.set_data(values.data(), values.size() * sizeof(T));
}

/// Of two points.
HitColumns answer_with(const std::vector<std::uint8_t>& sides,
                       const std::vector<std::int32_t>& crossings) {
  HitColumns columns;
  add_column(columns, v1::HIT_FIELD_INSIDE, sides);
  add_column(columns, v1::HIT_FIELD_CROSSINGS, crossings);
  return columns;
}

std::string refusal(const HitColumns& columns, const SideQuestion& question = kWinding) {
  const auto answer = decode_sides(columns, question, 2);
  if (answer) return "";
  EXPECT_EQ(answer.error().code, Code::kInternal);
  EXPECT_EQ(answer.error().reason, "SHARD_ANSWER");
  return answer.error().message;
}

TEST(ShardMessages, AskForCrossingsByTheSameRule) {
  v1::QueryPointsRequest asked;
  asked.set_scene("scenes/a");
  asked.set_root(5);
  asked.add_exclude(7);
  asked.add_only_labels()->set_key("storey");
  asked.add_exclude_labels()->set_value("glass");
  asked.set_build(v1::BUILD_MODE_NONE);
  asked.add_fields(v1::HIT_FIELD_VOTES);
  asked.set_side_rule(v1::SIDE_RULE_WINDING);
  asked.set_side_rays(3);
  const v1::QueryPointsRequest request = make_side_template(asked, kWinding);
  v1::QueryPointsRequest expected = asked;
  expected.set_kind(v1::QUERY_KIND_CLOSEST);
  expected.clear_fields();
  expected.add_fields(v1::HIT_FIELD_INSIDE);
  expected.add_fields(v1::HIT_FIELD_CROSSINGS);
  EXPECT_EQ(request.SerializeAsString(), expected.SerializeAsString());

  asked.set_side_rule(v1::SIDE_RULE_NORMAL);
  asked.clear_side_rays();
  const v1::QueryPointsRequest by_normal = make_side_template(asked, kNormal);
  ASSERT_EQ(by_normal.fields_size(), 1);
  EXPECT_EQ(by_normal.fields(0), v1::HIT_FIELD_INSIDE);
  EXPECT_EQ(by_normal.side_rule(), v1::SIDE_RULE_NORMAL);
}

TEST(ShardMessages, AskForNoSidesWhereNearestFacesAreMeant) {
  v1::QueryPointsRequest asked;
  asked.add_fields(v1::HIT_FIELD_SIGNED);
  asked.set_side_rule(v1::SIDE_RULE_WINDING);
  asked.set_side_rays(3);
  const v1::QueryPointsRequest request =
      make_template(asked, scenegraph::QueryKind::kClosest, false);
  EXPECT_EQ(request.side_rule(), v1::SIDE_RULE_UNSPECIFIED);
  EXPECT_EQ(request.side_rays(), 0u);
  for (const int field : request.fields()) EXPECT_LT(field, v1::HIT_FIELD_SIGNED);
}

TEST(ShardMessages, HaveSidesAndCrossings) {
  const auto answer = decode_sides(answer_with({1, 4}, {1, -2, 3, 0, 0, 0}), kWinding, 2);
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->sides, (std::vector{Side::kInside, Side::kUnanswered}));
  EXPECT_EQ(answer->crossings, (std::vector<std::uint32_t>{1, 0xfffffffeu, 3, 0, 0, 0}));
  HitColumns sides_alone;
  add_column(sides_alone, v1::HIT_FIELD_INSIDE, std::vector<std::uint8_t>{0, 2});
  const auto by_normal = decode_sides(sides_alone, kNormal, 2);
  ASSERT_TRUE(by_normal);
  EXPECT_EQ(by_normal->sides, (std::vector{Side::kOutside, Side::kInvalid}));
  EXPECT_TRUE(by_normal->crossings.empty());
}

TEST(ShardMessages, AreRefusedWithColumnsOfAnotherSize) {
  EXPECT_EQ(refusal(answer_with({0, 0}, {0, 0, 0, 0, 0})),
            "a shard's answer has 20 bytes of HIT_FIELD_CROSSINGS, expected 24");
  EXPECT_EQ(refusal(answer_with({0, 0}, {0, 0, 0, 0, 0, 0, 0})),
            "a shard's answer has 28 bytes of HIT_FIELD_CROSSINGS, expected 24");
  EXPECT_EQ(refusal(answer_with({0, 0, 0}, {0, 0, 0, 0, 0, 0})),
            "a shard's answer has 3 bytes of HIT_FIELD_INSIDE, expected 2");
  HitColumns sides_alone;
  add_column(sides_alone, v1::HIT_FIELD_INSIDE, std::vector<std::uint8_t>{0, 2});
  EXPECT_EQ(refusal(sides_alone),
            "a shard's answer has 0 bytes of HIT_FIELD_CROSSINGS, expected 24");
  EXPECT_EQ(refusal({}, kNormal), "a shard's answer has 0 bytes of HIT_FIELD_INSIDE, expected 2");
}

TEST(ShardMessages, AreRefusedWithSidesThatDoNotExist) {
  for (const std::uint8_t side : std::vector<std::uint8_t>{3, 5, 255})
    EXPECT_EQ(refusal(answer_with({0, side}, {0, 0, 0, 0, 0, 0})),
              "a shard's answer has sides that do not exist");
}

}  // namespace
}  // namespace sightline::server::shards
