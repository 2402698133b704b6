// Kinds of query, culling, roots and exclusions through a real server.
#include <grpcpp/client_context.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "server/queries/cast_job.h"
#include "server/queries/cast_query.h"
#include "server/queries/hit_codec.h"
#include "tests/server/queries/random_rays.h"
#include "tests/server/support/live_server.h"
#include "tests/support/brute_force.h"
#include "tests/support/kinds.h"
#include "tests/support/scenes.h"

namespace sightline::tests {
namespace {

/// Adds the rays of a reply of kind ALL that has T, NODE and PRIMITIVE.
void append_list(const v1::CastRaysResponse& reply, KindAnswers& answers) {
  const auto offsets = column_values<std::uint32_t>(reply, v1::HIT_FIELD_OFFSET);
  const auto states = column_values<std::uint8_t>(reply, v1::HIT_FIELD_HIT);
  const auto t = column_values<double>(reply, v1::HIT_FIELD_T);
  const auto node = column_values<std::uint64_t>(reply, v1::HIT_FIELD_NODE);
  const auto primitive = column_values<std::uint32_t>(reply, v1::HIT_FIELD_PRIMITIVE);
  ASSERT_EQ(offsets.size(), states.size() + 1);
  ASSERT_EQ(offsets.back(), t.size());
  for (std::size_t i = 0; i < states.size(); ++i) {
    answers.lists.push_back(
        {.count = offsets[i + 1] - offsets[i],
         .state = static_cast<accel::geometry::HitState>(states[i] == 3 ? 1 : states[i]),
         .cut_off = states[i] == 3});
  }
  for (std::size_t k = 0; k < t.size(); ++k) {
    accel::geometry::Hit hit;
    hit.t = t[k];
    hit.node = node[k];
    hit.primitive = primitive[k];
    hit.state = accel::geometry::HitState::kHit;
    answers.listed.push_back(hit);
  }
}

class KindsRpcTest : public LiveServer {
 protected:
  grpc::Status fail(const v1::CastRaysRequest& request) {
    v1::CastRaysResponse reply;
    return api_.cast(request, &reply);
  }

  /// One request for each kind; the list may take several replies.
  KindAnswers ask(v1::CastRaysRequest request, int* replies = nullptr) {
    KindAnswers answers;
    request.set_kind(v1::QUERY_KIND_CLOSEST);
    for (const auto field : {v1::HIT_FIELD_T, v1::HIT_FIELD_NODE, v1::HIT_FIELD_PRIMITIVE,
                             v1::HIT_FIELD_BARYCENTRIC, v1::HIT_FIELD_NORMAL, v1::HIT_FIELD_HIT})
      request.add_fields(field);
    answers.closest = decode_hits(api_.cast(request));
    for (accel::geometry::Hit& hit :
         answers.closest) {  // Clears the fields that the list does not have
      hit.u = hit.v = 0;
      hit.normal = {};
    }
    request.clear_fields();
    request.set_kind(v1::QUERY_KIND_ANY);
    for (const auto state : column_values<std::uint8_t>(api_.cast(request), v1::HIT_FIELD_HIT)) {
      answers.any.emplace_back();
      answers.any.back().state = static_cast<accel::geometry::HitState>(state);
    }
    request.set_kind(v1::QUERY_KIND_COUNT);
    request.add_fields(v1::HIT_FIELD_HIT);
    const v1::CastRaysResponse counted = api_.cast(request);
    const auto counts = column_values<std::uint32_t>(counted, v1::HIT_FIELD_COUNT);
    const auto states = column_values<std::uint8_t>(counted, v1::HIT_FIELD_HIT);
    for (std::size_t i = 0; i < counts.size(); ++i) {
      answers.counts.push_back(
          {.count = counts[i], .state = static_cast<accel::geometry::HitState>(states[i])});
    }
    request.clear_fields();
    stream_list(request, answers, replies);
    return answers;
  }

  void stream_list(v1::CastRaysRequest request, KindAnswers& answers, int* replies) {
    request.set_kind(v1::QUERY_KIND_ALL);
    grpc::ClientContext context;
    const auto stream = api_.rays->StreamCastRays(&context);
    v1::StreamCastRaysRequest message;
    message.set_chunk(7);
    *message.mutable_request() = request;
    ASSERT_TRUE(stream->Write(message));
    stream->WritesDone();
    v1::StreamCastRaysResponse reply;
    bool more = true;
    for (int count = 1; more && stream->Read(&reply); ++count) {
      EXPECT_EQ(reply.chunk(), 7u);
      EXPECT_EQ(reply.response().first_ray(), answers.lists.size());
      EXPECT_LT(reply.ByteSizeLong(), std::size_t{1} << 20);
      append_list(reply.response(), answers);
      more = reply.response().more();
      EXPECT_EQ(reply.response().has_stats(), !more);
      if (replies != nullptr) *replies = count;
    }
    EXPECT_FALSE(more);
    EXPECT_EQ(reply.response().stats().rays(), answers.lists.size());
    EXPECT_EQ(reply.response().stats().hits_found(), answers.listed.size());
    EXPECT_FALSE(stream->Read(&reply));
    EXPECT_TRUE(stream->Finish().ok());
  }
};

TEST_F(KindsRpcTest, AgreeWithEachOtherAndTheOracle) {
  const TestMesh soup = random_soup(2000, 0.1, 11);
  api_.make_scene(kScene, soup);
  const BruteForce oracle({PlacedMesh{soup.view()}});
  const auto rays = random_rays(3000, 4);
  for (const auto culling : {v1::CULLING_UNSPECIFIED, v1::CULLING_BACK, v1::CULLING_FRONT}) {
    v1::CastRaysRequest request = cast_request(kScene, rays);
    request.set_culling(culling);
    const KindAnswers answers = ask(request);
    EXPECT_EQ(contradiction(answers, server::queries::kDefaultMaxHits), "");
    const accel::geometry::Culling same =
        culling == v1::CULLING_BACK    ? accel::geometry::Culling::kBack
        : culling == v1::CULLING_FRONT ? accel::geometry::Culling::kFront
                                       : accel::geometry::Culling::kNone;
    const KindComparison compared = compare_kinds(rays, answers, oracle, {.culling = same});
    EXPECT_EQ(compared.mismatches, 0u) << compared.report();
    EXPECT_GT(compared.hits, 500u);
  }
}

TEST_F(KindsRpcTest, AListOfAnyLengthIsSplitIntoRepliesBelowAMebibyte) {
  api_.make_scene(kScene, duplicates(200));
  std::vector<accel::geometry::Ray> rays(3000, accel::geometry::Ray{{0.2, 0.2, 1}, {0, 0, -1}});
  for (std::size_t i = 0; i < rays.size(); i += 3) rays[i].origin.x = 5;  // Misses
  int replies = 0;
  const KindAnswers answers = ask(cast_request(kScene, rays), &replies);
  EXPECT_EQ(contradiction(answers, server::queries::kDefaultMaxHits), "");
  EXPECT_EQ(answers.listed.size(), 2000u * 200);
  EXPECT_GT(answers.listed.size(), server::queries::kFullList.hits) << "traced in several parts";
  EXPECT_GE(replies, 20);
}

TEST_F(KindsRpcTest, AStreamContinuesAfterALongList) {
  api_.make_scene(kScene, duplicates(200));
  grpc::ClientContext context;
  const auto stream = api_.rays->StreamCastRays(&context);
  v1::StreamCastRaysRequest message;
  *message.mutable_request() = cast_request(
      kScene,
      std::vector<accel::geometry::Ray>(500, accel::geometry::Ray{{0.2, 0.2, 1}, {0, 0, -1}}));
  message.mutable_request()->set_kind(v1::QUERY_KIND_ALL);
  for (std::uint64_t chunk = 0; chunk < 5; ++chunk) {
    message.set_chunk(chunk);
    ASSERT_TRUE(stream->Write(message));
  }
  stream->WritesDone();
  v1::StreamCastRaysResponse reply;
  std::vector<std::size_t> hits(5);
  while (stream->Read(&reply)) {
    ASSERT_LT(reply.chunk(), 5u);
    hits[reply.chunk()] += column_of(reply.response(), v1::HIT_FIELD_T).size() / sizeof(double);
  }
  EXPECT_TRUE(stream->Finish().ok());
  EXPECT_EQ(hits, std::vector<std::size_t>(5, 500 * 200));
}

TEST_F(KindsRpcTest, AClientThatAbandonsALongListDoesNotDelayOthers) {
  api_.make_scene(kScene, duplicates(200));
  for (int i = 0; i < 3; ++i) {
    grpc::ClientContext context;
    const auto stream = api_.rays->StreamCastRays(&context);
    v1::StreamCastRaysRequest message;
    *message.mutable_request() = cast_request(
        kScene,
        std::vector<accel::geometry::Ray>(10'000, accel::geometry::Ray{{0.2, 0.2, 1}, {0, 0, -1}}));
    message.mutable_request()->set_kind(v1::QUERY_KIND_ALL);
    ASSERT_TRUE(stream->Write(message));
    v1::StreamCastRaysResponse reply;
    ASSERT_TRUE(stream->Read(&reply));
    EXPECT_TRUE(reply.response().more());
    context.TryCancel();
    EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::CANCELLED);
  }
  EXPECT_EQ(api_.cast(cast_request(kScene, rays_downward(10))).stats().rays(), 10u);
}

TEST_F(KindsRpcTest, MarksTheRaysWhoseListWasCut) {
  api_.make_scene(kScene, duplicates(5));
  const accel::geometry::Ray hit{{0.2, 0.2, 1}, {0, 0, -1}}, miss{{5, 5, 1}, {0, 0, -1}},
      bad{{0, 0, 0}, {0, 0, 0}};
  v1::CastRaysRequest request = cast_request(kScene, std::vector{hit, miss, bad});
  request.set_kind(v1::QUERY_KIND_ALL);
  request.set_max_hits(4);
  v1::CastRaysResponse reply = api_.cast(request);
  EXPECT_FALSE(reply.more());
  EXPECT_EQ(column_of(reply, v1::HIT_FIELD_HIT), std::string("\3\0\2", 3));
  EXPECT_EQ(column_values<std::uint32_t>(reply, v1::HIT_FIELD_OFFSET),
            (std::vector<std::uint32_t>{0, 4, 4, 4}));
  EXPECT_EQ(column_values<std::uint32_t>(reply, v1::HIT_FIELD_PRIMITIVE),
            (std::vector<std::uint32_t>{0, 1, 2, 3}));
  EXPECT_EQ(reply.stats().rays_cut_off(), 1u);
  EXPECT_EQ(reply.stats().hits_found(), 4u);
  EXPECT_EQ(reply.stats().hits(), 1u);
  EXPECT_EQ(reply.stats().invalid(), 1u);
  request.set_max_hits(5);
  reply = api_.cast(request);
  EXPECT_EQ(column_of(reply, v1::HIT_FIELD_HIT), std::string("\1\0\2", 3));
  EXPECT_EQ(reply.stats().rays_cut_off(), 0u);
}

TEST_F(KindsRpcTest, OneReplyHoldsAtMostTheLimitOfHits) {
  api_.make_scene(kScene, planar_sheet(1));
  v1::CastRaysRequest request = cast_request(kScene, rays_downward(80));
  request.set_kind(v1::QUERY_KIND_ALL);
  EXPECT_EQ(api_.cast(request).stats().hits_found(), 80u);
  request = cast_request(kScene, rays_downward(81));
  request.set_kind(v1::QUERY_KIND_ALL);
  const grpc::Status status = fail(request);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(reason_of(status), "TOO_MANY_HITS");
  EXPECT_NE(status.error_message().find("20736 hits, the limit of one reply is 20480"),
            std::string::npos)
      << status.error_message();
  request.set_max_hits(1);
  EXPECT_EQ(api_.cast(request).stats().hits_found(), 81u);
}

TEST_F(KindsRpcTest, OneReplyHoldsAllHitsUpToTheLimit) {
  api_.make_scene(kScene, duplicates(256));
  v1::CastRaysRequest request = cast_request(
      kScene,
      std::vector<accel::geometry::Ray>(80, accel::geometry::Ray{{0.2, 0.2, 1}, {0, 0, -1}}));
  request.set_kind(v1::QUERY_KIND_ALL);
  const v1::CastRaysResponse reply = api_.cast(request);
  EXPECT_FALSE(reply.more());
  EXPECT_EQ(column_values<std::uint32_t>(reply, v1::HIT_FIELD_OFFSET).back(), 80u * 256);
  EXPECT_EQ(reply.stats().hits_found(), 80u * 256);
}

TEST_F(KindsRpcTest, AnEmptyBatchHasAnEmptyList) {
  api_.make_scene(kScene, planar_sheet(1));
  v1::CastRaysRequest request;
  request.set_scene(kScene);
  request.set_kind(v1::QUERY_KIND_ALL);
  const v1::CastRaysResponse reply = api_.cast(request);
  EXPECT_EQ(column_values<std::uint32_t>(reply, v1::HIT_FIELD_OFFSET),
            std::vector<std::uint32_t>{0});
  EXPECT_FALSE(reply.more());
}

TEST_F(KindsRpcTest, SeesOnlyNodesUnderTheRootWithoutExclusions) {
  // Node 1 has children 2 and 3: three sheets above each other.
  ASSERT_TRUE(api_.create(kScene).ok());
  const std::string sheet = api_.add_mesh(planar_sheet(1));
  const auto at = [](double z) {
    return scenegraph::model::Affine{{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, z}};
  };
  ASSERT_TRUE(api_.apply(kScene, {put_node(-1, sheet, 0, at(0)), put_node(-2, sheet, -1, at(1)),
                                  put_node(-3, sheet, -1, at(2))})
                  .ok());
  v1::CastRaysRequest request = cast_request(kScene, rays_downward(1));
  request.set_kind(v1::QUERY_KIND_COUNT);
  const auto count = [&] {
    return column_values<std::uint32_t>(api_.cast(request), v1::HIT_FIELD_COUNT)[0];
  };
  EXPECT_EQ(count(), 3u);
  request.set_root(2);
  EXPECT_EQ(count(), 1u);
  request.set_root(1);
  request.add_exclude(3);
  EXPECT_EQ(count(), 2u);
  request.add_exclude(1);
  EXPECT_EQ(count(), 0u);
  request.add_exclude(44);
  grpc::Status status = fail(request);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(status.error_message(), "excluded node 44 is not in revision 1");
  EXPECT_EQ(reason_of(status), "NODE_NOT_FOUND");
  request.clear_exclude();
  request.set_root(45);
  status = fail(request);
  EXPECT_EQ(status.error_message(), "root node 45 is not in revision 1");
  grpc::ClientContext context;
  const auto stream = api_.rays->StreamCastRays(&context);
  v1::StreamCastRaysRequest message;
  *message.mutable_request() = request;
  ASSERT_TRUE(stream->Write(message));
  v1::StreamCastRaysResponse reply;
  EXPECT_FALSE(stream->Read(&reply));
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::NOT_FOUND);
}

TEST_F(KindsRpcTest, LabelsSelectAtTheRevisionThatAnswers) {
  ASSERT_TRUE(api_.create(kScene).ok());
  const std::string sheet = api_.add_mesh(planar_sheet(1));
  const auto labelled = [&](std::int64_t id, const char* value) {
    v1::Update put = put_node(id, sheet);
    v1::Label& label = *put.mutable_put_node()->add_labels();
    label.set_key("class");
    label.set_value(value);
    return put;
  };
  ASSERT_TRUE(
      api_.apply(kScene, {labelled(-1, "window"), labelled(-2, "wall"), put_node(-3, sheet)}).ok());
  v1::CastRaysRequest request = cast_request(kScene, rays_downward(1));
  request.set_kind(v1::QUERY_KIND_COUNT);
  const auto count = [&] {
    return column_values<std::uint32_t>(api_.cast(request), v1::HIT_FIELD_COUNT)[0];
  };
  EXPECT_EQ(count(), 3u);
  v1::LabelMatch& match = *request.add_exclude_labels();
  match.set_key("class");
  EXPECT_EQ(count(), 1u);
  match.set_value("window");
  EXPECT_EQ(count(), 2u);
  *request.add_only_labels() = match;
  EXPECT_EQ(count(), 0u);
  request.clear_exclude_labels();
  EXPECT_EQ(count(), 1u);
  ASSERT_TRUE(api_.apply(kScene, {labelled(2, "window")}).ok());
  EXPECT_EQ(count(), 2u);
  request.mutable_only_labels(0)->clear_key();
  EXPECT_EQ(reason_of(fail(request)), "LABEL_KEY_EMPTY");
}

}  // namespace
}  // namespace sightline::tests
