// The memory budget of a whole server: whatever clients ask it to hold, it refuses what is over.
#include <grpcpp/client_context.h>
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "tests/server/blobs/blob_of.h"
#include "tests/server/support/live_server.h"
#include "tests/server/updates/update_stream.h"
#include "tests/support/scenes.h"

namespace sightline::tests {
namespace {

server::ServerConfig config_of_little_memory() {
  server::ServerConfig config = test_config();
  config.memory_budget = std::uint64_t{32} << 20;
  config.admission.bytes = std::uint64_t{8} << 20;
  return config;
}

class MemoryTest : public LiveServer {
 protected:
  MemoryTest() : LiveServer(config_of_little_memory()) {}

  void expect_serving(const std::string& scene) {
    v1::CastRaysResponse reply;
    const grpc::Status status =
        Api(connect(server_->port())).cast(cast_request(scene, rays_downward(10)), &reply);
    EXPECT_TRUE(status.ok()) << status.error_message();
  }

  /// What is removed or evicted is freed once no thread reads it: until then an upload is refused.
  /// The limit of time only ends a failing test.
  void make_scene_once_it_fits(const std::string& scene, const TestMesh& mesh) {
    const std::string blob = blob_of(mesh), digest = digest_of(blob).text();
    const auto latest = std::chrono::steady_clock::now() + std::chrono::minutes(1);
    grpc::Status uploaded = api_.upload(blob, digest);
    while (uploaded.error_code() == grpc::StatusCode::RESOURCE_EXHAUSTED &&
           std::chrono::steady_clock::now() < latest) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      uploaded = api_.upload(blob, digest);
    }
    ASSERT_TRUE(uploaded.ok()) << uploaded.error_message();
    ASSERT_TRUE(api_.create(scene).ok());
    ASSERT_TRUE(api_.apply(scene, {put_node(-1, digest)}).ok());
  }
};

/// Twelve bytes of a request would make a copy of all vertices.
TEST_F(MemoryTest, PatchesOfManyInstancesAreRefusedBeforeTheyAreMade) {
  const TestMesh sheet = planar_sheet(300);  // about a megabyte of vertices
  ASSERT_TRUE(api_.create(kScene).ok());
  const std::string digest = api_.add_mesh(sheet);
  constexpr int kNodes = 60;
  std::vector<v1::Update> nodes, patches;
  for (int i = 1; i <= kNodes; ++i) {
    nodes.push_back(put_node(-i, digest));
    patches.push_back(patch({static_cast<std::uint64_t>(i)}, 0, {{0, 0, 1}}));
  }
  ASSERT_TRUE(api_.apply(kScene, nodes).ok());
  const grpc::Status refused = api_.apply(kScene, patches);
  EXPECT_EQ(refused.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(reason_of(refused), "MEMORY_BUDGET") << refused.error_message();
  EXPECT_EQ(api_.get(kScene).head().revision(), 1u);
  EXPECT_EQ(api_.get(kScene).meshes(), 1u);
  // A few fit, again and again: revisions before them go.
  for (int round = 0; round < 20; ++round) {
    const std::vector<v1::Update> few(patches.begin(), patches.begin() + 5);
    const grpc::Status applied = api_.apply(kScene, few);
    ASSERT_TRUE(applied.ok()) << round << applied.error_message();
  }
  expect_serving(kScene);
  ASSERT_TRUE(api_.remove(kScene).ok());
}

TEST_F(MemoryTest, NodesAreBoundedAndDeletesAreNot) {
  ASSERT_TRUE(api_.create(kScene).ok());
  std::vector<v1::Update> nodes;
  for (int i = 1; i <= 2000; ++i) nodes.push_back(put_node(-i));
  for (v1::Update& node : nodes) node.mutable_put_node()->set_name(std::string(1000, 'n'));
  grpc::Status status;
  int batches = 0;
  while (status.ok() && batches < 100) {
    status = api_.apply(kScene, nodes);
    batches += status.ok() ? 1 : 0;
  }
  EXPECT_EQ(reason_of(status), "MEMORY_BUDGET") << status.error_message();
  EXPECT_GT(batches, 2);
  EXPECT_LT(batches, 12) << "two megabytes of names each";
  std::vector<v1::Update> removals(1500);
  for (std::size_t i = 0; i < removals.size(); ++i)
    removals[i].mutable_delete_node()->set_node(static_cast<std::int64_t>(i + 1));
  status = api_.apply(kScene, removals);
  EXPECT_TRUE(status.ok()) << status.error_message();
  ASSERT_TRUE(api_.remove(kScene).ok());
}

/// Logs of many scenes.
TEST_F(MemoryTest, OldUpdatesGoWhenMemoryIsNeeded) {
  constexpr int kRows = 10'000;  // about a megabyte
  for (int s = 0; s < 4; ++s) {
    const std::string scene = kScene + std::to_string(s);
    ASSERT_TRUE(api_.create(scene).ok());
    ASSERT_TRUE(api_.apply(scene, {put_node(-1)}).ok());
    v1::Update update;
    v1::SetTransforms& rows = *update.mutable_set_transforms();
    for (int i = 0; i < kRows; ++i) rows.add_nodes(1);
    for (const v1::Update one = move_to(1, 5); rows.matrices().size() < kRows * std::size_t{96};)
      rows.mutable_matrices()->append(one.set_transforms().matrices());
    for (int i = 0; i < 12; ++i) {
      const grpc::Status applied = api_.apply(scene, {update});
      ASSERT_TRUE(applied.ok()) << applied.error_message();
    }
  }
  for (int s = 0; s < 4; ++s) {
    const grpc::Status removed = api_.remove(kScene + std::to_string(s));
    EXPECT_TRUE(removed.ok()) << removed.error_message();
  }
}

/// Batches that are never ended hold their own part of the bytes in work.
TEST_F(MemoryTest, HalfSentBatchesLeaveOthersTheirShare) {
  api_.make_scene(kScene, planar_sheet(1));
  const std::vector<v1::Update> part{
      patch({1}, 0, std::vector<accel::geometry::Vec3f>(80'000))};  // about a megabyte
  std::vector<std::unique_ptr<Api>> clients;
  std::vector<std::unique_ptr<UpdateStream>> streams;
  for (int i = 0; i < 3; ++i) {
    clients.push_back(std::make_unique<Api>(connect(server_->port())));
    streams.push_back(std::make_unique<UpdateStream>(*clients.back()));
    streams.back()->open(kScene, "robot" + std::to_string(i));
    ASSERT_TRUE(streams.back()->send(1, part, true));
  }
  // When the server has all of them no answer tells. The limit only ends a failing test.
  const auto latest = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  std::string reason;
  do {
    Api client(connect(server_->port()));
    UpdateStream stream(client);
    stream.open(kScene, "another_robot");
    stream.send(1, part, true);
    stream.send(9, part, true);  // ends the call in any case
    reason = reason_of(stream.finish());
  } while (reason == "BATCH_NOT_FINISHED" && std::chrono::steady_clock::now() < latest);
  EXPECT_EQ(reason, "QUEUE_FULL");
  expect_serving(kScene);
  EXPECT_EQ(api_.get(kScene).nodes(), 1u);
}

/// Trees of scenes that were cast at and deleted.
TEST_F(MemoryTest, TreesCountAndGo) {
  for (int i = 0; i < 12; ++i) {
    const std::string scene = kScene + std::to_string(i);
    TestMesh sheet = planar_sheet(250);  // 2.3 MB, and as much and more of trees
    sheet.vertices.front().z = static_cast<float>(i);
    ASSERT_NO_FATAL_FAILURE(make_scene_once_it_fits(scene, sheet));
    v1::CastRaysRequest request = cast_request(scene, rays_downward(10));
    request.set_build(v1::BUILD_MODE_FULL);
    v1::CastRaysResponse reply;
    const grpc::Status status = api_.cast(request, &reply);
    ASSERT_TRUE(status.ok()) << i << status.error_message();
    if (i % 2 == 0) {
      ASSERT_TRUE(api_.remove(scene).ok());
    }
  }
  const auto held = [this] {
    std::uint64_t bytes = 0;
    for (int i = 1; i < 12; i += 2) {
      const v1::GetSceneStatsResponse stats = api_.stats(kScene + std::to_string(i));
      bytes += stats.bytes_trees() + stats.bytes_geometry();
    }
    return bytes;
  };
  // The server measures its trees from time to time. The limit only ends a failing test.
  const auto latest = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  while (held() > config_of_little_memory().memory_budget &&
         std::chrono::steady_clock::now() < latest)
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_LE(held(), config_of_little_memory().memory_budget);
}

}  // namespace
}  // namespace sightline::tests
