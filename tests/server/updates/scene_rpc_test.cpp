// Scenes and their updates through a real server.
#include "server/updates/scene_rpc.h"

#include <grpcpp/client_context.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

#include "tests/server/blobs/blob_of.h"
#include "tests/server/support/live_server.h"
#include "tests/support/scenes.h"

namespace sightline::tests {
namespace {

class SceneRpcTest : public LiveServer {
 protected:
  grpc::Status create(const v1::Scene& scene, v1::Scene* created = nullptr) {
    grpc::ClientContext context;
    v1::CreateSceneRequest request;
    v1::CreateSceneResponse reply;
    *request.mutable_scene() = scene;
    const grpc::Status status = api_.scenes->CreateScene(&context, request, &reply);
    if (created != nullptr) *created = reply.scene();
    return status;
  }

  grpc::Status list(const std::string& parent, int size, const std::string& token,
                    v1::ListScenesResponse* reply) {
    grpc::ClientContext context;
    v1::ListScenesRequest request;
    request.set_parent(parent);
    request.set_page_size(size);
    request.set_page_token(token);
    return api_.scenes->ListScenes(&context, request, reply);
  }

  std::vector<v1::Node> nodes(const std::vector<std::uint64_t>& ids) {
    grpc::ClientContext context;
    v1::BatchGetNodesRequest request;
    v1::BatchGetNodesResponse reply;
    request.set_scene(kScene);
    request.mutable_ids()->Assign(ids.begin(), ids.end());
    const grpc::Status status = api_.scenes->BatchGetNodes(&context, request, &reply);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return {reply.nodes().begin(), reply.nodes().end()};
  }

  /// Expects that the batch is refused with this error, and that the scene does not change.
  void expect_refused(const std::vector<v1::Update>& updates, grpc::StatusCode code,
                      const std::string& reason) {
    const v1::Scene before = api_.get(kScene);
    const grpc::Status status = api_.apply(kScene, updates);
    EXPECT_EQ(status.error_code(), code) << status.error_message();
    EXPECT_EQ(reason_of(status), reason) << status.error_message();
    const v1::Scene after = api_.get(kScene);
    EXPECT_EQ(after.head().revision(), before.head().revision());
    EXPECT_EQ(after.nodes(), before.nodes());
  }
};

TEST_F(SceneRpcTest, CreatesGetsAndDeletes) {
  v1::Scene scene, created;
  scene.set_name(kScene);
  scene.set_up_axis(v1::UP_AXIS_Z);
  scene.set_meters_per_unit(0.01);
  scene.set_nodes(77);
  ASSERT_TRUE(create(scene, &created).ok());
  EXPECT_EQ(created.name(), kScene);
  EXPECT_EQ(created.head().revision(), 0u);
  EXPECT_EQ(created.nodes(), 0u) << "output only";
  EXPECT_EQ(created.bounds_size(), 0);
  EXPECT_EQ(api_.get(kScene).up_axis(), v1::UP_AXIS_Z);
  EXPECT_EQ(api_.get(kScene).meters_per_unit(), 0.01);

  EXPECT_EQ(create(scene).error_code(), grpc::StatusCode::ALREADY_EXISTS);
  EXPECT_TRUE(api_.remove(kScene).ok());
  const grpc::Status gone = api_.remove(kScene);
  EXPECT_EQ(gone.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(reason_of(gone), "SCENE_NOT_FOUND");
  EXPECT_NE(gone.error_message().find(kScene), std::string::npos);
}

TEST_F(SceneRpcTest, RefusesBadScenes) {
  for (const double unit :
       {-1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    v1::Scene scene;
    scene.set_name(kScene);
    scene.set_meters_per_unit(unit);
    EXPECT_EQ(create(scene).error_code(), grpc::StatusCode::INVALID_ARGUMENT) << unit;
  }
  const grpc::Status status = api_.create("projects/p/scenes/Hall");
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_NE(status.error_message().find("\"Hall\""), std::string::npos);
}

TEST_F(SceneRpcTest, ListsInPagesByName) {
  for (const char* id : {"d", "b", "a", "c"})
    ASSERT_TRUE(api_.create("projects/p/scenes/" + std::string(id)).ok());
  ASSERT_TRUE(api_.create("projects/q/scenes/x").ok());
  v1::ListScenesResponse first, second;
  ASSERT_TRUE(list("projects/p", 3, "", &first).ok());
  ASSERT_EQ(first.scenes_size(), 3);
  EXPECT_EQ(first.scenes(0).name(), "projects/p/scenes/a");
  ASSERT_TRUE(list("projects/p", 3, first.next_page_token(), &second).ok());
  ASSERT_EQ(second.scenes_size(), 1);
  EXPECT_EQ(second.scenes(0).name(), "projects/p/scenes/d");
  EXPECT_EQ(second.next_page_token(), "");
  v1::ListScenesResponse all;
  ASSERT_TRUE(list("projects/p", 0, "", &all).ok());
  EXPECT_EQ(all.scenes_size(), 4);

  EXPECT_EQ(list("projects/q", 3, first.next_page_token(), &all).error_code(),
            grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(list("projects/p", -1, "", &all).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(list("p", 0, "", &all).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
}

TEST_F(SceneRpcTest, ListsTheScenesOfAllProjects) {
  for (const char* name : {"b/scenes/x", "a/scenes/y", "a/scenes/x", "a.b/scenes/x"})
    ASSERT_TRUE(api_.create("projects/" + std::string(name)).ok());
  std::vector<std::string> names;
  v1::ListScenesResponse page;
  do {
    const std::string token = page.next_page_token();
    ASSERT_TRUE(list("projects/-", 1, token, &page).ok());
    ASSERT_EQ(page.scenes_size(), 1);
    names.push_back(page.scenes(0).name());
  } while (!page.next_page_token().empty());
  EXPECT_EQ(names, (std::vector<std::string>{"projects/a.b/scenes/x", "projects/a/scenes/x",
                                             "projects/a/scenes/y", "projects/b/scenes/x"}));
  for (const char* wrong : {"projects/-/", "projects/--", "projects/", "-", "projects/*"})
    EXPECT_EQ(list(wrong, 0, "", &page).error_code(), grpc::StatusCode::INVALID_ARGUMENT) << wrong;
  EXPECT_EQ(list("projects/-", 0, "projects/-", &page).error_code(),
            grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(api_.create("projects/-/scenes/x").error_code(), grpc::StatusCode::INVALID_ARGUMENT);
}

TEST_F(SceneRpcTest, AppliesABatchAsOneRevision) {
  ASSERT_TRUE(api_.create(kScene).ok());
  const std::string digest = api_.add_mesh(cube());
  v1::Update named = put_node(-2, digest, -1, {{1, 0, 0, 5, 0, 1, 0, 6, 0, 0, 1, 7}});
  named.mutable_put_node()->set_name("crate");
  named.mutable_put_node()->set_mobility(v1::MOBILITY_RIGID);
  named.mutable_put_node()->set_mask(6);
  v1::ApplyUpdatesResponse applied;
  const grpc::Status status = api_.apply(kScene, {put_node(-1), named}, &applied);
  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(applied.revision().revision(), 1u);
  ASSERT_EQ(applied.nodes_size(), 2);

  const v1::Scene scene = api_.get(kScene);
  EXPECT_EQ(scene.head().revision(), 1u);
  EXPECT_EQ(scene.nodes(), 2u);
  EXPECT_EQ(scene.instances(), 1u);
  EXPECT_EQ(scene.triangles_unique(), 12u);
  EXPECT_EQ(std::vector<double>(scene.bounds().begin(), scene.bounds().end()),
            (std::vector<double>{4, 5, 6, 6, 7, 8}));

  const auto found = nodes({applied.nodes(1), 999, applied.nodes(0)});
  ASSERT_EQ(found.size(), 3u);
  EXPECT_EQ(found[0].id(), applied.nodes(1));
  EXPECT_EQ(found[0].parent(), applied.nodes(0));
  EXPECT_EQ(found[0].name(), "crate");
  EXPECT_EQ(found[0].mesh_digest(), digest);
  EXPECT_EQ(found[0].mobility(), v1::MOBILITY_RIGID);
  EXPECT_EQ(found[0].mask(), 6u);
  EXPECT_EQ(found[0].transform().matrix(3), 5);
  EXPECT_EQ(found[1].id(), 0u) << "does not exist";
  EXPECT_EQ(found[2].mask(), 0xffffffffu);
}

TEST_F(SceneRpcTest, SetsTransformsAndDeletes) {
  ASSERT_TRUE(api_.create(kScene).ok());
  v1::ApplyUpdatesResponse applied;
  ASSERT_TRUE(api_.apply(kScene, {put_node(-1), put_node(-2, "", -1)}, &applied).ok());
  const auto parent = static_cast<std::int64_t>(applied.nodes(0));
  v1::Update move;
  move.mutable_set_transforms()->add_nodes(parent);
  const scenegraph::model::Affine matrix{{2, 0, 0, 1, 0, 2, 0, 2, 0, 0, 2, 3}};
  move.mutable_set_transforms()->set_matrices(matrix.m.data(), sizeof(matrix.m));
  ASSERT_TRUE(api_.apply(kScene, {move}).ok());
  EXPECT_EQ(nodes({applied.nodes(0)})[0].transform().matrix(11), 3);

  v1::Update remove;
  remove.mutable_delete_node()->set_node(parent);
  expect_refused({remove}, grpc::StatusCode::FAILED_PRECONDITION, "NODE_HAS_CHILDREN");
  remove.mutable_delete_node()->set_subtree(true);
  ASSERT_TRUE(api_.apply(kScene, {remove}).ok());
  EXPECT_EQ(api_.get(kScene).nodes(), 0u);
}

TEST_F(SceneRpcTest, RefusesBadBatchesWhole) {
  ASSERT_TRUE(api_.create(kScene).ok());
  v1::ApplyUpdatesResponse applied;
  ASSERT_TRUE(api_.apply(kScene, {put_node(-1), put_node(-2, "", -1)}, &applied).ok());
  const auto parent = static_cast<std::int64_t>(applied.nodes(0));
  const auto child = static_cast<std::int64_t>(applied.nodes(1));
  const auto good = put_node(-1);

  expect_refused({good, put_node(-2, "", 999)}, grpc::StatusCode::NOT_FOUND, "PARENT_NOT_FOUND");
  expect_refused({good, put_node(parent, "", child)}, grpc::StatusCode::INVALID_ARGUMENT,
                 "NODE_CYCLE");
  const double nan = std::numeric_limits<double>::quiet_NaN();
  expect_refused({good, put_node(-2, "", 0, {{1, 0, 0, 0, 0, nan, 0, 0, 0, 0, 1, 0}})},
                 grpc::StatusCode::INVALID_ARGUMENT, "NOT_FINITE");
  expect_refused({good, v1::Update()}, grpc::StatusCode::INVALID_ARGUMENT, "EMPTY_UPDATE");

  v1::Update short_matrix = put_node(-2);
  short_matrix.mutable_put_node()->mutable_transform()->mutable_matrix()->RemoveLast();
  expect_refused({good, short_matrix}, grpc::StatusCode::INVALID_ARGUMENT, "MATRIX_LENGTH");
  v1::Update no_matrix = put_node(-2);
  no_matrix.mutable_put_node()->mutable_transform()->clear_matrix();
  expect_refused({good, no_matrix}, grpc::StatusCode::INVALID_ARGUMENT, "MATRIX_LENGTH");
  v1::Update mobility = put_node(-2);
  mobility.mutable_put_node()->set_mobility(static_cast<v1::Mobility>(17));
  expect_refused({good, mobility}, grpc::StatusCode::INVALID_ARGUMENT, "UNKNOWN_MOBILITY");
  v1::Update column;
  column.mutable_set_transforms()->add_nodes(parent);
  column.mutable_set_transforms()->set_matrices(std::string(95, '\0'));
  expect_refused({good, column}, grpc::StatusCode::INVALID_ARGUMENT, "COLUMN_LENGTH");
}

TEST_F(SceneRpcTest, NamesTheIndexOfABadUpdate) {
  ASSERT_TRUE(api_.create(kScene).ok());
  EXPECT_NE(api_.apply(kScene, {put_node(-1), v1::Update()}).error_message().find("update 1"),
            std::string::npos);
  EXPECT_NE(
      api_.apply(kScene, {put_node(-1), put_node(-2, "", 999)}).error_message().find("update 1"),
      std::string::npos);
}

TEST_F(SceneRpcTest, ListsMeshesThatWereNotUploaded) {
  ASSERT_TRUE(api_.create(kScene).ok());
  const std::string missing = digest_of(blob_of(cube())).text();
  expect_refused({put_node(-1, missing)}, grpc::StatusCode::FAILED_PRECONDITION, "MESHES_MISSING");
  EXPECT_NE(api_.apply(kScene, {put_node(-1, missing)}).error_message().find(missing),
            std::string::npos);
  expect_refused({put_node(-1, "sha256:zz/1")}, grpc::StatusCode::INVALID_ARGUMENT, "BAD_DIGEST");
  std::vector<v1::Update> many;
  for (int i = 1; i <= 1000; ++i) many.push_back(put_node(-i, digest_of(std::to_string(i)).text()));
  const grpc::Status status = api_.apply(kScene, many);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_NE(status.error_message().find("1000 meshes"), std::string::npos);
}

TEST_F(SceneRpcTest, ChecksTheExpectedRevision) {
  ASSERT_TRUE(api_.create(kScene).ok());
  const auto apply_at = [&](std::uint64_t revision) {
    grpc::ClientContext context;
    v1::ApplyUpdatesRequest request;
    v1::ApplyUpdatesResponse reply;
    request.set_scene(kScene);
    request.set_expected_revision(revision);
    *request.add_updates() = put_node(-1);
    return api_.scenes->ApplyUpdates(&context, request, &reply);
  };
  EXPECT_TRUE(apply_at(0).ok());
  EXPECT_EQ(apply_at(0).error_code(), grpc::StatusCode::ABORTED);
  EXPECT_TRUE(apply_at(1).ok());
}

TEST_F(SceneRpcTest, BoundsTheNodesOfAReply) {
  ASSERT_TRUE(api_.create(kScene).ok());
  grpc::ClientContext context;
  v1::BatchGetNodesRequest request;
  v1::BatchGetNodesResponse reply;
  request.set_scene(kScene);
  for (int i = 0; i <= server::updates::kMaxNodesPerRequest; ++i) request.add_ids(1);
  const grpc::Status status = api_.scenes->BatchGetNodes(&context, request, &reply);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_NE(status.error_message().find("513 ids, the limit is 512"), std::string::npos);
}

TEST_F(SceneRpcTest, EveryCallNamesAnUnknownScene) {
  EXPECT_EQ(api_.apply(kScene, {}).error_code(), grpc::StatusCode::NOT_FOUND);
  grpc::ClientContext get_context, stats_context;
  v1::GetSceneRequest get;
  v1::GetSceneResponse got;
  get.set_name(kScene);
  EXPECT_EQ(api_.scenes->GetScene(&get_context, get, &got).error_code(),
            grpc::StatusCode::NOT_FOUND);
  v1::GetSceneStatsRequest stats;
  v1::GetSceneStatsResponse stats_reply;
  stats.set_scene(kScene);
  EXPECT_EQ(api_.scenes->GetSceneStats(&stats_context, stats, &stats_reply).error_code(),
            grpc::StatusCode::NOT_FOUND);
}

}  // namespace
}  // namespace sightline::tests
