// A whole server: start, misbehaving peers, and draining.
#include "server/server.h"

#include <grpcpp/client_context.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/support/byte_buffer.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "tests/server/support/garbage.h"
#include "tests/server/support/live_server.h"
#include "tests/server/support/tcp.h"
#include "tests/support/scenes.h"

namespace sightline::tests {
namespace {

/// One message in each direction, as bytes, on a stream that stays open until `context` is
/// cancelled.
class RawCall final : public grpc::ClientBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer> {
 public:
  RawCall(const std::shared_ptr<grpc::Channel>& channel, const std::string& method,
          const std::string& message)
      : stub_(channel), slice_(message), request_(&slice_, 1) {
    stub_.PrepareBidiStreamingCall(&context_, method, {}, this);
    StartWrite(&request_);
    StartRead(&reply_);
    StartCall();
  }
  ~RawCall() override {
    context_.TryCancel();
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return done_; });
  }

  /// Waits for the next message; empty after the call has ended.
  std::string next() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return !unread_.empty() || done_; });
    return std::exchange(unread_, {});
  }

  void OnReadDone(bool ok) override {
    if (!ok) return;
    std::vector<grpc::Slice> slices;
    static_cast<void>(reply_.Dump(&slices));
    {
      const std::lock_guard lock(mutex_);
      for (const grpc::Slice& slice : slices)
        unread_.append(reinterpret_cast<const char*>(slice.begin()), slice.size());
    }
    changed_.notify_all();
    StartRead(&reply_);
  }
  void OnDone(const grpc::Status&) override {
    const std::lock_guard lock(mutex_);
    done_ = true;
    changed_.notify_all();
  }

 private:
  grpc::TemplatedGenericStub<grpc::ByteBuffer, grpc::ByteBuffer> stub_;
  grpc::ClientContext context_;
  grpc::Slice slice_;
  grpc::ByteBuffer request_;
  grpc::ByteBuffer reply_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::string unread_;
  bool done_ = false;
};

class ServerTest : public LiveServer {
 protected:
  grpc::Status cast_one() {
    v1::CastRaysResponse reply;
    return api_.cast(cast_request(kScene, rays_downward(1)), &reply);
  }
};

TEST_F(ServerTest, ReportsItsLimits) {
  grpc::ClientContext context;
  v1::GetServerInfoResponse info;
  ASSERT_TRUE(api_.server->GetServerInfo(&context, {}, &info).ok());
  EXPECT_FALSE(info.version().empty());
  EXPECT_EQ(info.policy(), "first-touch");
  EXPECT_EQ(info.threads(), 2u);
  EXPECT_EQ(info.max_rays_per_request(), 16384u);
  EXPECT_EQ(info.max_message_bytes(), std::uint64_t{4} << 20);
  EXPECT_EQ(info.max_blob_chunk_bytes(), std::uint64_t{1} << 20);
  EXPECT_GT(info.max_triangles_per_mesh(), 0u);
  EXPECT_GT(info.max_rays_queued(), 0u);
  EXPECT_EQ(info.max_prefetches(), 4u);
  EXPECT_EQ(info.max_updates_per_batch(), 65536u);
  EXPECT_EQ(info.max_batch_bytes(), std::uint64_t{64} << 20);
  EXPECT_EQ(info.update_window(), 16u);
  EXPECT_EQ(info.max_update_streams(), 256u);
  EXPECT_EQ(info.max_watches(), 256u);
  EXPECT_EQ(info.max_waiting_reads(), 256u);
  EXPECT_EQ(info.max_read_wait_ms(), 2000u);
  EXPECT_EQ(info.max_exact_revisions(), 64u);
  EXPECT_EQ(info.max_logged_revisions(), 1024u);
  EXPECT_EQ(info.max_request_ids(), 1024u);
  EXPECT_EQ(info.max_producers(), 4096u);
  EXPECT_FALSE(info.simd_target().empty());
  EXPECT_EQ(info.memory_budget_bytes(), test_config().memory_budget);
  EXPECT_EQ(info.max_cast_streams(), 256u);
  EXPECT_EQ(info.max_streams_per_connection(), 32u);
  EXPECT_EQ(info.reply_timeout_ms(), 30'000u);
  const std::set<std::string> features(info.features().begin(), info.features().end());
  for (const char* feature :
       {"closest", "time-budget", "partial-answers", "read-mesh", "cool", "deferred-cells", "log"})
    EXPECT_TRUE(features.contains(feature)) << feature;
  EXPECT_FALSE(features.contains("shards") || features.contains("durable"));
  std::vector<const google::protobuf::FieldDescriptor*> reported;
  info.GetReflection()->ListFields(info, &reported);
  EXPECT_FALSE(info.has_storage()) << "this server has no data directory";
  EXPECT_EQ(info.max_segment_bytes(), 0u) << "this client is not at a Unix socket";
  EXPECT_EQ(info.max_rays_per_shared_request(), 262'144u);
  // And the two counts of what was evicted, which are 0.
  EXPECT_EQ(reported.size() + 4, static_cast<std::size_t>(info.GetDescriptor()->field_count()))
      << "a limit is missing";
}

TEST_F(ServerTest, ReportsWhatItHolds) {
  api_.make_scene(kScene, planar_sheet(60));
  ASSERT_TRUE(cast_one().ok());
  grpc::ClientContext context;
  v1::GetServerInfoResponse info;
  ASSERT_TRUE(api_.server->GetServerInfo(&context, {}, &info).ok());
  const auto bytes = [](const auto& held, const std::string& kind) {
    const auto found =
        std::find_if(held.begin(), held.end(), [&](const auto& one) { return one.kind() == kind; });
    EXPECT_NE(found, held.end()) << kind;
    return found == held.end() ? 0 : found->bytes();
  };
  EXPECT_GE(bytes(info.memory(), "meshes"), 61u * 61 * 12 + 60u * 60 * 2 * 12);
  EXPECT_GT(bytes(info.memory(), "nodes"), 0u);
  EXPECT_GT(bytes(info.memory(), "trees"), 0u);
  EXPECT_EQ(bytes(info.memory(), "patches"), 0u);
  std::uint64_t of_trees = 0;
  for (const v1::HeldBytes& part : info.tree_memory()) of_trees += part.bytes();
  EXPECT_GT(of_trees, 0u);
  EXPECT_GT(bytes(info.tree_memory(), "lists"), 0u);
}

TEST_F(ServerTest, ServesHealthAndReflection) {
  const std::string serving("\x08\x01", 2),
      not_serving("\x08\x02", 2);  // HealthCheckResponse.status
  auto health = std::make_unique<RawCall>(channel_, "/grpc.health.v1.Health/Watch", "");
  EXPECT_EQ(health->next(), serving);
  {
    RawCall reflection(channel_, "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo",
                       std::string("\x3a\x01*", 3));  // list_services
    const std::string services = reflection.next();
    for (const char* name :
         {"sightline.v1.SceneService", "sightline.v1.BlobService", "sightline.v1.RayQueryService",
          "sightline.v1.ServerService", "grpc.health.v1.Health"}) {
      EXPECT_NE(services.find(name), std::string::npos) << name;
    }
  }
  std::thread drain([&] { server_->drain(); });
  EXPECT_EQ(health->next(), not_serving);
  drain.join();
}

TEST_F(ServerTest, GarbageOnThePortDoesNoHarm) {
  api_.make_scene(kScene, planar_sheet(1));
  for (int i = 0; i < 20; ++i) send_garbage(server_->port());
  EXPECT_TRUE(cast_one().ok());
}

TEST_F(ServerTest, RefusesAMessageOverItsLimit) {
  api_.make_scene(kScene, planar_sheet(1));
  for (const std::size_t bytes : {std::size_t{5} << 20, std::size_t{64} << 20}) {
    v1::CastRaysRequest request;
    request.set_scene(kScene);
    request.mutable_rays()->set_origins(std::string(bytes, '\0'));
    v1::CastRaysResponse reply;
    const grpc::Status status = api_.cast(request, &reply);
    EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED) << status.error_message();
    // What is longer than the transport's part of the budget is not taken in full.
    if (bytes < server::exec::MemoryParts::of(test_config().memory_budget).transport) {
      EXPECT_NE(status.error_message().find("4194304"), std::string::npos)
          << status.error_message();
    }
  }
  EXPECT_TRUE(cast_one().ok());
}

TEST_F(ServerTest, DrainsOnceAndRefusesCallsAfterwards) {
  api_.make_scene(kScene, planar_sheet(1));
  server_->drain();
  server_->drain();
  EXPECT_EQ(cast_one().error_code(), grpc::StatusCode::UNAVAILABLE);
}

TEST(Server, DrainingDoesNotWaitForAClientThatDoesNotLook) {
  server::ServerConfig config = test_config();
  config.drain = std::chrono::hours(1);
  const auto server = server::Server::start(config);
  ASSERT_TRUE(server);
  const auto client = connect_tcp((*server)->port());
  const std::string no_settings("\0\0\0\4\0\0\0\0\0", 9);
  send_bytes(client, "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + no_settings);
  ASSERT_FALSE(receive_bytes(client).empty());  // the server's settings
  (*server)->drain();
}

TEST(Server, CancelsRemainingCallsWhenDrainingEnds) {
  server::ServerConfig config = test_config();
  config.drain = std::chrono::milliseconds(0);
  const auto server = server::Server::start(config);
  ASSERT_TRUE(server);
  Api api(connect((*server)->port()));
  api.make_scene(kScene, planar_sheet(1));
  grpc::ClientContext context;
  const auto stream = api.rays->StreamCastRays(&context);
  v1::StreamCastRaysRequest request;
  v1::StreamCastRaysResponse reply;
  *request.mutable_request() = cast_request(kScene, rays_downward(1));
  ASSERT_TRUE(stream->Write(request));
  ASSERT_TRUE(stream->Read(&reply));
  (*server)->drain();
  EXPECT_FALSE(stream->Read(&reply));
  EXPECT_FALSE(stream->Finish().ok());
}

TEST(Server, DrainingEndsAPrefetchAtOnce) {
  server::ServerConfig config = test_config();
  config.drain = std::chrono::hours(1);
  const auto server = server::Server::start(config);
  ASSERT_TRUE(server);
  Api api(connect((*server)->port()));
  api.make_scene(kScene, planar_sheet(1000));
  v1::PrefetchRequest request;
  request.set_scene(kScene);
  grpc::ClientContext context;
  const auto reader = api.rays->Prefetch(&context, request);
  v1::PrefetchResponse report;
  ASSERT_TRUE(reader->Read(&report));  // The prefetch is running, or has just finished
  const bool was_done = report.done();
  (*server)->drain();
  while (reader->Read(&report)) {
  }
  const grpc::Status status = reader->Finish();
  EXPECT_TRUE(was_done || report.done() || reason_of(status) == "STOPPING")
      << status.error_message();
}

TEST(Server, RefusesAPortInUse) {
  const auto first = server::Server::start(test_config());
  ASSERT_TRUE(first);
  server::ServerConfig config = test_config();
  config.listen = "127.0.0.1:" + std::to_string((*first)->port());
  const auto second = server::Server::start(config);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, Code::kUnavailable);
  EXPECT_NE(second.error().message.find(config.listen), std::string::npos);
}

TEST(Server, RefusesAPublicAddressWithoutTheFlag) {
  server::ServerConfig config = test_config();
  config.listen = "0.0.0.0:0";
  const auto refused = server::Server::start(config);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "INSECURE_ADDRESS");
  config.insecure = true;
  EXPECT_TRUE(server::Server::start(config));
}

}  // namespace
}  // namespace sightline::tests
