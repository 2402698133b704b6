// Servers that each answer for a shard of a scene, compared with one that answers for all of it.
#include <grpcpp/client_context.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tests/server/replicas/shards.h"
#include "tests/server/support/fake_peers.h"
#include "tests/server/updates/update_stream.h"

namespace sightline::tests {
namespace {

using accel::geometry::Ray;
using scenegraph::model::Affine;

TEST_F(Shards, AnswerAsOneServer) {
  start_shards();
  make_grid();
  expect_as_one_server(rays());
}

TEST_F(Shards, AnswerPointsAsOneServer) {
  start_shards();
  make_grid();
  expect_near_as_one_server(rays());
  v1::QueryPointsRequest request = nearest_of(v1::QUERY_KIND_CLOSEST, rays());
  request.set_root(1);
  expect_as_one_server(request);
  request.clear_points();
  v1::PointGrid& grid = *request.mutable_grid();
  for (const double x : {-3, -3, 1}) grid.add_origin(x);
  for (const double x : {1.5, 0.0, 0.0}) grid.add_across(x);
  for (const double x : {0.0, 1.5, 0.0}) grid.add_down(x);
  grid.set_columns(18);
  grid.set_rows(18);
  expect_as_one_server(request);
}

TEST_F(Shards, AnswerAsOneServerWhereFacesCoincide) {
  start_shards();
  make_scene(12, [](int i) { return at(i % 3 == 0 ? -0.5 : 0, 0, 0); });
  std::vector<Ray> through = rays_downward(64);
  expect_as_one_server(through);
  expect_as_one_server(rays());
}

TEST_F(Shards, AnswerAsOneServerAfterUpdatesAtAnyOfThem) {
  start_shards();
  make_grid();
  for (std::size_t i = 0; i < 6; ++i) {
    v1::ApplyUpdatesResponse applied;
    ASSERT_TRUE(api(i % kServers)
                    .apply(kScene, {move_to(2 + i, 7.0 * static_cast<double>(i))}, &applied)
                    .ok());
    expect_as_one_server(rays(), applied.revision().token());
  }
}

TEST_F(Shards, AnswerAtTheRevisionThatTheUpdatesOfACastMake) {
  start_shards();
  make_grid();
  for (std::size_t i = 0; i < 9; ++i) {
    for (const auto& [kind, fields] : kFields) {
      v1::CastRaysRequest request = cast_of(kind, rays());
      *request.mutable_apply()->add_updates() = move_to(2 + i, 7.0 * static_cast<double>(i));
      v1::CastRaysResponse reply;
      const grpc::Status cast = api(i % kServers).cast(request, &reply);
      ASSERT_TRUE(cast.ok()) << cast.error_message();
      EXPECT_EQ(reply.served().token(), reply.applied().revision().token());
      request.clear_apply();
      const std::string token = reply.served().token();
      reply.clear_applied();
      std::string columns, expected;
      for (const v1::HitColumn& column : reply.columns()) columns += column.data();
      request.mutable_consistency()->set_at_least(token);
      v1::CastRaysResponse whole;
      ASSERT_TRUE(plain_->api().cast(request, &whole).ok());
      EXPECT_EQ(whole.served().token(), token);
      for (const v1::HitColumn& column : whole.columns()) expected += column.data();
      EXPECT_EQ(columns, expected) << v1::QueryKind_Name(kind) << " " << i;
    }
  }
  v1::CastRaysRequest of_shard = cast_of(v1::QUERY_KIND_CLOSEST, rays());
  of_shard.mutable_shard()->set_count(kServers);
  of_shard.mutable_apply();
  v1::CastRaysResponse reply;
  EXPECT_EQ(reason_of(api(0).cast(of_shard, &reply)), "UPDATES_FOR_SHARD");
}

TEST_F(Shards, AnswerAsOneServerForEachKindOfRequest) {
  start_shards();
  make_grid();
  v1::CastRaysRequest request = cast_of(v1::QUERY_KIND_CLOSEST, rays());
  request.set_root(1);
  expect_as_one_server(request);
  request.set_root(0);
  request.add_exclude(1);
  request.set_culling(v1::CULLING_BACK);
  request.set_build(v1::BUILD_MODE_FULL);
  expect_as_one_server(request);
  v1::LabelMatch& red = *request.add_only_labels();
  red.set_key("color");
  red.set_value("red");
  expect_as_one_server(request);
  request.mutable_exclude_labels()->Swap(request.mutable_only_labels());
  expect_as_one_server(request);
  request.clear_exclude_labels();
  request.mutable_rays()->clear_origins();
  request.set_root(9999);
  v1::CastRaysResponse reply;
  EXPECT_EQ(reason_of(api(0).cast(request, &reply)), "COLUMN_LENGTH");
  request = cast_of(v1::QUERY_KIND_ANY, {});
  request.set_root(9999);
  EXPECT_EQ(reason_of(api(0).cast(request, &reply)), "NODE_NOT_FOUND");

  request = cast_of(v1::QUERY_KIND_CLOSEST, {});
  request.clear_rays();
  v1::RayGenerator& generator = *request.mutable_generator();
  v1::SphericalScan& scan = *generator.mutable_scan();
  for (const double x : {-2.0, 9.0, 1.0}) scan.add_origin(x);
  for (const double x : {1.0, 0.0, 0.0}) scan.add_forward(x);
  for (const double x : {0.0, 1.0, 0.0}) scan.add_left(x);
  for (const double x : {0.0, 0.0, 1.0}) scan.add_up(x);
  for (const double x : {-1.0, 1.0}) scan.add_azimuth(x);
  for (const double x : {-0.5, 0.5}) scan.add_elevation(x);
  scan.set_columns(60);
  scan.set_rows(20);
  expect_as_one_server(request);
}

TEST_F(Shards, StreamAllHitsInPartsAsOneServer) {
  start_shards();
  make_grid();
  const auto stream = [](Api& api) {
    grpc::ClientContext context;
    const auto call = api.rays->StreamCastRays(&context);
    std::array<std::string, 3> columns;
    for (int batch = 0; batch < 2; ++batch) {
      v1::StreamCastRaysRequest request;
      *request.mutable_request() = cast_of(v1::QUERY_KIND_ALL, rays(300));
      request.mutable_request()->set_max_hits(200);
      EXPECT_TRUE(call->Write(request));
      v1::StreamCastRaysResponse reply;
      do {
        if (!call->Read(&reply)) break;
        columns[0] += column_of(reply.response(), v1::HIT_FIELD_T);
        columns[1] += column_of(reply.response(), v1::HIT_FIELD_NODE);
        columns[2] += column_of(reply.response(), v1::HIT_FIELD_PRIMITIVE);
      } while (reply.response().more());
      EXPECT_EQ(reply.response().stats().rays(), 300u);
    }
    call->WritesDone();
    EXPECT_TRUE(call->Finish().ok());
    return columns;
  };
  const auto whole = stream(plain_->api());
  EXPECT_FALSE(whole[0].empty());
  EXPECT_EQ(whole, stream(api(1))) << "parts may end at other rays";
}

TEST_F(Shards, BuildNoTreesButTheirOwn) {
  start_shards();
  ASSERT_TRUE(plain_->api().create(kScene).ok());
  std::vector<v1::Update> updates;
  for (int i = 0; i < 12; ++i) {  // each of a mesh of its own
    const float size = 1 + 0.01F * static_cast<float>(i);
    updates.push_back(
        put_node(-1 - i, plain_->api().add_mesh(cube(-size, size)), 0, at(4 * i, 0, 0)));
  }
  ASSERT_TRUE(plain_->api().apply(kScene, updates).ok());
  v1::CastRaysRequest request = cast_of(v1::QUERY_KIND_COUNT, rays());
  request.set_build(v1::BUILD_MODE_FULL);
  expect_as_one_server(request);
  for (std::size_t i = 0; i < kServers; ++i)
    EXPECT_EQ(api(i).stats(kScene).triangles_built(), 4 * 12u) << "a third of them";
}

TEST_F(Shards, AnswerForOneShardWhereThatIsAsked) {
  start_shards();
  make_grid();
  std::vector<std::uint32_t> counts(500);
  v1::CastRaysRequest request = cast_of(v1::QUERY_KIND_COUNT, rays());
  v1::CastRaysResponse reply;
  request.mutable_shard()->set_count(kServers);
  for (std::uint32_t i = 0; i < kServers; ++i) {
    request.mutable_shard()->set_index(i);
    ASSERT_TRUE(api(0).cast(request, &reply).ok());
    const auto part = column_values<std::uint32_t>(reply, v1::HIT_FIELD_COUNT);
    for (std::size_t k = 0; k < part.size(); ++k) counts[k] += part[k];
  }
  request.clear_shard();
  ASSERT_TRUE(plain_->api().cast(request, &reply).ok());
  const auto whole = column_values<std::uint32_t>(reply, v1::HIT_FIELD_COUNT);
  for (std::size_t k = 5; k < whole.size(); ++k) EXPECT_EQ(whole[k], counts[k]) << k;

  request.mutable_shard()->set_count(kServers);
  EXPECT_EQ(reason_of(plain_->api().cast(request, &reply)), "SHARDS_DIFFER");
  request.mutable_shard()->set_cut(1);
  EXPECT_EQ(reason_of(api(0).cast(request, &reply)), "SHARD_CUT_DIFFERS");
  request.mutable_shard()->set_index(kServers);
  EXPECT_EQ(reason_of(api(0).cast(request, &reply)), "BAD_SHARD");
}

TEST_F(Shards, OfferNoSegments) {
  start_shards();
  make_grid();
  grpc::ClientContext info_context, open_context;
  v1::GetServerInfoResponse info;
  ASSERT_TRUE(api(0).server->GetServerInfo(&info_context, {}, &info).ok());
  EXPECT_EQ(info.max_segment_bytes(), 0u);
  v1::OpenSegmentRequest open;
  open.set_bytes(4096);
  v1::OpenSegmentResponse opened;
  const auto call = api(0).rays->OpenSegment(&open_context, open);
  EXPECT_FALSE(call->Read(&opened));
  EXPECT_EQ(reason_of(call->Finish()), "SEGMENTS_NOT_OFFERED");
  v1::CastRaysRequest request = cast_of(v1::QUERY_KIND_CLOSEST, rays());
  request.set_segment("0");
  v1::CastRaysResponse reply;
  EXPECT_EQ(reason_of(api(0).cast(request, &reply)), "SEGMENTS_NOT_OFFERED");
}

TEST_F(Shards, ALostOneIsAnErrorOrLeavesRaysUnanswered) {
  start_shards();
  make_grid();
  const std::vector<Ray> cast = rays();
  expect_as_one_server(cast);
  servers_[1].reset();
  for (const auto& [kind, fields] : kFields) {
    v1::CastRaysRequest request = cast_of(kind, cast);
    v1::CastRaysResponse partial, whole;
    const grpc::Status lost = api(0).cast(request, &partial);
    EXPECT_EQ(lost.error_code(), grpc::StatusCode::UNAVAILABLE);
    EXPECT_EQ(reason_of(lost), "SHARD_LOST");
    request.set_allow_partial(true);
    const grpc::Status marked = api(0).cast(request, &partial);
    ASSERT_TRUE(marked.ok()) << marked.error_message();
    ASSERT_TRUE(plain_->api().cast(request, &whole).ok());
    std::uint64_t unanswered = 0;
    const auto is_marked = [&](std::size_t ray) {
      return (static_cast<unsigned char>(partial.unanswered()[ray / 8]) >> ray % 8 & 1) != 0;
    };
    ASSERT_EQ(partial.unanswered().size(), (cast.size() + 7) / 8);
    const auto some = column_values<double>(partial, v1::HIT_FIELD_T),
               all = column_values<double>(whole, v1::HIT_FIELD_T);
    for (std::size_t i = 0; i < cast.size(); ++i) {
      unanswered += is_marked(i) ? 1u : 0u;
      if (kind != v1::QUERY_KIND_CLOSEST) continue;
      if (is_marked(i)) {
        EXPECT_EQ(some[i], -INFINITY);
      } else {
        EXPECT_TRUE(some[i] == all[i] || (std::isnan(some[i]) && std::isnan(all[i]))) << i;
      }
    }
    EXPECT_GT(unanswered, 0u);
    EXPECT_LT(unanswered, cast.size());
    EXPECT_EQ(partial.stats().unanswered(), unanswered);
    EXPECT_EQ(partial.stats().rays(), cast.size());
  }
  start_shard(1);
  wait_until([&] {
    v1::CastRaysResponse reply;
    return api(0).cast(cast_of(v1::QUERY_KIND_ANY, cast), &reply).ok();
  });
  expect_as_one_server(cast);
}

TEST_F(Shards, AMuteOneHoldsACallNoLongerThanItsCallerWaits) {
  const MutePeer mute(sockets_.path("s2"));
  start_shard(0);
  start_shard(1);
  make_grid();
  for (int i = 0; i < 3; ++i) {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + std::chrono::milliseconds(300));
    v1::CastRaysResponse reply;
    const grpc::Status cast =
        api(0).rays->CastRays(&context, cast_of(v1::QUERY_KIND_COUNT, rays()), &reply);
    EXPECT_NE(cast.error_code(), grpc::StatusCode::OK);
  }
  servers_[0].reset();  // would wait for calls that do not end
}

/// Rays without an answer.
std::uint64_t unanswered(Api& api, const v1::CastRaysRequest& request) {
  v1::CastRaysResponse reply;
  const grpc::Status cast = api.cast(request, &reply);
  EXPECT_TRUE(cast.ok()) << cast.error_message();
  return reply.stats().unanswered();
}

TEST_F(Shards, AMuteOneIsLostAndFoundAgain) {
  std::optional<MutePeer> mute(sockets_.path("s2"));
  start_shard(0);
  start_shard(1);
  make_grid();
  v1::CastRaysRequest request = cast_of(v1::QUERY_KIND_CLOSEST, rays());
  v1::CastRaysResponse reply;
  for (int i = 0; i < 2; ++i) EXPECT_EQ(reason_of(api(0).cast(request, &reply)), "SHARD_LOST");
  grpc::ClientContext context;
  v1::PrefetchRequest prefetch;
  prefetch.set_scene(kScene);
  v1::PrefetchResponse report;
  const auto call = api(0).rays->Prefetch(&context, prefetch);
  while (call->Read(&report)) {
  }
  EXPECT_EQ(reason_of(call->Finish()), "SHARD_LOST");
  request.set_allow_partial(true);
  const std::uint64_t lost = unanswered(api(0), request);
  EXPECT_GT(lost, 0u);
  EXPECT_LT(lost, 500u);
  mute.reset();
  ASSERT_EQ(unlink(sockets_.path("s2").c_str()), 0);
  start_shard(2);
  wait_until([&] { return unanswered(api(0), request) == 0; });
  wait_until([&] { return unanswered(api(1), request) == 0; });
  expect_as_one_server(rays());
}

TEST_F(Shards, ASlowOneLeavesRaysUnansweredWhenTheTimeIsOver) {
  const SlowPeer slow(sockets_.path("s2"));
  start_shard(0);
  start_shard(1);
  make_grid();
  for (const auto& [kind, fields] : kFields) {
    v1::CastRaysRequest request = cast_of(kind, rays());
    request.set_time_budget_ms(300);
    request.set_allow_partial(true);
    EXPECT_GT(unanswered(api(0), request), 0u);
    // Without a budget, up to shortly before the deadline.
    request.set_time_budget_ms(0);
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(1));
    v1::CastRaysResponse reply;
    const grpc::Status cast = api(0).rays->CastRays(&context, request, &reply);
    EXPECT_TRUE(cast.ok() || cast.error_code() == grpc::StatusCode::DEADLINE_EXCEEDED)
        << cast.error_message();
    EXPECT_TRUE(!cast.ok() || reply.stats().unanswered() > 0);
  }
  wait_until([&] { return slow.begun() > 0 && slow.cancelled() == slow.begun(); });
}

TEST(ShardPeers, AreCheckedAtTheStart) {
  server::ServerConfig config = test_config();
  const auto reason = [&](const std::string& peers) {
    config.shard_peers = peers;
    const Status checked = server::Server::check(config);
    return checked.ok() ? std::string() : checked.error().reason;
  };
  EXPECT_EQ(reason("a:1,b:1"), "SHARDS_NEED_STORE");
  config.store = "postgresql://u@h/d";
  EXPECT_EQ(reason("a:1,b:1"), "");
  EXPECT_EQ(reason("unix:/a,unix:/b"), "");
  EXPECT_EQ(reason("a:1"), "BAD_SHARD_PEERS") << "one alone";
  EXPECT_EQ(reason("a:1,a:1"), "BAD_SHARD_PEERS");
  EXPECT_EQ(reason("a:1,b:0"), "BAD_SHARD_PEERS");
  EXPECT_EQ(reason("a:1,"), "BAD_ADDRESS");
  std::string many = "a:1";
  for (int port = 2; port < 67; ++port) many += ",a:" + std::to_string(port);
  EXPECT_EQ(reason(many), "BAD_SHARD_PEERS");
}

}  // namespace
}  // namespace sightline::tests
