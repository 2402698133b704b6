// ApplyUpdates with request ids, through a real server.
#include "server/updates/apply_rpc.h"

#include <grpcpp/client_context.h>
#include <gtest/gtest.h>

#include <atomic>
#include <string>
#include <thread>
#include <vector>

#include "server/scenes/idempotency.h"
#include "tests/server/support/live_server.h"
#include "tests/support/scenes.h"

namespace sightline::tests {
namespace {

class ApplyRpcTest : public LiveServer {
 protected:
  void SetUp() override { ASSERT_TRUE(api_.create(kScene).ok()); }

  static grpc::Status apply(Api& api, const std::string& id, const std::vector<v1::Update>& updates,
                            v1::ApplyUpdatesResponse* reply) {
    grpc::ClientContext context;
    v1::ApplyUpdatesRequest request;
    request.set_scene(kScene);
    request.set_request_id(id);
    request.mutable_updates()->Assign(updates.begin(), updates.end());
    return api.scenes->ApplyUpdates(&context, request, reply);
  }
};

TEST_F(ApplyRpcTest, ARepeatReturnsTheFirstAnswer) {
  v1::ApplyUpdatesResponse first, again, other;
  ASSERT_TRUE(apply(api_, "a", {put_node(-1), put_node(-2)}, &first).ok());
  EXPECT_FALSE(first.replayed());
  ASSERT_TRUE(apply(api_, "b", {put_node(-1)}, &other).ok());
  ASSERT_TRUE(apply(api_, "a", {put_node(-1), put_node(-2)}, &again).ok());
  EXPECT_TRUE(again.replayed());
  EXPECT_EQ(again.revision().token(), first.revision().token());
  EXPECT_EQ(std::vector(again.nodes().begin(), again.nodes().end()),
            std::vector(first.nodes().begin(), first.nodes().end()));
  EXPECT_EQ(api_.get(kScene).nodes(), 3u);
}

TEST_F(ApplyRpcTest, ARequestThatFailedIsNotRemembered) {
  v1::ApplyUpdatesResponse reply;
  EXPECT_EQ(apply(api_, "a", {put_node(-1, "", 1)}, &reply).error_code(),
            grpc::StatusCode::NOT_FOUND);
  ASSERT_TRUE(apply(api_, "b", {put_node(-1)}, &reply).ok());
  ASSERT_TRUE(apply(api_, "a", {put_node(-1, "", 1)}, &reply).ok());
  EXPECT_FALSE(reply.replayed());
}

TEST_F(ApplyRpcTest, AnIdBelongsToOneRequest) {
  v1::ApplyUpdatesResponse reply;
  ASSERT_TRUE(apply(api_, "a", {put_node(-1)}, &reply).ok());
  const grpc::Status other = apply(api_, "a", {put_node(-2)}, &reply);
  EXPECT_EQ(other.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(reason_of(other), "REQUEST_ID_REUSED");
  const std::string limit(server::scenes::kMaxRequestId, 'x');
  EXPECT_TRUE(apply(api_, limit, {put_node(-1)}, &reply).ok());
  EXPECT_EQ(reason_of(apply(api_, limit + "x", {put_node(-1)}, &reply)), "REQUEST_ID_TOO_LONG");
  EXPECT_EQ(api_.get(kScene).nodes(), 2u);
}

TEST_F(ApplyRpcTest, ConcurrentRepeatsAreAppliedOnce) {
  constexpr int kThreads = 8, kRequests = 40;
  std::atomic<int> fresh{0};
  std::vector<std::thread> threads;
  for (int t = 0; t < kThreads; ++t) {
    threads.emplace_back([&] {
      Api api(connect(server_->port()));
      for (int i = 0; i < kRequests; ++i) {
        v1::ApplyUpdatesResponse reply;
        const grpc::Status status = apply(api, std::to_string(i), {put_node(-1)}, &reply);
        EXPECT_TRUE(status.ok()) << status.error_message();
        EXPECT_EQ(reply.nodes_size(), 1);
        if (!reply.replayed()) ++fresh;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(fresh, kRequests);
  EXPECT_EQ(api_.get(kScene).nodes(), static_cast<std::uint64_t>(kRequests));
  EXPECT_EQ(api_.get(kScene).head().revision(), static_cast<std::uint64_t>(kRequests));
}

TEST_F(ApplyRpcTest, ARepeatIsAnsweredAfterItsMeshWasEvicted) {
  const std::string digest = api_.add_mesh(cube());
  const auto update = put_node(-1, digest);
  v1::ApplyUpdatesResponse reply;
  ASSERT_TRUE(apply(api_, "a", {update}, &reply).ok());
  v1::Update removal;
  removal.mutable_delete_node()->set_node(1);
  ASSERT_TRUE(api_.apply(kScene, {removal}).ok());
  // Large enough that the unused mesh is evicted; an earlier revision still holds it.
  std::vector<TestMesh> meshes;
  for (int i = 0; i < 3; ++i) {
    meshes.push_back(planar_sheet(1800));
    meshes.back().vertices[0].z = static_cast<float>(i);
    api_.add_mesh(meshes.back());
  }
  ASSERT_TRUE(apply(api_, "a", {update}, &reply).ok());
  EXPECT_TRUE(reply.replayed());
}

}  // namespace
}  // namespace sightline::tests
