// Scenes that come whole, through a real server.
#include "server/updates/put_scene_rpc.h"

#include <grpcpp/client_context.h>
#include <gtest/gtest.h>

#include <string>
#include <thread>
#include <vector>

#include "tests/server/support/live_server.h"
#include "tests/support/scenes.h"

namespace sightline::tests {
namespace {

v1::PutNode node(std::int64_t alias, std::int64_t parent = 0, const std::string& digest = {}) {
  return put_node(alias, digest, parent).put_node();
}

/// `count` nodes with this mesh under one root, the children of a message under a node of the one
/// before.
std::vector<v1::PutSceneRequest> messages(int count, const std::string& digest, bool replace) {
  std::vector<v1::PutSceneRequest> sent(1);
  sent[0].mutable_scene()->set_name(kScene);
  sent[0].mutable_scene()->set_up_axis(v1::UP_AXIS_Z);
  sent[0].set_replace(replace);
  *sent[0].add_nodes() = node(-1);
  for (int i = 0; i < count; ++i) *sent.emplace_back().add_nodes() = node(-2 - i, -1, digest);
  sent.back().set_finish(true);
  return sent;
}

class PutScene : public LiveServer {
 protected:
  grpc::Status put(const std::vector<v1::PutSceneRequest>& sent, v1::Scene* made = nullptr) {
    grpc::ClientContext context;
    v1::PutSceneResponse reply;
    const auto writer = api_.scenes->PutScene(&context, &reply);
    for (const v1::PutSceneRequest& message : sent) {
      if (!writer->Write(message)) break;
    }
    writer->WritesDone();
    const grpc::Status status = writer->Finish();
    if (made != nullptr) *made = reply.scene();
    return status;
  }

  grpc::StatusCode get_code() {
    grpc::ClientContext context;
    v1::GetSceneRequest request;
    v1::GetSceneResponse reply;
    request.set_name(kScene);
    return api_.scenes->GetScene(&context, request, &reply).error_code();
  }

  const std::string triangle_ = api_.add_mesh(single_triangle());
};

TEST_F(PutScene, TheNodesOfAllMessagesMakeOneRevision) {
  v1::Scene made;
  const grpc::Status status = put(messages(5, triangle_, false), &made);
  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(made.head().revision(), 1U);
  EXPECT_EQ(made.nodes(), 6U);
  EXPECT_EQ(made.triangles_instanced(), 5U);
  EXPECT_EQ(made.up_axis(), v1::UP_AXIS_Z);
  const v1::Scene found = api_.get(kScene);
  EXPECT_EQ(found.SerializeAsString(), made.SerializeAsString());
  v1::CastRaysResponse reply;
  ASSERT_TRUE(api_.cast(cast_request(kScene, rays_downward(4)), &reply).ok());
  const std::string nodes = column_of(reply, v1::HIT_FIELD_NODE);
  ASSERT_EQ(nodes.size(), 4 * sizeof(std::uint64_t));
  EXPECT_EQ(nodes[0], 2) << "the first of equals, by its id";
  const std::vector<v1::Update> more{put_node(-1, triangle_, 3)};
  v1::ApplyUpdatesResponse applied;
  ASSERT_TRUE(api_.apply(kScene, more, &applied).ok());
  EXPECT_EQ(applied.revision().revision(), 2U);
  EXPECT_EQ(applied.nodes(0), 7U);
}

TEST_F(PutScene, ASceneMayBeEmpty) {
  v1::PutSceneRequest only;
  only.mutable_scene()->set_name(kScene);
  only.set_finish(true);
  ASSERT_TRUE(put({only}).ok());
  EXPECT_EQ(api_.get(kScene).nodes(), 0U);
  EXPECT_EQ(api_.get(kScene).head().revision(), 1U);
}

TEST_F(PutScene, NothingIsMadeWithoutTheEnd) {
  auto sent = messages(5, triangle_, false);
  sent.pop_back();
  const grpc::Status status = put(sent);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(reason_of(status), "NOT_FINISHED");
  EXPECT_EQ(get_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(reason_of(put({})), "NOT_FINISHED");
}

TEST_F(PutScene, ACallThatIsCancelledMakesNothing) {
  const auto sent = messages(2, triangle_, false);
  grpc::ClientContext context;
  v1::PutSceneResponse reply;
  const auto writer = api_.scenes->PutScene(&context, &reply);
  ASSERT_TRUE(writer->Write(sent[0]));
  ASSERT_TRUE(writer->Write(sent[1]));
  context.TryCancel();
  EXPECT_EQ(writer->Finish().error_code(), grpc::StatusCode::CANCELLED);
  EXPECT_EQ(get_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_TRUE(put(sent).ok()) << "nothing of it is left in the way";
}

TEST_F(PutScene, AnExistingSceneStaysUnlessItIsReplaced) {
  ASSERT_TRUE(put(messages(2, triangle_, false)).ok());
  const std::string token = api_.get(kScene).head().token();
  const grpc::Status refused = put(messages(3, triangle_, false));
  EXPECT_EQ(refused.error_code(), grpc::StatusCode::ALREADY_EXISTS);
  EXPECT_EQ(api_.get(kScene).nodes(), 3U);
  ASSERT_TRUE(put(messages(3, triangle_, true)).ok());
  EXPECT_EQ(api_.get(kScene).nodes(), 4U);
  EXPECT_NE(api_.get(kScene).head().token(), token) << "another scene";
}

TEST_F(PutScene, ReplacingMakesASceneThatWasNotThere) {
  ASSERT_TRUE(put(messages(3, triangle_, true)).ok());
  EXPECT_EQ(api_.get(kScene).nodes(), 4U);
}

TEST_F(PutScene, AFailedReplaceLeavesTheOldScene) {
  ASSERT_TRUE(put(messages(2, triangle_, false)).ok());
  const std::string before = api_.get(kScene).SerializeAsString();
  auto bad = messages(5, triangle_, true);
  bad[3].mutable_nodes(0)->set_parent(-77);
  EXPECT_EQ(put(bad).error_code(), grpc::StatusCode::NOT_FOUND);
  bad = messages(5, triangle_, true);
  bad[4].mutable_nodes(0)->set_name(std::string(2000, 'x'));
  EXPECT_EQ(put(bad).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  bad = messages(5, "sha256:" + std::string(64, '0') + "/24", true);
  const grpc::Status missing = put(bad);
  EXPECT_EQ(missing.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_EQ(reason_of(missing), "MESHES_MISSING");
  bad = messages(5, triangle_, true);
  bad[2].mutable_scene()->set_name(kScene);
  EXPECT_EQ(reason_of(put(bad)), "OPENED_TWICE");
  EXPECT_EQ(api_.get(kScene).SerializeAsString(), before);
}

TEST_F(PutScene, AReplacedSceneEndsItsWatches) {
  ASSERT_TRUE(put(messages(2, triangle_, false)).ok());
  grpc::ClientContext context;
  v1::WatchSceneRequest request;
  request.set_scene(kScene);
  const auto watch = api_.scenes->WatchScene(&context, request);
  v1::WatchSceneResponse change;
  ASSERT_TRUE(watch->Read(&change));
  ASSERT_TRUE(put(messages(3, triangle_, true)).ok());
  while (watch->Read(&change)) {
  }
  EXPECT_EQ(watch->Finish().error_code(), grpc::StatusCode::NOT_FOUND);
}

TEST_F(PutScene, ReadersSeeTheOldOrTheNewScene) {
  ASSERT_TRUE(put(messages(2, triangle_, false)).ok());
  std::jthread writer([this](const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      EXPECT_TRUE(put(messages(40, triangle_, true)).ok());
      EXPECT_TRUE(put(messages(2, triangle_, true)).ok());
    }
  });
  for (int i = 0; i < 200; ++i) {
    const std::uint64_t nodes = api_.get(kScene).nodes();
    EXPECT_TRUE(nodes == 3 || nodes == 41) << nodes;
  }
}

}  // namespace
}  // namespace sightline::tests
