// CastRays and QueryPoints with updates, through a real server.
#include "server/queries/cast_updates.h"

#include <grpcpp/client_context.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <thread>
#include <type_traits>
#include <vector>

#include "server/queries/cast_admission.h"
#include "tests/server/queries/points_rpc.h"
#include "tests/server/queries/random_rays.h"
#include "tests/server/store/directory.h"
#include "tests/server/support/live_server.h"
#include "tests/server/updates/update_stream.h"
#include "tests/support/scenes.h"

namespace sightline::tests {
namespace {

scenegraph::model::Affine at_height(double z) { return {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, z}}; }

v1::Update lift(std::int64_t node, double z) {
  const scenegraph::model::Affine transform = at_height(z);
  v1::Update update;
  update.mutable_set_transforms()->add_nodes(node);
  update.mutable_set_transforms()->set_matrices(transform.m.data(), sizeof(transform.m));
  return update;
}

v1::Update delete_node(std::int64_t node) {
  v1::Update update;
  update.mutable_delete_node()->set_node(node);
  return update;
}

template <class Request>
Request with_updates(Request request, const std::vector<v1::Update>& updates,
                     const std::string& id = {}) {
  request.mutable_apply()->mutable_updates()->Assign(updates.begin(), updates.end());
  request.mutable_apply()->set_request_id(id);
  return request;
}

v1::CastRaysRequest lifted(std::int64_t node, double z, const std::string& id = {}) {
  return with_updates(cast_request(kScene, rays_downward(20)), {lift(node, z)}, id);
}

double first_t(const v1::CastRaysResponse& reply) {
  const auto t = column_values<double>(reply, v1::HIT_FIELD_T);
  return t.empty() ? -1 : t.front();
}

template <class Reply>
std::string columns_of(const Reply& reply) {
  std::string all;
  for (const v1::HitColumn& column : reply.columns()) all += column.SerializeAsString();
  for (const std::string& name : reply.names()) all += name + "/";
  return all;
}

/// The scene has one node, a sheet at z = 0; rays come from z = 10.
class CastUpdatesRpc : public LiveServer {
 protected:
  explicit CastUpdatesRpc(const server::ServerConfig& config = test_config())
      : LiveServer(config) {}
  void SetUp() override { api_.make_scene(kScene, planar_sheet(1)); }

  template <class Request>
  void expect_refused(const Request& request, grpc::StatusCode code, const std::string& reason) {
    const std::uint64_t before = api_.get(kScene).head().revision();
    std::conditional_t<std::is_same_v<Request, v1::CastRaysRequest>, v1::CastRaysResponse,
                       v1::QueryPointsResponse>
        reply;
    const grpc::Status status = api_.cast(request, &reply);
    EXPECT_EQ(status.error_code(), code) << status.error_message();
    EXPECT_EQ(reason_of(status), reason) << status.error_message();
    EXPECT_EQ(api_.get(kScene).head().revision(), before) << reason << ": nothing is applied";
  }
  grpc::Status apply(const std::vector<v1::Update>& updates, const std::string& id,
                     v1::ApplyUpdatesResponse* reply) {
    grpc::ClientContext context;
    v1::ApplyUpdatesRequest request;
    request.set_scene(kScene);
    request.set_request_id(id);
    request.mutable_updates()->Assign(updates.begin(), updates.end());
    return api_.scenes->ApplyUpdates(&context, request, reply);
  }
};

TEST_F(CastUpdatesRpc, TheRaysSeeTheRevisionThatTheUpdatesMake) {
  for (int i = 1; i <= 5; ++i) {
    const v1::CastRaysResponse reply = api_.cast(lifted(1, i));
    EXPECT_EQ(first_t(reply), 10 - i);
    EXPECT_EQ(reply.served().revision(), static_cast<std::uint64_t>(i + 1));
    ASSERT_TRUE(reply.has_applied());
    EXPECT_EQ(reply.applied().revision().token(), reply.served().token());
    EXPECT_EQ(reply.applied().durability(), v1::DURABILITY_RELAXED);
    EXPECT_FALSE(reply.applied().replayed());
    EXPECT_EQ(reply.stats().rays(), 20u);
  }
  // The messages of calls are used again.
  for (int i = 0; i < 20; ++i)
    EXPECT_FALSE(api_.cast(cast_request(kScene, rays_downward(20))).has_applied());
}

TEST_F(CastUpdatesRpc, AnswersAsTwoCallsDo) {
  const std::string mesh = api_.add_mesh(random_soup(300, 0.3, 5));
  const auto rays = random_rays(600, 9);
  std::int64_t last = 1;
  for (const std::size_t count : {std::size_t{5}, server::queries::kSmallCast, rays.size()}) {
    for (const auto kind :
         {v1::QUERY_KIND_CLOSEST, v1::QUERY_KIND_ANY, v1::QUERY_KIND_COUNT, v1::QUERY_KIND_ALL}) {
      for (const auto build : {v1::BUILD_MODE_LAZY, v1::BUILD_MODE_FULL, v1::BUILD_MODE_NONE}) {
        v1::CastRaysRequest request = cast_request(kScene, std::span(rays).first(count));
        request.set_kind(kind);
        request.set_build(build);
        if (kind == v1::QUERY_KIND_ALL) request.set_max_hits(8);
        if (kind == v1::QUERY_KIND_CLOSEST) {
          request.add_fields(v1::HIT_FIELD_T);
          request.add_fields(v1::HIT_FIELD_NAME);
        }
        v1::Update put = put_node(-1, mesh);
        put.mutable_put_node()->set_name("soup " + std::to_string(last));
        const v1::CastRaysResponse one = api_.cast(with_updates(request, {put, lift(last, 3)}));
        ASSERT_EQ(one.applied().nodes_size(), 1);
        last = static_cast<std::int64_t>(one.applied().nodes(0));
        request.mutable_consistency()->set_exact_revision(one.served().revision());
        EXPECT_EQ(columns_of(one), columns_of(api_.cast(request)))
            << v1::QueryKind_Name(kind) << " of " << count;
      }
    }
  }
}

TEST_F(CastUpdatesRpc, PointsSeeTheRevisionThatTheUpdatesMake) {
  v1::QueryPointsRequest request =
      points_request({0.5, 0.5, 10}, v1::QUERY_KIND_CLOSEST, {v1::HIT_FIELD_T});
  v1::QueryPointsResponse reply;
  const grpc::Status status = api_.cast(with_updates(request, {lift(1, 4)}), &reply);
  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(values<double>(reply, v1::HIT_FIELD_T), std::vector{6.0});
  EXPECT_EQ(reply.applied().revision().revision(), 2u);
  EXPECT_EQ(reply.served().revision(), 2u);
  ASSERT_TRUE(api_.cast(request, &reply).ok());
  EXPECT_FALSE(reply.has_applied());
}

TEST_F(CastUpdatesRpc, AllKindsOfUpdatesAreApplied) {
  const std::string mesh = api_.add_mesh(planar_sheet(1));
  const auto rays = cast_request(kScene, rays_downward(4));
  EXPECT_EQ(first_t(api_.cast(
                with_updates(rays, {patch({1}, 0, {{0, 0, 2}, {1, 0, 2}, {0, 1, 2}, {1, 1, 2}})}))),
            8);
  const v1::CastRaysResponse put =
      api_.cast(with_updates(rays, {put_node(-7, {}, 0, at_height(3)), put_node(-8, mesh, -7)}));
  EXPECT_EQ(first_t(put), 7);
  EXPECT_EQ(put.applied().nodes_size(), 2);
  EXPECT_EQ(column_values<std::uint64_t>(put, v1::HIT_FIELD_NODE).front(), put.applied().nodes(1));
  EXPECT_EQ(first_t(api_.cast(with_updates(rays, {delete_node(3)}))), 8);
  const v1::CastRaysResponse none = api_.cast(with_updates(rays, {}));
  EXPECT_EQ(none.served().revision(), 5u) << "as ApplyUpdates makes a revision of no updates";
}

TEST_F(CastUpdatesRpc, ManyUpdatesAreAppliedToo) {
  std::vector<v1::Update> updates;
  for (int i = 1; i <= 3000; ++i) updates.push_back(put_node(-i));
  updates.push_back(lift(1, 2));
  const v1::CastRaysResponse reply =
      api_.cast(with_updates(cast_request(kScene, rays_downward(20)), updates));
  EXPECT_EQ(first_t(reply), 8);
  EXPECT_EQ(reply.applied().nodes_size(), 3000);
  updates.assign(65537, v1::Update());
  expect_refused(with_updates(cast_request(kScene, rays_downward(1)), updates),
                 grpc::StatusCode::RESOURCE_EXHAUSTED, "TOO_MANY_UPDATES");
}

TEST_F(CastUpdatesRpc, RaysThatAreRefusedLeaveTheSceneAsItIs) {
  const auto refused = [this](const v1::CastRaysRequest& request, const char* reason) {
    expect_refused(request, grpc::StatusCode::INVALID_ARGUMENT, reason);
  };
  v1::CastRaysRequest request = lifted(1, 1);
  request.mutable_rays()->mutable_directions()->pop_back();
  refused(request, "COLUMN_LENGTH");
  request = lifted(1, 1);
  request.mutable_rays()->set_count(21);
  refused(request, "RAY_COUNT");
  request = lifted(1, 1);
  request.add_fields(v1::HIT_FIELD_COUNT);
  refused(request, "FIELD_NOT_OF_KIND");
  request = lifted(1, 1);
  request.set_kind(v1::QUERY_KIND_ALL);
  request.set_max_hits(16384);
  refused(request, "TOO_MANY_HITS");
  request = lifted(1, 1);
  *request.mutable_rays() = encode_rays(rays_downward(16385));
  expect_refused(request, grpc::StatusCode::RESOURCE_EXHAUSTED, "TOO_MANY_RAYS");
  v1::QueryPointsRequest points = with_updates(points_request({1, 2, 3}), {lift(1, 1)});
  points.set_side_rays(2);
  expect_refused(points, grpc::StatusCode::INVALID_ARGUMENT, "SIDE_NOT_ASKED");
}

TEST_F(CastUpdatesRpc, WhatDoesNotGoWithUpdatesIsRefused) {
  const auto refused = [this](const v1::CastRaysRequest& request, const char* reason) {
    expect_refused(request, grpc::StatusCode::INVALID_ARGUMENT, reason);
  };
  v1::CastRaysRequest request = lifted(1, 1);
  request.mutable_consistency()->set_exact_revision(1);
  refused(request, "CONSISTENCY_WITH_UPDATES");
  request.mutable_consistency()->set_at_least("x");
  refused(request, "CONSISTENCY_WITH_UPDATES");
  request = lifted(1, 1);
  request.mutable_apply()->set_scene(kScene + "2");
  refused(request, "OTHER_SCENE");
  request = lifted(1, 1);
  request.mutable_shard()->set_count(1);
  refused(request, "UPDATES_FOR_SHARD");
  request = lifted(1, 1);
  request.set_root(static_cast<std::uint64_t>(-1));
  refused(request, "ALIAS_IN_QUERY");
  request = lifted(1, 1);
  request.add_exclude(1);
  request.add_exclude(static_cast<std::uint64_t>(-2));
  refused(request, "ALIAS_IN_QUERY");
  v1::QueryPointsRequest points = with_updates(points_request({1, 2, 3}), {lift(1, 1)});
  points.mutable_consistency()->set_exact_revision(1);
  expect_refused(points, grpc::StatusCode::INVALID_ARGUMENT, "CONSISTENCY_WITH_UPDATES");
  request = lifted(1, 1);
  request.mutable_apply()->set_scene(kScene);
  EXPECT_EQ(first_t(api_.cast(request)), 9) << "the same scene may be named";
}

TEST_F(CastUpdatesRpc, UpdatesThatAreRefusedFailTheCall) {
  const auto rays = cast_request(kScene, rays_downward(4));
  expect_refused(with_updates(rays, {lift(1, 5), lift(99, 5)}), grpc::StatusCode::NOT_FOUND,
                 "NODE_NOT_FOUND");
  expect_refused(with_updates(rays, {v1::Update()}), grpc::StatusCode::INVALID_ARGUMENT,
                 "EMPTY_UPDATE");
  expect_refused(with_updates(rays, {put_node(-1, "sha256:" + std::string(64, '0') + "/24")}),
                 grpc::StatusCode::FAILED_PRECONDITION, "MESHES_MISSING");
  expect_refused(with_updates(rays, {lift(1, 5)}, std::string(65, 'x')),
                 grpc::StatusCode::INVALID_ARGUMENT, "REQUEST_ID_TOO_LONG");
  v1::CastRaysRequest late = lifted(1, 5);
  late.mutable_apply()->set_expected_revision(7);
  expect_refused(late, grpc::StatusCode::ABORTED, "REVISION_MISMATCH");
  late.mutable_apply()->set_expected_revision(1);
  EXPECT_EQ(first_t(api_.cast(late)), 5);
  v1::CastRaysRequest nowhere = lifted(1, 5);
  nowhere.set_scene("projects/p/scenes/none");
  expect_refused(nowhere, grpc::StatusCode::NOT_FOUND, "SCENE_NOT_FOUND");
  // What such calls have held is given back.
  for (int i = 0; i < 50; ++i) EXPECT_EQ(first_t(api_.cast(lifted(1, 1))), 9);
}

TEST_F(CastUpdatesRpc, ARepeatIsAnsweredAtItsRevision) {
  const v1::CastRaysResponse first = api_.cast(lifted(1, 1, "a"));
  EXPECT_EQ(first_t(api_.cast(lifted(1, 2, "b"))), 8);
  const v1::CastRaysResponse again = api_.cast(lifted(1, 1, "a"));
  EXPECT_TRUE(again.applied().replayed());
  EXPECT_EQ(again.served().token(), first.served().token());
  EXPECT_EQ(columns_of(again), columns_of(first));
  EXPECT_EQ(api_.get(kScene).head().revision(), 3u);
  // Other rays are no other request.
  v1::CastRaysRequest others = lifted(1, 1, "a");
  *others.mutable_rays() = encode_rays(rays_downward(300));
  EXPECT_EQ(api_.cast(others).served().revision(), 2u);
}

TEST_F(CastUpdatesRpc, ARepeatWhoseRevisionIsGoneIsAnsweredAtTheNewest) {
  ASSERT_EQ(first_t(api_.cast(lifted(1, 1, "a"))), 9);
  for (int i = 0; i < 80; ++i) ASSERT_TRUE(api_.apply(kScene, {lift(1, 3)}).ok());
  const v1::CastRaysResponse again = api_.cast(lifted(1, 1, "a"));
  EXPECT_TRUE(again.applied().replayed());
  EXPECT_EQ(again.applied().revision().revision(), 2u);
  EXPECT_EQ(again.served().revision(), 82u);
  EXPECT_EQ(first_t(again), 7);
}

TEST_F(CastUpdatesRpc, AnIdBelongsToOneBatchHoweverItIsSent) {
  v1::ApplyUpdatesResponse reply;
  ASSERT_EQ(first_t(api_.cast(lifted(1, 1, "a"))), 9);
  expect_refused(lifted(1, 2, "a"), grpc::StatusCode::INVALID_ARGUMENT, "REQUEST_ID_REUSED");
  ASSERT_TRUE(apply({lift(1, 1)}, "a", &reply).ok());
  EXPECT_TRUE(reply.replayed()) << "by ApplyUpdates, which names the scene";
  ASSERT_TRUE(apply({lift(1, 4)}, "b", &reply).ok());
  const v1::CastRaysResponse repeat = api_.cast(lifted(1, 4, "b"));
  EXPECT_TRUE(repeat.applied().replayed());
  EXPECT_EQ(first_t(repeat), 6);
  EXPECT_EQ(api_.get(kScene).head().revision(), 3u);
}

TEST_F(CastUpdatesRpc, TheQueryNamesNodesOfTheNewRevision) {
  const std::string mesh = api_.add_mesh(planar_sheet(1));
  v1::CastRaysRequest request =
      with_updates(cast_request(kScene, rays_downward(4)), {put_node(-1, mesh, 0, at_height(-2))});
  request.set_root(2);
  EXPECT_EQ(first_t(api_.cast(request)), 12) << "the new node alone";
  request = with_updates(cast_request(kScene, rays_downward(4)), {delete_node(2)}, "a");
  request.add_exclude(2);
  v1::CastRaysResponse reply;
  for (int i = 0; i < 2; ++i) {
    const grpc::Status status = api_.cast(request, &reply);
    EXPECT_EQ(reason_of(status), "NODE_NOT_FOUND") << "it is gone at that revision";
    EXPECT_EQ(api_.get(kScene).head().revision(), 3u) << "the updates are applied once";
  }
}

TEST_F(CastUpdatesRpc, StreamsTakeNoUpdates) {
  for (const bool later : {false, true}) {
    grpc::ClientContext context, of_points;
    const auto rays = api_.rays->StreamCastRays(&context);
    const auto points = api_.rays->StreamQueryPoints(&of_points);
    v1::StreamCastRaysRequest request;
    v1::StreamQueryPointsRequest of_point;
    v1::StreamCastRaysResponse reply;
    v1::StreamQueryPointsResponse near;
    *request.mutable_request() = cast_request(kScene, rays_downward(4));
    *of_point.mutable_request() = points_request({0, 0, 1});
    if (later) {
      EXPECT_TRUE(rays->Write(request) && rays->Read(&reply));
      EXPECT_TRUE(points->Write(of_point) && points->Read(&near));
    }
    *request.mutable_request() = lifted(1, 3);
    *of_point.mutable_request() = with_updates(points_request({0, 0, 1}), {lift(1, 3)});
    rays->Write(request);
    points->Write(of_point);
    EXPECT_FALSE(rays->Read(&reply));
    EXPECT_FALSE(points->Read(&near));
    for (const grpc::Status& ended : {rays->Finish(), points->Finish()}) {
      EXPECT_EQ(ended.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
      EXPECT_EQ(reason_of(ended), "UPDATES_IN_STREAM");
    }
  }
  EXPECT_EQ(api_.get(kScene).head().revision(), 1u);
}

TEST_F(CastUpdatesRpc, ACancelledCallHasAppliedOnceOrNotAtAll) {
  std::vector<std::thread> threads;
  for (int t = 0; t < 3; ++t) {
    threads.emplace_back([&, t] {
      Api api(connect(server_->port()));
      for (int i = 0; i < 60; ++i) {
        const std::string id = std::to_string(t) + "/" + std::to_string(i);
        const auto request =
            with_updates(cast_request(kScene, rays_downward(20)), {put_node(-1)}, id);
        grpc::ClientContext context;
        v1::CastRaysResponse reply;
        std::thread canceller([&] { context.TryCancel(); });
        static_cast<void>(api.rays->CastRays(&context, request, &reply));
        canceller.join();
        EXPECT_TRUE(api.cast(request, &reply).ok());
        EXPECT_EQ(reply.applied().nodes_size(), 1);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(api_.get(kScene).head().revision(), 181u);
  EXPECT_EQ(api_.get(kScene).nodes(), 181u);
}

TEST_F(CastUpdatesRpc, EachAnswerIsThatOfItsOwnRevision) {
  constexpr int kThreads = 6, kEach = 60;
  std::vector<std::thread> threads;
  for (int t = 0; t < kThreads; ++t) {
    threads.emplace_back([&, t] {
      Api api(connect(server_->port()));
      for (int i = 0; i < kEach; ++i) {
        const double height = (1 + t * kEach + i) / 64.0;
        v1::CastRaysRequest request = lifted(1, height);
        if (i % 3 == 1) *request.mutable_rays() = encode_rays(rays_downward(500));
        if (i % 3 == 2) request.set_build(v1::BUILD_MODE_FULL);
        const v1::CastRaysResponse reply = api.cast(request);
        EXPECT_EQ(first_t(reply), 10 - height);
        EXPECT_EQ(reply.served().token(), reply.applied().revision().token());
      }
    });
  }
  threads.emplace_back([&] {
    Api api(connect(server_->port()));
    for (int i = 0; i < kEach; ++i) EXPECT_TRUE(api.apply(kScene, {lift(1, -i)}).ok());
  });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(api_.get(kScene).head().revision(), 1u + (kThreads + 1) * kEach);
}

TEST_F(CastUpdatesRpc, TheSameRequestFromManyIsAppliedOnce) {
  std::vector<std::thread> threads;
  for (int t = 0; t < 6; ++t) {
    threads.emplace_back([&] {
      Api api(connect(server_->port()));
      for (int i = 0; i < 30; ++i) {
        const v1::CastRaysResponse reply = api.cast(lifted(1, i / 8.0, std::to_string(i)));
        EXPECT_EQ(first_t(reply), 10 - i / 8.0);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(api_.get(kScene).head().revision(), 31u);
}

TEST_F(CastUpdatesRpc, ATimeBudgetDoesNotUndoTheUpdates) {
  v1::CastRaysRequest request = lifted(1, 2);
  request.set_time_budget_ms(1);
  const v1::CastRaysResponse reply = api_.cast(request);
  EXPECT_EQ(reply.applied().revision().revision(), 2u);
  EXPECT_EQ(reply.stats().rays(), 20u);
  EXPECT_LE(reply.stats().unanswered(), 20u);
  if (reply.stats().unanswered() == 0) {
    EXPECT_EQ(first_t(reply), 8);
  }
}

server::ServerConfig with_few_rays() {
  server::ServerConfig config = test_config();
  config.admission.rays = 1000;
  return config;
}

class FewRaysInFlight : public CastUpdatesRpc {
 protected:
  FewRaysInFlight() : CastUpdatesRpc(with_few_rays()) {}
};

TEST_F(FewRaysInFlight, WhatIsNotAdmittedIsNotAppliedEither) {
  v1::CastRaysRequest request = lifted(1, 1);
  *request.mutable_rays() = encode_rays(rays_downward(2000));
  expect_refused(request, grpc::StatusCode::RESOURCE_EXHAUSTED, "QUEUE_FULL");
  // Those whose updates are refused give their places back.
  for (int i = 0; i < 30; ++i) {
    *request.mutable_rays() = encode_rays(rays_downward(900));
    request.mutable_apply()->set_expected_revision(99);
    expect_refused(request, grpc::StatusCode::ABORTED, "REVISION_MISMATCH");
  }
}

TEST(CastUpdatesDurably, ASceneThatWasNotReadYetTakesThem) {
  const Directory dir;
  server::ServerConfig config = test_config();
  config.data_dir = dir.path();
  for (int life = 0; life < 3; ++life) {
    const auto server = *server::Server::start(config);
    Api api(connect(server->port()));
    if (life == 0) api.make_scene(kScene, planar_sheet(1));
    const std::uint64_t before = static_cast<std::uint64_t>(1 + life);
    const v1::CastRaysResponse reply = api.cast(lifted(1, 1 + life, std::to_string(life)));
    EXPECT_EQ(first_t(reply), 9 - life);
    EXPECT_EQ(reply.applied().durability(), v1::DURABILITY_COMMITTED);
    EXPECT_EQ(reply.served().revision(), before + 1);
    for (int earlier = 0; earlier <= life; ++earlier) {
      const v1::CastRaysResponse again = api.cast(lifted(1, 1 + earlier, std::to_string(earlier)));
      EXPECT_TRUE(again.applied().replayed());
      EXPECT_EQ(again.applied().revision().revision(), static_cast<std::uint64_t>(2 + earlier));
    }
  }
}

TEST(CastUpdatesDurably, EachAnswerIsThatOfItsOwnRevision) {
  const Directory dir;
  server::ServerConfig config = test_config();
  config.data_dir = dir.path();
  const auto server = *server::Server::start(config);
  Api api(connect(server->port()));
  api.make_scene(kScene, planar_sheet(1));
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      Api own(connect(server->port()));
      for (int i = 0; i < 40; ++i) {
        const double height = (1 + t * 40 + i) / 64.0;
        const v1::CastRaysResponse reply =
            own.cast(lifted(1, height, "h" + std::to_string(height)));
        EXPECT_EQ(first_t(reply), 10 - height);
        EXPECT_EQ(reply.applied().durability(), v1::DURABILITY_COMMITTED);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(api.get(kScene).head().revision(), 161u);
}

}  // namespace
}  // namespace sightline::tests
