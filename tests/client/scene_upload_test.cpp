// Imported scenes on the server.
#include "client/scene_upload.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "tests/client/support/live_client.h"
#include "tests/client/support/relay.h"
#include "tests/client/support/temp_dir.h"

namespace sightline::client {
namespace {

using SceneUpload = tests::LiveClient;
using tests::kScene;

TEST_F(SceneUpload, ReportsTheScenesCounts) {
  importer::ImportedScene scene = tests::row_of_sheets(5);
  scene.up_axis = UpAxis::kZ;
  scene.meters_per_unit = 0.5;
  const auto info = upload_scene(client_, kScene, scene, {});
  ASSERT_TRUE(info) << info.error().message;
  EXPECT_EQ(info->revision, 1U);
  EXPECT_EQ(info->nodes, 6U);
  EXPECT_EQ(info->instances, 5U);
  EXPECT_EQ(info->meshes, 1U);
  EXPECT_EQ(info->triangles_unique, 4U);
  EXPECT_EQ(info->triangles_instanced, 20U);
  EXPECT_EQ(info->up_axis, UpAxis::kZ);
  EXPECT_EQ(info->meters_per_unit, 0.5);
  ASSERT_TRUE(info->bounds);
  EXPECT_NEAR((*info->bounds)[3], 41, 1e-3);
}

TEST_F(SceneUpload, EqualMeshesStayDistinctAndUnusedOnesAreNotSent) {
  importer::ImportedScene scene = tests::row_of_sheets(2);
  scene.meshes.push_back(scene.meshes[0]);
  scene.meshes.push_back(tests::sheets(9));
  scene.nodes[2].mesh = 1;
  std::uint64_t total = 0;
  const auto info = upload_scene(client_, kScene, scene, {},
                                 [&](std::uint64_t, std::uint64_t all) { total = all; });
  ASSERT_TRUE(info) << info.error().message;
  EXPECT_EQ(info->meshes, 2U);
  EXPECT_EQ(info->triangles_unique, 8U);
  EXPECT_EQ(total, 2 * MeshBlob(scene.meshes[0].vertices, scene.meshes[0].faces).size());
}

TEST_F(SceneUpload, ManyMeshesAreSentSeveralAtATime) {
  importer::ImportedScene scene = tests::row_of_sheets(100);
  for (std::uint32_t i = 1; i < 100; ++i) {
    scene.meshes.push_back(tests::sheets(i % 7 + 1));
    scene.nodes[i + 1].mesh = i;
  }
  std::uint64_t last = 0, total = 0;
  const auto info =
      upload_scene(client_, kScene, scene, {}, [&](std::uint64_t done, std::uint64_t all) {
        EXPECT_GE(done, last);
        last = done;
        total = all;
      });
  ASSERT_TRUE(info) << info.error().message;
  EXPECT_EQ(info->meshes, 100U);
  EXPECT_GT(total, 0U);
  EXPECT_EQ(last, total);
}

TEST_F(SceneUpload, AStopEndsAllUploads) {
  importer::ImportedScene scene = tests::row_of_sheets(50);
  for (std::uint32_t i = 1; i < 50; ++i) {
    scene.meshes.push_back(tests::sheets(i));
    scene.nodes[i + 1].mesh = i;
  }
  std::stop_source stop;
  const auto stopped = upload_scene(client_, kScene, scene, {.stop = stop.get_token()},
                                    [&](std::uint64_t, std::uint64_t) { stop.request_stop(); });
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, Code::kCancelled);
  EXPECT_EQ(client_.get_scene(kScene).error().code, Code::kNotFound);
}

TEST_F(SceneUpload, MeshesThatTheServerHasAreNotSentAgain) {
  ASSERT_TRUE(upload_scene(client_, kScene, tests::row_of_sheets(2), {}));
  bool sent = false;
  const auto again = upload_scene(client_, "projects/default/scenes/other", tests::row_of_sheets(2),
                                  {}, [&](std::uint64_t, std::uint64_t) { sent = true; });
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_FALSE(sent);
}

TEST_F(SceneUpload, AnExistingSceneIsAConflictUnlessReplaced) {
  ASSERT_TRUE(upload_scene(client_, kScene, tests::row_of_sheets(2), {}));
  importer::ImportedScene other = tests::row_of_sheets(3);
  other.meshes[0] = tests::sheets(7);
  bool sent = false;
  const auto refused =
      upload_scene(client_, kScene, other, {}, [&](std::uint64_t, std::uint64_t) { sent = true; });
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Code::kAlreadyExists);
  EXPECT_FALSE(sent);
  EXPECT_EQ(client_.get_scene(kScene)->instances, 2U);
  const auto replaced = upload_scene(client_, kScene, other, {.replace = true});
  ASSERT_TRUE(replaced) << replaced.error().message;
  EXPECT_EQ(replaced->instances, 3U);
  EXPECT_EQ(replaced->revision, 1U);
}

TEST_F(SceneUpload, AnInvalidSceneIsRefusedAndTheOldOneKept) {
  ASSERT_TRUE(upload_scene(client_, kScene, tests::row_of_sheets(2), {}));
  importer::ImportedScene endless = tests::row_of_sheets(1);
  endless.nodes[1].parent_from_local[0] = HUGE_VAL;
  EXPECT_FALSE(upload_scene(client_, kScene, endless, {.replace = true}));
  EXPECT_EQ(client_.get_scene(kScene)->instances, 2U);
}

TEST_F(SceneUpload, APartlyUploadedSceneIsDeleted) {
  importer::ImportedScene scene = tests::row_of_sheets(3);
  scene.nodes[3].name = std::string(2000, 'x');  // Longer than servers accept
  const auto refused = upload_scene(client_, kScene, scene, {});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Code::kInvalidArgument);
  EXPECT_EQ(client_.get_scene(kScene).error().code, Code::kNotFound);
}

TEST_F(SceneUpload, ASceneOfManyMessagesIsOneRevision) {
  importer::ImportedScene scene = tests::row_of_sheets(20'000);
  for (std::size_t i = 0; i < scene.nodes.size(); ++i)
    scene.nodes[i].name = fmt::format("{}{:0>80}", scene.nodes[i].name, i);
  const auto info = upload_scene(client_, kScene, scene, {});
  ASSERT_TRUE(info) << info.error().message;
  EXPECT_EQ(info->revision, 1U);
  EXPECT_EQ(info->nodes, 20'001U);
  const std::vector<std::uint64_t> last{20'001};
  const auto nodes = client_.get_nodes(kScene, last);
  ASSERT_TRUE(nodes);
  EXPECT_EQ((*nodes)[0].parent, 1U);
  EXPECT_EQ((*nodes)[0].name, scene.nodes.back().name);
}

TEST_F(SceneUpload, AConnectionThatBreaksLeavesTheOldSceneOrNone) {
  ASSERT_TRUE(upload_scene(client_, kScene, tests::row_of_sheets(2), {}));
  tests::Relay relay(server_->port());
  const auto cut_client = Client::connect(relay.endpoint());
  ASSERT_TRUE(cut_client);
  importer::ImportedScene scene = tests::row_of_sheets(20'000);
  // The mesh is known to the server: what breaks is the call that puts the nodes.
  relay.cut_each_after(200'000, 0);
  const auto replaced = upload_scene(*cut_client, kScene, scene, {.replace = true});
  ASSERT_FALSE(replaced);
  EXPECT_EQ(client_.get_scene(kScene)->instances, 2U);
  const char* fresh = "projects/default/scenes/new";
  EXPECT_FALSE(upload_scene(*cut_client, fresh, scene, {}));
  EXPECT_EQ(client_.get_scene(fresh).error().code, Code::kNotFound);
}

TEST(DurableSceneUpload, AReplacedSceneSurvivesARestart) {
  const tests::TempDir dir;
  const auto upload = [&](std::uint32_t copies, bool replace) {
    const auto server = tests::start_server(dir.path("data"));
    const auto client = Client::connect("127.0.0.1:" + std::to_string(server->port()));
    const auto before = client->get_scene(kScene);
    const auto made =
        upload_scene(*client, kScene, tests::row_of_sheets(copies), {.replace = replace});
    const auto listed = client->list_scenes("projects/default");
    EXPECT_TRUE(!made || listed->at(0).nodes == made->nodes) << "a list shows what it holds";
    return std::pair(before ? before->instances : 0, made ? made->instances : 0);
  };
  EXPECT_EQ(upload(2, false), std::pair(0UL, 2UL));
  EXPECT_EQ(upload(3, true), std::pair(2UL, 3UL));
  EXPECT_EQ(upload(5, false), std::pair(3UL, 0UL)) << "it exists";
  EXPECT_EQ(upload(7, true), std::pair(3UL, 7UL));
}

TEST_F(SceneUpload, AStopDoesNotChangeTheScene) {
  ASSERT_TRUE(upload_scene(client_, kScene, tests::row_of_sheets(2), {}));
  importer::ImportedScene other = tests::row_of_sheets(3);
  other.meshes[0] = tests::sheets(9);
  for (const char* name : {kScene, "projects/default/scenes/new"}) {
    std::stop_source stop;
    const auto stopped =
        upload_scene(client_, name, other, {.replace = true, .stop = stop.get_token()},
                     [&](std::uint64_t, std::uint64_t) { stop.request_stop(); });
    ASSERT_FALSE(stopped) << "the mesh is being sent, or has just arrived";
    EXPECT_EQ(stopped.error().code, Code::kCancelled);
    other.meshes[0] = tests::sheets(11);  // As the server may already have the first mesh
  }
  EXPECT_EQ(client_.get_scene(kScene)->instances, 2U);
  EXPECT_EQ(client_.get_scene("projects/default/scenes/new").error().code, Code::kNotFound);
}

TEST_F(SceneUpload, NodesMayBeAddedToAnExistingScene) {
  ASSERT_TRUE(upload_scene(client_, kScene, tests::row_of_sheets(2), {}));
  importer::ImportedScene more = tests::row_of_sheets(1);
  more.meshes[0] = tests::sheets(9);
  SceneUploadOptions options;
  options.by_node = {Mobility::kRigid, Mobility::kDeforming};
  const auto ids = add_to_scene(client_, kScene, more, 1, options);
  ASSERT_TRUE(ids) << ids.error().message;
  EXPECT_EQ(*ids, (std::vector<std::uint64_t>{4, 5}));
  const auto nodes = client_.get_nodes(kScene, *ids);
  ASSERT_TRUE(nodes);
  EXPECT_EQ((*nodes)[0].parent, 1U);
  EXPECT_EQ((*nodes)[0].mobility, Mobility::kRigid);
  EXPECT_EQ((*nodes)[1].parent, 4U);
  EXPECT_EQ((*nodes)[1].mobility, Mobility::kDeforming);
  EXPECT_EQ((*nodes)[1].mesh_digest, mesh_digests(more)[0]);
  EXPECT_EQ(client_.get_scene(kScene)->instances, 3U);
  EXPECT_EQ(add_to_scene(client_, "projects/default/scenes/none", more, 0, options).error().code,
            Code::kNotFound);
  EXPECT_EQ(add_to_scene(client_, kScene, more, 77, options).error().code, Code::kNotFound);
}

TEST_F(SceneUpload, AnEmptySceneIsValid) {
  const auto info = upload_scene(client_, kScene, {}, {});
  ASSERT_TRUE(info) << info.error().message;
  EXPECT_EQ(info->nodes, 0U);
  EXPECT_FALSE(info->bounds);
}

}  // namespace
}  // namespace sightline::client
