// What one server of several answers of scenes that others make and change.
#include <grpcpp/client_context.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "server/scenes/names.h"
#include "tests/server/replicas/replicas.h"
#include "tests/server/updates/update_stream.h"
#include "tests/support/scenes.h"

namespace sightline::tests {
namespace {

class ReplicaReads : public ReplicaTest {
 protected:
  /// Puts a scene of one node in one step, perhaps in place of another.
  static v1::Scene put_scene(Api& api, const std::string& digest, bool replace) {
    grpc::ClientContext context;
    v1::PutSceneRequest request;
    v1::PutSceneResponse reply;
    request.mutable_scene()->set_name(kScene);
    request.set_replace(replace);
    *request.add_nodes() = put_node(-1, digest).put_node();
    request.set_finish(true);
    const auto writer = api.scenes->PutScene(&context, &reply);
    writer->Write(request);
    writer->WritesDone();
    const grpc::Status put = writer->Finish();
    EXPECT_TRUE(put.ok()) << put.error_message();
    return reply.scene();
  }
  /// The scene's revision as this server knows it.
  static std::uint64_t revision(Api& api) { return api.get(kScene).head().revision(); }
};

TEST_F(ReplicaReads, AScene) {
  start_three();
  a_->api().make_scene(kScene, planar_sheet(4));
  v1::CastRaysResponse one, other;
  ASSERT_TRUE(cast_at(a_->api(), {}, &one).ok());
  const grpc::Status cast = cast_at(b_->api(), one.served().token(), &other);
  ASSERT_TRUE(cast.ok()) << cast.error_message();
  EXPECT_EQ(hits_of(one), hits_of(other));
  EXPECT_EQ(one.served().token(), other.served().token());
  EXPECT_EQ(reason_of(b_->api().create(kScene)), "SCENE_EXISTS");
}

TEST_F(ReplicaReads, NoneThatIsOlderThanAToken) {
  start_three();
  a_->api().make_scene(kScene, planar_sheet(1));
  for (int i = 1; i <= 50; ++i) {
    Api& writer = i % 2 == 0 ? a_->api() : b_->api();
    v1::ApplyUpdatesResponse applied;
    const grpc::Status moved = writer.apply(kScene, {move_to(1, i)}, &applied);
    ASSERT_TRUE(moved.ok()) << moved.error_message();
    v1::BatchGetNodesResponse nodes;
    const grpc::Status read = nodes_at(c_->api(), applied.revision().token(), {1}, &nodes);
    ASSERT_TRUE(read.ok()) << read.error_message();
    EXPECT_EQ(nodes.served().revision(), applied.revision().revision());
    EXPECT_EQ(nodes.nodes(0).transform().matrix(3), i);
  }
}

TEST_F(ReplicaReads, AnExactRevisionThatAnotherServerHasMade) {
  start_three();
  a_->api().make_scene(kScene, planar_sheet(1));
  ASSERT_EQ(revision(b_->api()), 1u);
  for (std::uint64_t i = 2; i < 20; ++i) {
    ASSERT_TRUE(a_->api().apply(kScene, {move_to(1, 1)}).ok());
    v1::CastRaysRequest request = cast_request(kScene, rays_downward(1));
    request.mutable_consistency()->set_exact_revision(i);
    v1::CastRaysResponse reply;
    const grpc::Status cast = b_->api().cast(request, &reply);
    ASSERT_TRUE(cast.ok()) << cast.error_message();
    EXPECT_EQ(reply.served().revision(), i);
    request.mutable_consistency()->set_exact_revision(i + 1);
    EXPECT_EQ(reason_of(b_->api().cast(request, &reply)), "REVISION_NOT_KEPT");
  }
}

TEST_F(ReplicaReads, WithoutATokenSoon) {
  start_three();
  a_->api().make_scene(kScene, planar_sheet(1));
  ASSERT_EQ(revision(b_->api()), 1u);
  ASSERT_TRUE(a_->api().apply(kScene, {move_to(1, 1)}).ok());
  wait_until([&] { return revision(b_->api()) == 2; });
  wait_until([&] { return b_->metric("sightline_replica_revisions_followed_total") == 1; });
  EXPECT_EQ(b_->metric("sightline_replica_lag_revisions"), 0);
  EXPECT_EQ(b_->metric("sightline_store_reachable"), 1);
  wait_until([&] { return b_->readiness().find(" 200 ") != std::string::npos; });
}

TEST_F(ReplicaReads, TheListOfScenesSoon) {
  start_three();
  ASSERT_TRUE(a_->api().create(kScene).ok());
  wait_until([&] {
    grpc::ClientContext context;
    v1::ListScenesRequest request;
    v1::ListScenesResponse reply;
    request.set_parent("projects/p");
    EXPECT_TRUE(b_->api().scenes->ListScenes(&context, request, &reply).ok());
    return reply.scenes_size() == 1 && reply.scenes(0).name() == kScene;
  });
}

TEST_F(ReplicaReads, NothingOfASceneThatAnotherServerHasRemoved) {
  start_three();
  a_->api().make_scene(kScene, planar_sheet(1));
  v1::CastRaysResponse reply;
  ASSERT_TRUE(cast_at(b_->api(), {}, &reply).ok());
  ASSERT_TRUE(a_->api().remove(kScene).ok());
  wait_until([&] { return !cast_at(b_->api(), {}, &reply).ok(); });
  EXPECT_EQ(reason_of(cast_at(b_->api(), {}, &reply)), "SCENE_NOT_FOUND");
  EXPECT_EQ(reason_of(c_->api().remove(kScene)), "SCENE_NOT_FOUND");
  EXPECT_TRUE(b_->api().create(kScene).ok()) << "its name is free";
}

TEST_F(ReplicaReads, ASceneThatReplacedAnother) {
  start_three();
  a_->api().make_scene(kScene, planar_sheet(1));
  v1::CastRaysResponse reply;
  ASSERT_TRUE(cast_at(b_->api(), {}, &reply).ok());
  const std::string before = reply.served().token();
  const v1::Scene put = put_scene(a_->api(), a_->api().add_mesh(cube()), true);
  const grpc::Status cast = cast_at(b_->api(), put.head().token(), &reply);
  ASSERT_TRUE(cast.ok()) << cast.error_message();
  EXPECT_EQ(reply.served().token(), put.head().token());
  EXPECT_EQ(reason_of(cast_at(b_->api(), before, &reply)), "BAD_TOKEN");
  v1::ApplyUpdatesResponse applied;
  ASSERT_TRUE(c_->api().apply(kScene, {move_to(1, 3)}, &applied).ok());
  EXPECT_EQ(applied.revision().revision(), 2u);
}

TEST_F(ReplicaReads, AWatchTellsWhatOthersWrite) {
  start_three();
  a_->api().make_scene(kScene, planar_sheet(1));
  grpc::ClientContext context;
  v1::WatchSceneRequest request;
  request.set_scene(kScene);
  request.set_start_revision(0);
  const auto watch = b_->api().scenes->WatchScene(&context, request);
  for (int i = 0; i < 20; ++i) {
    Api& writer = i % 2 == 0 ? a_->api() : c_->api();
    ASSERT_TRUE(writer.apply(kScene, {move_to(1, i)}).ok());
  }
  v1::WatchSceneResponse seen;
  for (std::uint64_t next = 1; next <= 21;) {
    ASSERT_TRUE(watch->Read(&seen));
    if (seen.progress()) continue;
    EXPECT_EQ(seen.revision().revision(), next++);
    ASSERT_EQ(seen.updates_size(), 1);
    EXPECT_EQ(seen.updates(0).has_put_node(), next == 2);
  }
  ASSERT_TRUE(c_->api().remove(kScene).ok());
  while (watch->Read(&seen)) {
  }
  EXPECT_EQ(reason_of(watch->Finish()), "SCENE_NOT_FOUND");
}

TEST_F(ReplicaReads, HitsAreThoseOfTheLogAtEachRevision) {
  start_three();
  server::ServerConfig alone = test_config();
  ReplicaServer plain(alone);
  const TestMesh mesh = planar_sheet(8);
  a_->api().make_scene(kScene, mesh);
  plain.api().make_scene(kScene, mesh);
  std::vector<v1::CastRaysResponse> answers;
  ReplicaServer* const servers[] = {a_.get(), b_.get(), c_.get()};
  for (int i = 0; i < 30; ++i) {
    v1::ApplyUpdatesResponse applied;
    ReplicaServer& writer = *servers[i % 3];
    ASSERT_TRUE(writer.api().apply(kScene, {move_to(1, 0.02 * i)}, &applied).ok());
    ReplicaServer& reader = *servers[(i + 1) % 3];
    ASSERT_TRUE(cast_at(reader.api(), applied.revision().token(), &answers.emplace_back()).ok());
    ASSERT_EQ(answers.back().served().revision(), applied.revision().revision());
  }
  for (std::size_t i = 0; i < answers.size(); ++i) {
    ASSERT_TRUE(plain.api().apply(kScene, {move_to(1, 0.02 * static_cast<double>(i))}).ok());
    v1::CastRaysResponse expected;
    ASSERT_TRUE(cast_at(plain.api(), {}, &expected).ok());
    ASSERT_EQ(expected.served().revision(), answers[i].served().revision());
    EXPECT_EQ(hits_of(answers[i]), hits_of(expected));
  }
}

TEST_F(ReplicaReads, AServerThatStartsLaterIsReadyBeforeItHasReadAnyScene) {
  a_ = start();
  a_->api().make_scene(kScene, planar_sheet(4));
  v1::CastRaysResponse one, other;
  ASSERT_TRUE(cast_at(a_->api(), {}, &one).ok());
  b_ = start();
  EXPECT_NE(b_->readiness().find(" 200 "), std::string::npos);
  ASSERT_TRUE(cast_at(b_->api(), {}, &other).ok());
  EXPECT_EQ(hits_of(one), hits_of(other));
  EXPECT_EQ(one.served().token(), other.served().token());
}

}  // namespace
}  // namespace sightline::tests
