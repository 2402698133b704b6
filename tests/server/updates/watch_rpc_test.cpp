// WatchScene through a real server.
#include "server/updates/watch_rpc.h"

#include <grpcpp/client_context.h>
#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "server/exec/call_registry.h"
#include "server/exec/shares.h"
#include "server/scenes/history.h"
#include "tests/server/support/live_server.h"
#include "tests/server/updates/update_stream.h"
#include "tests/support/scenes.h"

namespace sightline::tests {
namespace {

class Watcher {
 public:
  Watcher(Api& api, const std::string& scene, std::optional<std::uint64_t> start = {}) {
    v1::WatchSceneRequest request;
    request.set_scene(scene);
    if (start) request.set_start_revision(*start);
    reader_ = api.scenes->WatchScene(&context_, request);
  }
  ~Watcher() {
    context_.TryCancel();
    if (!finished_) finish();
  }

  bool read(v1::WatchSceneResponse& message) { return reader_->Read(&message); }
  /// The next event that is not progress, with its messages merged.
  bool revision(v1::WatchSceneResponse& whole) {
    whole.Clear();
    v1::WatchSceneResponse message;
    while (read(message)) {
      if (message.progress()) continue;
      EXPECT_LT(message.ByteSizeLong(), std::size_t{1} << 20);
      whole.MergeFrom(message);
      if (!message.more()) return true;
      ++parts_;
    }
    return false;
  }
  int parts() const { return parts_; }
  void cancel() { context_.TryCancel(); }
  grpc::Status finish() {
    finished_ = true;
    v1::WatchSceneResponse message;
    while (reader_->Read(&message)) {
    }
    return reader_->Finish();
  }

 private:
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReader<v1::WatchSceneResponse>> reader_;
  int parts_ = 0;
  bool finished_ = false;
};

class WatchRpcTest : public LiveServer {
 protected:
  void SetUp() override { ASSERT_TRUE(api_.create(kScene).ok()); }
};

TEST_F(WatchRpcTest, BeginsWithTheCurrentRevisionAndReportsNewOnes) {
  ASSERT_TRUE(api_.apply(kScene, {put_node(-1)}).ok());
  Watcher watcher(api_, kScene);
  v1::WatchSceneResponse message;
  ASSERT_TRUE(watcher.read(message));
  EXPECT_TRUE(message.progress());
  EXPECT_EQ(message.revision().revision(), 1u);
  EXPECT_EQ(message.revision().token(), api_.get(kScene).head().token());

  v1::Update named = put_node(-7, api_.add_mesh(cube()), 1);
  named.mutable_put_node()->set_name("crate");
  named.mutable_put_node()->set_mobility(v1::MOBILITY_RIGID);
  named.mutable_put_node()->set_mask(6);
  v1::Update moved = move_to(1, 5);
  moved.mutable_set_transforms()->set_nodes(0, -7);
  v1::Update patched = patch({}, 2, {{1, 2, 3}});
  patched.mutable_patch_vertices()->add_nodes(-7);
  v1::Update removed;
  removed.mutable_delete_node()->set_node(-7);
  ASSERT_TRUE(api_.apply(kScene, {named, moved, patched, removed}).ok());
  ASSERT_TRUE(watcher.revision(message));
  EXPECT_EQ(message.revision().revision(), 2u);
  ASSERT_EQ(message.updates_size(), 4);
  const v1::PutNode& put = message.updates(0).put_node();
  EXPECT_EQ(put.node(), 2);
  EXPECT_EQ(put.parent(), 1);
  EXPECT_EQ(put.name(), "crate");
  EXPECT_EQ(put.mesh_digest(), named.put_node().mesh_digest());
  EXPECT_EQ(put.mobility(), v1::MOBILITY_RIGID);
  EXPECT_EQ(put.mask(), 6u);
  EXPECT_EQ(message.updates(1).set_transforms().nodes(0), 2);
  EXPECT_EQ(message.updates(1).set_transforms().matrices(), moved.set_transforms().matrices());
  EXPECT_EQ(message.updates(2).patch_vertices().nodes(0), 2);
  EXPECT_EQ(message.updates(2).patch_vertices().first(), 2u);
  EXPECT_EQ(message.updates(2).patch_vertices().positions(), patched.patch_vertices().positions());
  EXPECT_EQ(message.updates(3).delete_node().node(), 2);
}

TEST_F(WatchRpcTest, ReportsEveryRevisionFromTheStart) {
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(api_.apply(kScene, {put_node(-1)}).ok());
  Watcher watcher(api_, kScene, 5);
  v1::WatchSceneResponse message;
  ASSERT_TRUE(watcher.read(message));
  EXPECT_TRUE(message.progress());
  EXPECT_EQ(message.revision().revision(), 5u);
  for (std::uint64_t revision = 6; revision <= 20; ++revision) {
    ASSERT_TRUE(watcher.revision(message));
    EXPECT_EQ(message.revision().revision(), revision);
    EXPECT_EQ(message.updates(0).put_node().node(), static_cast<std::int64_t>(revision));
  }
}

TEST_F(WatchRpcTest, RefusesDroppedAndFutureRevisions) {
  Watcher early(api_, kScene, 1);
  EXPECT_EQ(early.finish().error_code(), grpc::StatusCode::OUT_OF_RANGE);
  const std::uint64_t count = server::scenes::LogLimits().revisions + 10;
  UpdateStream stream(api_);
  stream.open(kScene);
  std::thread writer([&] {
    for (std::uint64_t i = 1; i <= count; ++i) EXPECT_TRUE(stream.send(i, {}));
  });
  stream.read_up_to(count);
  writer.join();
  Watcher late(api_, kScene, 9);
  const grpc::Status status = late.finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::OUT_OF_RANGE);
  EXPECT_EQ(reason_of(status), "REVISION_NOT_KEPT");
  EXPECT_NE(status.error_message().find("11 to 1034"), std::string::npos) << status.error_message();
  Watcher just(api_, kScene, 10);
  v1::WatchSceneResponse message;
  ASSERT_TRUE(just.revision(message));
  EXPECT_EQ(message.revision().revision(), 11u);
  Watcher unknown(api_, "projects/p/scenes/none");
  EXPECT_EQ(unknown.finish().error_code(), grpc::StatusCode::NOT_FOUND);
}

TEST_F(WatchRpcTest, LargeRevisionsAreSplit) {
  const std::string mesh = api_.add_mesh(planar_sheet(400));
  v1::ApplyUpdatesResponse reply;
  ASSERT_TRUE(api_.apply(kScene, {put_node(-1, mesh)}, &reply).ok());
  // From here: the stream of a later beginning would not have these revisions.
  Watcher watcher(api_, kScene, reply.revision().revision());
  std::vector<accel::geometry::Vec3f> positions(150'000);
  for (std::size_t i = 0; i < positions.size(); ++i) positions[i] = {static_cast<float>(i), 1, 2};
  v1::Update moves;
  for (int i = 0; i < 20'000; ++i) {
    const v1::Update one = move_to(reply.nodes(0), i);
    moves.mutable_set_transforms()->add_nodes(one.set_transforms().nodes(0));
    moves.mutable_set_transforms()->mutable_matrices()->append(one.set_transforms().matrices());
  }
  ASSERT_TRUE(api_.apply(kScene, {patch({reply.nodes(0)}, 7, positions)}).ok());
  ASSERT_TRUE(api_.apply(kScene, {moves}).ok());
  v1::WatchSceneResponse message;
  ASSERT_TRUE(watcher.revision(message));
  EXPECT_GE(watcher.parts(), 1);
  std::string bytes;
  for (const v1::Update& update : message.updates()) {
    EXPECT_EQ(update.patch_vertices().first(), 7 + bytes.size() / sizeof(accel::geometry::Vec3f));
    bytes += update.patch_vertices().positions();
  }
  EXPECT_EQ(bytes.size(), positions.size() * sizeof(accel::geometry::Vec3f));
  EXPECT_EQ(std::memcmp(bytes.data(), positions.data(), bytes.size()), 0);
  ASSERT_TRUE(watcher.revision(message));
  std::string matrices;
  for (const v1::Update& update : message.updates()) matrices += update.set_transforms().matrices();
  EXPECT_EQ(matrices, moves.set_transforms().matrices());
}

TEST_F(WatchRpcTest, SeesEveryRevisionOfConcurrentWriters) {
  constexpr int kWriters = 4, kEach = 150;
  std::vector<std::thread> threads;
  for (int w = 0; w < kWriters; ++w) {
    threads.emplace_back([&, w] {
      Api api(connect(server_->port()));
      if (w % 2 == 0) {
        for (int i = 0; i < kEach; ++i) EXPECT_TRUE(api.apply(kScene, {put_node(-1)}).ok());
        return;
      }
      UpdateStream stream(api);
      stream.open(kScene, "w" + std::to_string(w));
      for (std::uint64_t i = 1; i <= kEach; ++i) EXPECT_TRUE(stream.send(i, {put_node(-1)}));
      stream.read_up_to(kEach);
    });
  }
  for (int w = 0; w < 3; ++w) {
    threads.emplace_back([&] {
      Api api(connect(server_->port()));
      Watcher watcher(api, kScene, 0);
      v1::WatchSceneResponse message;
      for (std::uint64_t revision = 1; revision <= kWriters * kEach; ++revision) {
        ASSERT_TRUE(watcher.revision(message));
        ASSERT_EQ(message.revision().revision(), revision);
        ASSERT_EQ(message.updates_size(), 1);
        ASSERT_EQ(message.updates(0).put_node().node(), static_cast<std::int64_t>(revision));
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
}

TEST_F(WatchRpcTest, EndsWithTheSceneTheServerOrTheClient) {
  Watcher cancelled(api_, kScene);
  cancelled.cancel();
  EXPECT_EQ(cancelled.finish().error_code(), grpc::StatusCode::CANCELLED);
  ASSERT_TRUE(api_.create("projects/p/scenes/t").ok());
  Watcher removed(api_, kScene), stopped(api_, "projects/p/scenes/t");
  v1::WatchSceneResponse message;
  ASSERT_TRUE(removed.read(message));
  ASSERT_TRUE(stopped.read(message));
  ASSERT_TRUE(api_.remove(kScene).ok());
  EXPECT_EQ(removed.finish().error_code(), grpc::StatusCode::NOT_FOUND);
  std::thread drain([&] { server_->drain(); });
  EXPECT_EQ(reason_of(stopped.finish()), "STOPPING");
  drain.join();
}

TEST_F(WatchRpcTest, BoundsTheWatches) {
  std::vector<Api> clients;
  std::vector<std::unique_ptr<Watcher>> watchers;
  v1::WatchSceneResponse message;
  const auto limits = server::exec::ShareLimits::of(server::updates::kMaxWatches,
                                                    server::exec::kConnectionCallShare);
  for (std::size_t i = 0; i < limits.principal; ++i) {
    if (i % limits.connection == 0) clients.emplace_back(connect(server_->port()));
    watchers.push_back(std::make_unique<Watcher>(clients.back(), kScene));
    ASSERT_TRUE(watchers.back()->read(message));
  }
  clients.emplace_back(connect(server_->port()));
  Watcher one_more(clients.back(), kScene);
  EXPECT_EQ(reason_of(one_more.finish()), "TOO_MANY_WATCHES");
}

}  // namespace
}  // namespace sightline::tests
