// Scenes over a real connection.
#include "client/client.h"

#include <gtest/gtest.h>

#include <string>

#include "client/scene_upload.h"
#include "tests/client/support/live_client.h"
#include "tests/client/support/silent_port.h"

namespace sightline::client {
namespace {

using tests::kScene;
using tests::LiveClient;

TEST_F(LiveClient, ReportsTheServersInfo) {
  const auto info = client_.server_info();
  ASSERT_TRUE(info) << info.error().message;
  EXPECT_FALSE(info->version.empty());
  EXPECT_GE(info->max_rays_per_request, kRaysPerMessage);
  EXPECT_GT(info->max_triangles_per_mesh, 0U);
}

TEST_F(LiveClient, CreatesAndDeletesScenes) {
  const auto created = client_.create_scene(kScene, UpAxis::kZ, 0.01);
  ASSERT_TRUE(created) << created.error().message;
  EXPECT_EQ(created->name, kScene);
  EXPECT_EQ(created->revision, 0U);
  const auto got = client_.get_scene(kScene);
  ASSERT_TRUE(got) << got.error().message;
  EXPECT_EQ(got->up_axis, UpAxis::kZ);
  EXPECT_EQ(got->meters_per_unit, 0.01);
  EXPECT_FALSE(got->bounds);
  EXPECT_EQ(client_.create_scene(kScene).error().code, Code::kAlreadyExists);
  EXPECT_TRUE(client_.delete_scene(kScene));
  EXPECT_EQ(client_.delete_scene(kScene).error().code, Code::kNotFound);
  EXPECT_EQ(client_.get_scene(kScene).error().code, Code::kNotFound);
}

// gRPC waits before it connects again; a call that it does not repeat would fail meanwhile.
TEST_F(LiveClient, AWriteWaitsForTheConnection) {
  server::ServerConfig config;
  config.listen = endpoint();
  stop_server();
  EXPECT_EQ(client_.server_info().error().code, Code::kUnavailable);
  server_ = *server::Server::start(config);
  const auto created = client_.create_scene(kScene);
  EXPECT_TRUE(created) << created.error().message;
}

TEST_F(LiveClient, ErrorsHaveTheServersReason) {
  const auto missing = client_.get_scene(kScene);
  ASSERT_FALSE(missing);
  EXPECT_FALSE(missing.error().reason.empty());
  EXPECT_NE(missing.error().message.find(kScene), std::string::npos);
}

TEST_F(LiveClient, ListsMoreScenesThanOnePage) {
  for (int i = 0; i < 1001; ++i) {
    ASSERT_TRUE(client_.create_scene("projects/many/scenes/s" + std::to_string(10000 + i)));
  }
  const auto scenes = client_.list_scenes("projects/many");
  ASSERT_TRUE(scenes) << scenes.error().message;
  ASSERT_EQ(scenes->size(), 1001U);
  EXPECT_EQ(scenes->front().name, "projects/many/scenes/s10000");
  EXPECT_EQ(scenes->back().name, "projects/many/scenes/s11000");
  EXPECT_TRUE(client_.list_scenes("projects/none")->empty());
}

TEST_F(LiveClient, ReturnsNodesUnchanged) {
  importer::ImportedScene scene = tests::row_of_sheets(1500);
  const auto uploaded = upload_scene(client_, kScene, scene, {.mobility = Mobility::kRigid});
  ASSERT_TRUE(uploaded) << uploaded.error().message;
  std::vector<std::uint64_t> ids;
  for (std::uint64_t id = 1; id <= 1502; ++id) ids.push_back(id);
  const auto nodes = client_.get_nodes(kScene, ids);
  ASSERT_TRUE(nodes) << nodes.error().message;
  ASSERT_EQ(nodes->size(), ids.size());
  EXPECT_EQ((*nodes)[0].name, "room");
  EXPECT_EQ((*nodes)[1500].parent, 1U);
  EXPECT_EQ((*nodes)[1500].parent_from_local[3], 14990);
  EXPECT_EQ((*nodes)[1500].mobility, Mobility::kRigid);
  EXPECT_EQ((*nodes)[1500].mask, 0xffffffffU);
  EXPECT_EQ((*nodes)[1501].id, 0U);
}

TEST_F(LiveClient, StatsOfANewSceneHaveNothingEntered) {
  ASSERT_TRUE(upload_scene(client_, kScene, tests::row_of_sheets(3), {}));
  const auto stats = client_.scene_stats(kScene);
  ASSERT_TRUE(stats) << stats.error().message;
  EXPECT_EQ(stats->instances_total, 3U);
  EXPECT_EQ(stats->instances_entered, 0U);
  EXPECT_EQ(stats->triangles_total, 4U);
}

TEST(ClientConnect, AcceptsOnlyEndpoints) {
  EXPECT_TRUE(Client::connect("127.0.0.1:50151"));
  EXPECT_TRUE(Client::connect("[::1]:1"));
  EXPECT_TRUE(Client::connect("unix:/tmp/socket"));
  for (const char* text : {"", "localhost", ":1", "host:", "host:x", "host:1234567", "unix:"}) {
    EXPECT_FALSE(Client::connect(text)) << text;
  }
}

TEST_F(LiveClient, AStoppedServerIsUnavailable) {
  stop_server();
  const auto scenes = client_.list_scenes("projects/default");
  ASSERT_FALSE(scenes);
  EXPECT_EQ(scenes.error().code, Code::kUnavailable);
}

TEST(ClientTimeout, IsADeadline) {
  const tests::SilentPort port;
  const auto client = Client::connect(port.endpoint(), {.timeout = std::chrono::milliseconds(100)});
  ASSERT_TRUE(client);
  const auto info = client->server_info();
  ASSERT_FALSE(info);
  EXPECT_EQ(info.error().code, Code::kDeadlineExceeded);
}

}  // namespace
}  // namespace sightline::client
