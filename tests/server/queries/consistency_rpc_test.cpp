// Reads at a token, at an exact revision, and at the newest one, through a real server.
#include <grpcpp/client_context.h>
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "server/exec/call_registry.h"
#include "server/exec/shares.h"
#include "server/scenes/history.h"
#include "server/scenes/names.h"
#include "server/scenes/revision_wait.h"
#include "tests/server/support/live_server.h"
#include "tests/server/updates/update_stream.h"
#include "tests/support/scenes.h"

namespace sightline::tests {
namespace {

class ConsistencyRpcTest : public LiveServer {
 protected:
  void SetUp() override { api_.make_scene(kScene, planar_sheet(1)); }

  v1::SceneRevision head() { return api_.get(kScene).head(); }

  std::string token_after(std::uint64_t revisions) {
    auto token = server::scenes::RevisionToken::parse(head().token());
    token->revision += revisions;
    return token->text();
  }

  grpc::Status cast(const v1::Consistency& consistency, v1::CastRaysResponse* reply) {
    v1::CastRaysRequest request = cast_request(kScene, rays_downward(20));
    request.add_fields(v1::HIT_FIELD_T);
    *request.mutable_consistency() = consistency;
    return api_.cast(request, reply);
  }

  grpc::Status at_least(const std::string& token, v1::CastRaysResponse* reply) {
    v1::Consistency consistency;
    consistency.set_at_least(token);
    return cast(consistency, reply);
  }

  grpc::Status exact(std::uint64_t revision, v1::CastRaysResponse* reply) {
    v1::Consistency consistency;
    consistency.set_exact_revision(revision);
    return cast(consistency, reply);
  }

  grpc::Status nodes(const v1::Consistency& consistency, v1::BatchGetNodesResponse* reply) {
    grpc::ClientContext context;
    v1::BatchGetNodesRequest request;
    request.set_scene(kScene);
    request.add_ids(1);
    *request.mutable_consistency() = consistency;
    return api_.scenes->BatchGetNodes(&context, request, reply);
  }
};

TEST_F(ConsistencyRpcTest, EveryAnswerHasTheTokenOfItsRevision) {
  v1::CastRaysResponse reply;
  ASSERT_TRUE(cast({}, &reply).ok());
  EXPECT_EQ(reply.served().token(), head().token());
  v1::BatchGetNodesResponse got;
  ASSERT_TRUE(nodes({}, &got).ok());
  EXPECT_EQ(got.served().token(), head().token());
  EXPECT_EQ(api_.stats(kScene).revision().token(), head().token());
  v1::ApplyUpdatesResponse applied;
  ASSERT_TRUE(api_.apply(kScene, {move_to(1, 1)}, &applied).ok());
  EXPECT_EQ(applied.revision().token(), head().token());
}

TEST_F(ConsistencyRpcTest, AReachedTokenIsAnsweredByTheNewestRevision) {
  const std::string token = head().token();
  ASSERT_TRUE(api_.apply(kScene, {move_to(1, 1)}).ok());
  v1::CastRaysResponse reply;
  ASSERT_TRUE(at_least(token, &reply).ok());
  EXPECT_EQ(reply.served().revision(), 2u);
}

TEST_F(ConsistencyRpcTest, RefusesTokensOfOtherScenes) {
  v1::CastRaysResponse reply;
  EXPECT_EQ(reason_of(at_least("nonsense", &reply)), "BAD_TOKEN");
  EXPECT_EQ(reason_of(at_least(head().token() + "x", &reply)), "BAD_TOKEN");
  const std::string token = head().token();
  ASSERT_TRUE(api_.remove(kScene).ok());
  api_.make_scene(kScene, planar_sheet(1));
  const grpc::Status old = at_least(token, &reply);
  EXPECT_EQ(old.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(reason_of(old), "BAD_TOKEN");
}

TEST_F(ConsistencyRpcTest, WaitsUntilTheRevisionIsPublished) {
  const std::string token = token_after(3);
  std::vector<std::thread> readers;
  for (int i = 0; i < 4; ++i) {
    readers.emplace_back([&, i] {
      Api api(connect(server_->port()));
      if (i % 2 == 0) {
        v1::CastRaysRequest request = cast_request(kScene, rays_downward(20));
        request.mutable_consistency()->set_at_least(token);
        v1::CastRaysResponse reply;
        const grpc::Status status = api.cast(request, &reply);
        EXPECT_TRUE(status.ok()) << status.error_message();
        EXPECT_GE(reply.served().revision(), 4u);
        return;
      }
      grpc::ClientContext context;
      const auto stream = api.rays->StreamCastRays(&context);
      v1::StreamCastRaysRequest request;
      *request.mutable_request() = cast_request(kScene, rays_downward(20));
      request.mutable_request()->mutable_consistency()->set_at_least(token);
      v1::StreamCastRaysResponse reply;
      EXPECT_TRUE(stream->Write(request));
      EXPECT_TRUE(stream->Read(&reply));
      EXPECT_GE(reply.response().served().revision(), 4u);
    });
  }
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(api_.apply(kScene, {move_to(1, i)}).ok());
  for (std::thread& reader : readers) reader.join();
}

TEST_F(ConsistencyRpcTest, AWaitEndsAtTheBoundOrTheDeadline) {
  v1::CastRaysResponse reply;
  const grpc::Status late = at_least(token_after(1), &reply);
  EXPECT_EQ(late.error_code(), grpc::StatusCode::UNAVAILABLE);
  EXPECT_EQ(reason_of(late), "REVISION_NOT_THERE");

  v1::BatchGetNodesRequest request;
  v1::BatchGetNodesResponse got;
  request.set_scene(kScene);
  request.mutable_consistency()->set_at_least(token_after(1));
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::milliseconds(50));
  const grpc::StatusCode soon = api_.scenes->BatchGetNodes(&context, request, &got).error_code();
  EXPECT_TRUE(soon == grpc::StatusCode::DEADLINE_EXCEEDED || soon == grpc::StatusCode::UNAVAILABLE)
      << soon;
}

TEST_F(ConsistencyRpcTest, AnExactRevisionAnswersWithItsOwnHits) {
  std::vector<std::string> t;
  for (int i = 0; i < 10; ++i) {
    v1::CastRaysResponse reply;
    ASSERT_TRUE(cast({}, &reply).ok());
    t.push_back(column_of(reply, v1::HIT_FIELD_T));
    ASSERT_TRUE(api_.apply(kScene, {move_to(1, 0.1 * (i + 1))}).ok());
  }
  EXPECT_NE(t[0], t[5]);
  for (std::uint64_t revision = 1; revision <= 10; ++revision) {
    v1::CastRaysResponse reply;
    const grpc::Status status = exact(revision, &reply);
    ASSERT_TRUE(status.ok()) << status.error_message();
    EXPECT_EQ(reply.served().revision(), revision);
    EXPECT_EQ(column_of(reply, v1::HIT_FIELD_T), t[revision - 1]) << revision;
  }
  v1::Consistency consistency;
  consistency.set_exact_revision(4);
  v1::BatchGetNodesResponse got;
  ASSERT_TRUE(nodes(consistency, &got).ok());
  EXPECT_EQ(got.nodes(0).transform().matrix(3), 0.1 * 3);
}

TEST_F(ConsistencyRpcTest, RefusesDroppedAndFutureRevisions) {
  const std::uint64_t kept = server::scenes::RecentLimits().revisions;
  for (std::uint64_t i = 0; i < kept + 5; ++i) ASSERT_TRUE(api_.apply(kScene, {}).ok());
  v1::CastRaysResponse reply;
  const grpc::Status old = exact(1, &reply), early = exact(kept + 7, &reply);
  EXPECT_EQ(old.error_code(), grpc::StatusCode::OUT_OF_RANGE);
  EXPECT_EQ(reason_of(old), "REVISION_NOT_KEPT");
  EXPECT_NE(old.error_message().find("kept are 6 to 70"), std::string::npos) << old.error_message();
  EXPECT_EQ(early.error_code(), grpc::StatusCode::OUT_OF_RANGE);
  EXPECT_TRUE(exact(6, &reply).ok());
  EXPECT_TRUE(exact(kept + 6, &reply).ok());
}

TEST_F(ConsistencyRpcTest, BoundsTheReadsThatWait) {
  const std::string token = token_after(1);
  std::vector<std::unique_ptr<grpc::ClientContext>> contexts;
  std::vector<std::unique_ptr<
      grpc::ClientReaderWriter<v1::StreamCastRaysRequest, v1::StreamCastRaysResponse>>>
      streams;
  std::vector<Api> clients;
  v1::StreamCastRaysRequest request;
  *request.mutable_request() = cast_request(kScene, rays_downward(1));
  request.mutable_request()->mutable_consistency()->set_at_least(token);
  v1::CastRaysRequest alone = request.request();
  const auto limits = server::exec::ShareLimits::of(server::scenes::kMaxWaitingReads,
                                                    server::exec::kConnectionCallShare);
  for (std::size_t i = 0; i < limits.principal; ++i) {
    if (i % limits.connection == 0) clients.emplace_back(connect(server_->port()));
    contexts.push_back(std::make_unique<grpc::ClientContext>());
    streams.push_back(clients.back().rays->StreamCastRays(contexts.back().get()));
    ASSERT_TRUE(streams.back()->Write(request));
  }
  // A read is refused if the waiting limit is reached; before that it would wait.
  v1::CastRaysResponse reply;
  const grpc::Status status = api_.cast(alone, &reply);
  EXPECT_TRUE(reason_of(status) == "TOO_MANY_WAITING" || reason_of(status) == "REVISION_NOT_THERE")
      << status.error_message();
  ASSERT_TRUE(api_.apply(kScene, {}).ok());
  v1::StreamCastRaysResponse answer;
  for (auto& stream : streams) {
    if (!stream->Read(&answer)) continue;
    EXPECT_GE(answer.response().served().revision(), 2u);
  }
  for (auto& context : contexts) context->TryCancel();
  for (auto& stream : streams) stream->Finish();
}

}  // namespace
}  // namespace sightline::tests
