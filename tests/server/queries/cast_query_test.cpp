// Decoding the query of a cast.
#include "server/queries/cast_query.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace sightline::server::queries {
namespace {

v1::CastRaysRequest request_of(v1::QueryKind kind) {
  v1::CastRaysRequest request;
  request.set_kind(kind);
  return request;
}

TEST(DecodeQuery, HasDefaults) {
  const auto query = decode_query(v1::CastRaysRequest{}, scenegraph::Growth::kFull);
  ASSERT_TRUE(query);
  EXPECT_EQ(query->kind, scenegraph::QueryKind::kClosest);
  EXPECT_EQ(query->growth, scenegraph::Growth::kFull);
  EXPECT_EQ(query->fields,
            (std::vector{v1::HIT_FIELD_T, v1::HIT_FIELD_NODE, v1::HIT_FIELD_PRIMITIVE}));
  EXPECT_FALSE(query->surface);
}

TEST(DecodeQuery, SurfaceIsComputedOnlyOnRequest) {
  for (const auto field : {v1::HIT_FIELD_BARYCENTRIC, v1::HIT_FIELD_NORMAL}) {
    v1::CastRaysRequest request;
    request.add_fields(field);
    EXPECT_TRUE(decode_query(request, scenegraph::Growth::kFull)->surface);
  }
}

TEST(DecodeQuery, ClosestAndAllHavePositionsAndNames) {
  for (const auto kind : {v1::QUERY_KIND_CLOSEST, v1::QUERY_KIND_ALL}) {
    v1::CastRaysRequest request = request_of(kind);
    EXPECT_FALSE(decode_query(request, {})->positions);
    request.add_fields(v1::HIT_FIELD_POSITION);
    EXPECT_TRUE(decode_query(request, {})->positions);
    EXPECT_FALSE(decode_query(request, {})->names);
    request.add_fields(v1::HIT_FIELD_NAME);
    EXPECT_TRUE(decode_query(request, {})->names);
    EXPECT_FALSE(decode_query(request, {})->surface);
    request.set_kind(v1::QUERY_KIND_ANY);
    EXPECT_EQ(decode_query(request, {}).error().reason, "FIELD_NOT_OF_KIND");
  }
}

TEST(DecodeQuery, AnyAnswersHitAndWork) {
  v1::CastRaysRequest request;
  request.set_kind(v1::QUERY_KIND_ANY);
  EXPECT_EQ(decode_query(request, {})->fields, std::vector{v1::HIT_FIELD_HIT});
  request.add_fields(v1::HIT_FIELD_WORK);
  EXPECT_EQ(decode_query(request, {})->fields,
            (std::vector{v1::HIT_FIELD_HIT, v1::HIT_FIELD_WORK}));
  request.add_fields(v1::HIT_FIELD_T);
  EXPECT_EQ(decode_query(request, {}).error().reason, "FIELD_NOT_OF_KIND");
}

TEST(DecodeQuery, BitsReplaceHitUnlessBothAreAsked) {
  v1::CastRaysRequest request = request_of(v1::QUERY_KIND_ANY);
  request.add_fields(v1::HIT_FIELD_HIT_BITS);
  EXPECT_EQ(decode_query(request, {})->fields, std::vector{v1::HIT_FIELD_HIT_BITS});
  request.add_fields(v1::HIT_FIELD_HIT);
  EXPECT_EQ(decode_query(request, {})->fields,
            (std::vector{v1::HIT_FIELD_HIT_BITS, v1::HIT_FIELD_HIT}));
  request.set_kind(v1::QUERY_KIND_COUNT);
  EXPECT_EQ(decode_query(request, {}).error().message,
            "QUERY_KIND_COUNT has no HIT_FIELD_HIT_BITS");
}

TEST(DecodeQuery, RefusesUnknownValues) {
  v1::CastRaysRequest kind, field, build, culling, twice, unspecified;
  kind.set_kind(static_cast<v1::QueryKind>(9));
  culling.set_culling(static_cast<v1::Culling>(9));
  field.add_fields(static_cast<v1::HitField>(99));
  build.set_build(static_cast<v1::BuildMode>(9));
  twice.add_fields(v1::HIT_FIELD_T);
  twice.add_fields(v1::HIT_FIELD_T);
  unspecified.add_fields(v1::HIT_FIELD_UNSPECIFIED);
  for (const auto& request : {kind, field, build, culling, twice, unspecified}) {
    const auto query = decode_query(request, scenegraph::Growth::kFirstTouch);
    ASSERT_FALSE(query);
    EXPECT_EQ(query.error().code, Code::kInvalidArgument);
  }
}

TEST(DecodeQuery, LazyIsFirstTouchUnlessThePolicyIsDemand) {
  using scenegraph::Growth;
  v1::CastRaysRequest request;
  for (const Growth policy : {Growth::kFirstTouch, Growth::kDemand, Growth::kFull}) {
    request.clear_build();
    EXPECT_EQ(decode_query(request, policy)->growth, policy);
    request.set_build(v1::BUILD_MODE_LAZY);
    EXPECT_EQ(decode_query(request, policy)->growth,
              policy == Growth::kDemand ? Growth::kDemand : Growth::kFirstTouch);
  }
}

TEST(DecodeQuery, CountAnswersCountAndHitAndWork) {
  v1::CastRaysRequest request = request_of(v1::QUERY_KIND_COUNT);
  EXPECT_EQ(decode_query(request, {})->kind, scenegraph::QueryKind::kCount);
  EXPECT_EQ(decode_query(request, {})->fields, std::vector{v1::HIT_FIELD_COUNT});
  request.add_fields(v1::HIT_FIELD_HIT);
  request.add_fields(v1::HIT_FIELD_COUNT);
  EXPECT_EQ(decode_query(request, {})->fields,
            (std::vector{v1::HIT_FIELD_HIT, v1::HIT_FIELD_COUNT}));
  request.add_fields(v1::HIT_FIELD_NODE);
  EXPECT_EQ(decode_query(request, {}).error().reason, "FIELD_NOT_OF_KIND");
}

TEST(DecodeQuery, AllAnswersOffsetsHitAndTheRequestedFields) {
  v1::CastRaysRequest request = request_of(v1::QUERY_KIND_ALL);
  EXPECT_EQ(decode_query(request, {})->fields,
            (std::vector{v1::HIT_FIELD_OFFSET, v1::HIT_FIELD_HIT, v1::HIT_FIELD_T,
                         v1::HIT_FIELD_NODE, v1::HIT_FIELD_PRIMITIVE}));
  EXPECT_EQ(decode_query(request, {})->max_hits, kDefaultMaxHits);
  request.add_fields(v1::HIT_FIELD_NORMAL);
  EXPECT_EQ(decode_query(request, {})->fields,
            (std::vector{v1::HIT_FIELD_OFFSET, v1::HIT_FIELD_HIT, v1::HIT_FIELD_NORMAL}));
  EXPECT_TRUE(decode_query(request, {})->surface);
  request.add_fields(v1::HIT_FIELD_COUNT);
  EXPECT_EQ(decode_query(request, {}).error().reason, "FIELD_NOT_OF_KIND");
}

TEST(DecodeQuery, OffsetsAndCountsBelongToOneKindEach) {
  for (const auto field : {v1::HIT_FIELD_OFFSET, v1::HIT_FIELD_COUNT}) {
    v1::CastRaysRequest request;
    request.add_fields(field);
    const auto query = decode_query(request, {});
    ASSERT_FALSE(query);
    EXPECT_EQ(query.error().message, "QUERY_KIND_CLOSEST has no " + v1::HitField_Name(field));
  }
}

TEST(DecodeQuery, DecodesCullingAndNodes) {
  v1::CastRaysRequest request;
  request.set_culling(v1::CULLING_FRONT);
  request.set_root(5);
  request.add_exclude(7);
  const auto query = decode_query(request, {});
  ASSERT_TRUE(query);
  EXPECT_EQ(query->culling, accel::geometry::Culling::kFront);
  EXPECT_EQ(query->root, 5u);
  EXPECT_EQ(query->excluded, std::vector<scenegraph::model::NodeId>{7});
  EXPECT_TRUE(query->selects());
  EXPECT_FALSE(decode_query(v1::CastRaysRequest{}, {})->selects());
}

TEST(DecodeQuery, NamesTheLimitThatIsExceeded) {
  v1::CastRaysRequest request = request_of(v1::QUERY_KIND_ALL);
  request.set_max_hits(kMaxMaxHits);
  EXPECT_EQ(decode_query(request, {})->max_hits, kMaxMaxHits);
  request.set_max_hits(kMaxMaxHits + 1);
  const auto hits = decode_query(request, {});
  ASSERT_FALSE(hits);
  EXPECT_EQ(hits.error().code, Code::kInvalidArgument);
  EXPECT_EQ(hits.error().message, "max_hits is 16385, the limit is 16384");

  v1::CastRaysRequest exclusions;
  for (int i = 1; i <= kMaxExclusions; ++i) exclusions.add_exclude(static_cast<unsigned>(i));
  EXPECT_TRUE(decode_query(exclusions, {}));
  exclusions.add_exclude(1);
  const auto excluded = decode_query(exclusions, {});
  ASSERT_FALSE(excluded);
  EXPECT_EQ(excluded.error().reason, "TOO_MANY_EXCLUSIONS");
  EXPECT_NE(excluded.error().message.find("4097 nodes are excluded, the limit is 4096"),
            std::string::npos);
}

TEST(DecodeQuery, DecodesLabels) {
  v1::QueryPointsRequest request;
  v1::LabelMatch& match = *request.add_exclude_labels();
  match.set_key("class");
  EXPECT_TRUE(decode_query(request, {})->selects());
  match.set_value("");
  EXPECT_TRUE(decode_query(request, {})->selects());
  request.clear_exclude_labels();
  request.add_only_labels()->set_key("class");
  EXPECT_TRUE(decode_query(request, {})->selects());
}

TEST(DecodeQuery, RefusesLabelsThatNoNodeCanHave) {
  v1::CastRaysRequest request;
  for (int i = 0; i < kMaxLabelMatches; ++i) request.add_only_labels()->set_key("class");
  EXPECT_TRUE(decode_query(request, {}));
  request.add_only_labels()->set_key("class");
  EXPECT_EQ(decode_query(request, {}).error().message,
            "only_labels has 65 labels, the limit is 64");
  EXPECT_EQ(decode_query(request, {}).error().reason, "TOO_MANY_LABELS");
  request.clear_only_labels();
  v1::LabelMatch& match = *request.add_exclude_labels();
  EXPECT_EQ(decode_query(request, {}).error().message, "exclude_labels: a label has an empty key");
  EXPECT_EQ(decode_query(request, {}).error().reason, "LABEL_KEY_EMPTY");
  match.set_key(std::string(65, 'k'));
  EXPECT_EQ(decode_query(request, {}).error().reason, "LABEL_KEY_TOO_LONG");
  match.set_key("class");
  match.set_value(std::string(257, 'v'));
  EXPECT_EQ(decode_query(request, {}).error().reason, "LABEL_VALUE_TOO_LONG");
  match.set_value("Ifc\nWindow");
  EXPECT_EQ(decode_query(request, {}).error().reason, "LABEL_CONTROL_CHARACTER");
}

TEST(DecodeQuery, OnlyKindAllHasALimitOfHits) {
  v1::CastRaysRequest request = request_of(v1::QUERY_KIND_COUNT);
  request.set_max_hits(5);
  EXPECT_EQ(decode_query(request, {}).error().reason, "LIMIT_NOT_OF_KIND");
}

v1::QueryPointsRequest crossings_of(v1::SideRule rule) {
  v1::QueryPointsRequest request;
  request.add_fields(v1::HIT_FIELD_INSIDE);
  request.add_fields(v1::HIT_FIELD_CROSSINGS);
  request.set_side_rule(rule);
  request.mutable_shard()->set_count(2);
  return request;
}

TEST(DecodeQuery, CrossingsAreOfAShard) {
  v1::QueryPointsRequest request = crossings_of(v1::SIDE_RULE_WINDING);
  request.set_side_rays(7);
  const auto query = decode_query(request, {});
  ASSERT_TRUE(query);
  EXPECT_TRUE(query->crossings && query->sides_alone);
  EXPECT_EQ(query->sides->rays, 7u);
  request.add_fields(v1::HIT_FIELD_SIGNED);
  EXPECT_FALSE(decode_query(request, {})->sides_alone);
  request.clear_shard();
  EXPECT_EQ(decode_query(request, {}).error().reason, "NO_SHARD_NAMED");
}

TEST(DecodeQuery, CrossingsAreOfRays) {
  const auto query = decode_query(crossings_of(v1::SIDE_RULE_NORMAL), {});
  ASSERT_FALSE(query);
  EXPECT_EQ(query.error().reason, "FIELD_NOT_OF_RULE");
  v1::CastRaysRequest rays;
  rays.add_fields(v1::HIT_FIELD_CROSSINGS);
  EXPECT_EQ(decode_query(rays, {}).error().reason, "FIELD_NOT_OF_KIND");
}

}  // namespace
}  // namespace sightline::server::queries
