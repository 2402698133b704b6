// StreamCastRays through a real server.
#include "server/queries/cast_rpc.h"

#include <grpcpp/client_context.h>
#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "server/exec/call_registry.h"
#include "server/exec/shares.h"
#include "server/queries/ray_codec.h"
#include "tests/server/support/live_server.h"
#include "tests/support/scenes.h"

namespace sightline::tests {
namespace {

v1::StreamCastRaysRequest chunk(std::uint64_t number, const std::string& scene, std::size_t rays) {
  v1::StreamCastRaysRequest request;
  request.set_chunk(number);
  *request.mutable_request() = cast_request(scene, rays_downward(rays));
  return request;
}

class StreamCastRpcTest : public LiveServer {
 protected:
  using LiveServer::LiveServer;
  using Stream = grpc::ClientReaderWriter<v1::StreamCastRaysRequest, v1::StreamCastRaysResponse>;

  /// The server still answers, whatever happened before.
  void expect_serving() {
    v1::CastRaysResponse reply;
    const grpc::Status status =
        Api(connect(server_->port())).cast(cast_request(kScene, rays_downward(10)), &reply);
    EXPECT_TRUE(status.ok()) << status.error_message();
  }
};

TEST_F(StreamCastRpcTest, AnswersEveryRequestInOrder) {
  api_.make_scene(kScene, planar_sheet(8));
  grpc::ClientContext context;
  const auto stream = api_.rays->StreamCastRays(&context);
  std::thread writer([&] {
    for (std::uint64_t i = 0; i < 50; ++i)
      EXPECT_TRUE(stream->Write(chunk(100 + i, kScene, 10 * i)));
    stream->WritesDone();
  });
  v1::StreamCastRaysResponse reply;
  for (std::uint64_t i = 0; i < 50; ++i) {
    ASSERT_TRUE(stream->Read(&reply));
    EXPECT_EQ(reply.chunk(), 100 + i);
    EXPECT_EQ(reply.response().stats().rays(), 10 * i);
    EXPECT_EQ(reply.response().stats().hits(), 10 * i);
    EXPECT_EQ(column_of(reply.response(), v1::HIT_FIELD_T).size(), 80 * i);
  }
  EXPECT_FALSE(stream->Read(&reply));
  writer.join();
  EXPECT_TRUE(stream->Finish().ok());
}

TEST_F(StreamCastRpcTest, TheFirstRequestHoldsTheQueryOfAll) {
  api_.make_scene(kScene, planar_sheet(1));
  grpc::ClientContext context;
  const auto stream = api_.rays->StreamCastRays(&context);
  v1::StreamCastRaysRequest first = chunk(1, kScene, 5);
  first.mutable_request()->add_fields(v1::HIT_FIELD_HIT);
  v1::StreamCastRaysRequest second = chunk(2, "nonsense", 5);
  second.mutable_request()->add_fields(v1::HIT_FIELD_NORMAL);
  v1::StreamCastRaysResponse reply;
  ASSERT_TRUE(stream->Write(first));
  ASSERT_TRUE(stream->Read(&reply));
  ASSERT_TRUE(stream->Write(second));
  ASSERT_TRUE(stream->Read(&reply));
  ASSERT_EQ(reply.response().columns_size(), 1);
  EXPECT_EQ(column_of(reply.response(), v1::HIT_FIELD_HIT), std::string(5, '\1'));
}

TEST_F(StreamCastRpcTest, IsAnsweredAtOneRevisionWhileTheSceneChangesAndIsDeleted) {
  api_.make_scene(kScene, planar_sheet(1));
  grpc::ClientContext context;
  const auto stream = api_.rays->StreamCastRays(&context);
  const auto hits = [&] {
    v1::StreamCastRaysResponse reply;
    EXPECT_TRUE(stream->Write(chunk(0, kScene, 20)));
    EXPECT_TRUE(stream->Read(&reply));
    EXPECT_EQ(reply.response().served().revision(), 1u);
    return reply.response().stats().hits();
  };
  EXPECT_EQ(hits(), 20u);
  v1::Update remove;
  remove.mutable_delete_node()->set_node(1);
  ASSERT_TRUE(api_.apply(kScene, {remove}).ok());
  EXPECT_EQ(hits(), 20u);
  ASSERT_TRUE(api_.remove(kScene).ok());
  EXPECT_EQ(hits(), 20u);
  stream->WritesDone();
  EXPECT_TRUE(stream->Finish().ok());
}

TEST_F(StreamCastRpcTest, ABadBatchEndsTheCallWithItsError) {
  api_.make_scene(kScene, planar_sheet(1));
  grpc::ClientContext unknown_context, large_context;
  v1::StreamCastRaysResponse reply;
  const auto unknown = api_.rays->StreamCastRays(&unknown_context);
  unknown->Write(chunk(0, "projects/p/scenes/none", 1));
  EXPECT_FALSE(unknown->Read(&reply));
  EXPECT_EQ(unknown->Finish().error_code(), grpc::StatusCode::NOT_FOUND);

  const auto large = api_.rays->StreamCastRays(&large_context);
  large->Write(chunk(0, kScene, 10));
  EXPECT_TRUE(large->Read(&reply));
  large->Write(chunk(1, kScene, server::queries::kMaxRaysPerRequest + 1));
  EXPECT_FALSE(large->Read(&reply));
  EXPECT_EQ(reason_of(large->Finish()), "TOO_MANY_RAYS");
}

TEST_F(StreamCastRpcTest, TheServerContinuesAfterACancelledStream) {
  api_.make_scene(kScene, planar_sheet(64));
  for (int round = 0; round < 20; ++round) {
    grpc::ClientContext context;
    const auto stream = api_.rays->StreamCastRays(&context);
    for (std::uint64_t i = 0; i < 4; ++i)
      stream->Write(chunk(i, kScene, server::queries::kMaxRaysPerRequest));
    context.TryCancel();
    EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::CANCELLED);
  }
  expect_serving();
}

TEST_F(StreamCastRpcTest, AClientThatNeverReadsDoesNotBlockOthers) {
  api_.make_scene(kScene, planar_sheet(8));
  constexpr int kMessages = 10'000;
  grpc::ClientContext context;
  const auto stream = api_.rays->StreamCastRays(&context);
  std::atomic<int> accepted{0};
  std::thread writer([&] {
    const auto request = chunk(0, kScene, 8192);
    while (accepted < kMessages && stream->Write(request)) ++accepted;
  });
  for (int i = 0; i < 100; ++i) expect_serving();
  context.TryCancel();
  writer.join();
  stream->Finish();
  EXPECT_LT(accepted, 500) << "only the connection's windows hold requests, there is no queue";
  expect_serving();
}

/// Of each client, so that others have a place.
TEST_F(StreamCastRpcTest, BoundsTheOpenStreams) {
  api_.make_scene(kScene, planar_sheet(1));
  std::vector<std::unique_ptr<grpc::ClientContext>> contexts;
  std::vector<std::unique_ptr<Stream>> streams;
  std::vector<Api> clients;
  v1::StreamCastRaysResponse reply;
  const auto limits = server::exec::ShareLimits::of(server::queries::kMaxCastStreams,
                                                    server::exec::kConnectionCallShare);
  for (std::size_t i = 0; i < limits.principal; ++i) {
    if (i == limits.connection) {
      grpc::ClientContext context;
      const auto refused = clients.back().rays->StreamCastRays(&context);
      EXPECT_FALSE(refused->Read(&reply));
      EXPECT_NE(refused->Finish().error_message().find("your connection"), std::string::npos);
    }
    if (i % limits.connection == 0) clients.emplace_back(connect(server_->port()));
    contexts.push_back(std::make_unique<grpc::ClientContext>());
    streams.push_back(clients.back().rays->StreamCastRays(contexts.back().get()));
    ASSERT_TRUE(streams.back()->Write(chunk(0, kScene, 1)));
    ASSERT_TRUE(streams.back()->Read(&reply));
  }
  grpc::ClientContext context;
  const auto one_more = Api(connect(server_->port())).rays->StreamCastRays(&context);
  EXPECT_FALSE(one_more->Read(&reply));
  const grpc::Status status = one_more->Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(reason_of(status), "TOO_MANY_STREAMS");
  EXPECT_NE(status.error_message().find("your address"), std::string::npos);
  for (auto& stream : streams) stream->WritesDone();
  for (auto& stream : streams) EXPECT_TRUE(stream->Finish().ok());
}

server::ServerConfig config_of_few_bytes() {
  server::ServerConfig config = test_config();
  config.admission.bytes = std::uint64_t{32} << 20;
  return config;
}

class UnreadRepliesTest : public StreamCastRpcTest {
 protected:
  UnreadRepliesTest() : StreamCastRpcTest(config_of_few_bytes()) {}
};

/// Replies larger than the windows of a stream stay in the server until they are read: a connection
/// may leave a few of them unread, not more.
TEST_F(UnreadRepliesTest, AreBoundedForAConnection) {
  api_.make_scene(kScene, planar_sheet(1));
  constexpr std::size_t kStreams = 12;
  std::vector<std::unique_ptr<grpc::ClientContext>> contexts;
  std::vector<std::unique_ptr<Stream>> streams;
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  arguments.SetInt(GRPC_ARG_HTTP2_BDP_PROBE, 0);  // the windows stay small
  const Api client(grpc::CreateCustomChannel("127.0.0.1:" + std::to_string(server_->port()),
                                             grpc::InsecureChannelCredentials(), arguments));
  for (std::size_t i = 0; i < kStreams; ++i) {
    contexts.push_back(std::make_unique<grpc::ClientContext>());
    streams.push_back(client.rays->StreamCastRays(contexts.back().get()));
    ASSERT_TRUE(streams.back()->Write(chunk(0, kScene, 16384)));
    expect_serving();
  }
  std::size_t answered = 0, refused = 0, unread = 0;
  // The last first: the others' replies stay unread meanwhile.
  for (auto stream = streams.rbegin(); stream != streams.rend(); ++stream) {
    v1::StreamCastRaysResponse reply;
    (*stream)->WritesDone();
    if ((*stream)->Read(&reply)) ++answered;
    const grpc::Status status = (*stream)->Finish();
    if (!status.ok()) {
      ++refused;
      EXPECT_EQ(reason_of(status), "QUEUE_FULL") << status.error_message();
      unread += status.error_message().find("not read") != std::string::npos ? 1 : 0;
    }
  }
  EXPECT_GT(answered, 0u);
  EXPECT_GT(unread, 0u) << "others may wait for the admission of their rays";
  EXPECT_EQ(answered + refused, kStreams);
  expect_serving();
}

}  // namespace
}  // namespace sightline::tests
