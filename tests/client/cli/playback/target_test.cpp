// Finding the nodes of a file in a scene.
#include "client/cli/playback/target.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "client/cli/nodes.h"
#include "client/cli/playback/motion.h"
#include "client/scene_upload.h"
#include "tests/client/support/live_client.h"

namespace sightline::client::cli::playback {
namespace {

using tests::kScene;

// A root "car" with two nodes "wheel" that have a mesh.
Motion car() {
  Motion motion;
  motion.scene.meshes.push_back(tests::sheets(1));
  motion.scene.nodes = {{.name = "car"},
                        {.name = "wheel", .parent = 0, .mesh = 0},
                        {.name = "wheel", .parent = 0, .mesh = 0}};
  motion.placed = {1, 2};
  return motion;
}

NodeInfo node(std::uint64_t id, std::uint64_t parent, std::string name, std::string digest = {}) {
  NodeInfo info;
  info.id = id;
  info.parent = parent;
  info.name = std::move(name);
  info.mesh_digest = std::move(digest);
  return info;
}

using Ids = std::vector<std::uint64_t>;

TEST(MatchNodes, MatchesByNameAndEqualNamesByOrder) {
  const std::vector<NodeInfo> scene{node(1, 0, "hall"), node(4, 0, "car"), node(5, 4, "wheel", "m"),
                                    node(6, 4, "flag"), node(9, 4, "wheel", "m")};
  const auto ids = match_nodes(car(), scene, 0);
  ASSERT_TRUE(ids) << ids.error().message;
  EXPECT_EQ(*ids, (Ids{4, 5, 9}));
}

TEST(MatchNodes, SearchesUnderTheGivenNode) {
  const std::vector<NodeInfo> scene{
      node(1, 0, "car"), node(2, 1, "wheel", "m"), node(3, 1, "wheel", "m"), node(4, 0, "road"),
      node(5, 4, "car"), node(6, 5, "wheel", "m"), node(7, 5, "wheel", "m")};
  EXPECT_EQ(*match_nodes(car(), scene, 0), (Ids{1, 2, 3}));
  EXPECT_EQ(*match_nodes(car(), scene, 4), (Ids{5, 6, 7}));
}

TEST(MatchNodes, NamesTheMissingNode) {
  const auto ids = match_nodes(car(), {node(4, 0, "car"), node(5, 4, "wheel", "m")}, 0);
  ASSERT_FALSE(ids);
  EXPECT_EQ(ids.error().code, Code::kFailedPrecondition);
  EXPECT_NE(ids.error().message.find("no node 'car/wheel' with a mesh"), std::string::npos);
  EXPECT_FALSE(match_nodes(car(), {}, 0));
}

TEST(MatchNodes, StaticNodesMayBeMissing) {
  Motion motion = car();
  motion.placed = {1};
  const auto ids = match_nodes(motion, {node(4, 0, "car"), node(5, 4, "wheel", "m")}, 0);
  ASSERT_TRUE(ids);
  EXPECT_EQ(*ids, (Ids{4, 5, 0}));
}

TEST(MatchNodes, DeformingMeshesMustEqualTheFiles) {
  Motion motion = car();
  motion.shaped = {1};
  const std::string digest = mesh_digests(motion.scene)[0];
  const std::vector<NodeInfo> same{node(4, 0, "car"), node(5, 4, "wheel", digest),
                                   node(6, 4, "wheel", "m")};
  EXPECT_TRUE(match_nodes(motion, same, 0));
  const std::vector<NodeInfo> other{node(4, 0, "car"), node(5, 4, "wheel", "m"),
                                    node(6, 4, "wheel", "m")};
  const auto ids = match_nodes(motion, other, 0);
  ASSERT_FALSE(ids);
  EXPECT_NE(ids.error().message.find("node 5 'car/wheel'"), std::string::npos);
}

using ListNodes = tests::LiveClient;

TEST_F(ListNodes, FindsAllRemainingNodes) {
  ASSERT_TRUE(upload_scene(client_, kScene, tests::row_of_sheets(5), {}));
  ASSERT_TRUE(client_.apply(kScene, std::vector<Update>{DeleteNode{3, false}}));
  const auto nodes = list_nodes(client_, kScene);
  ASSERT_TRUE(nodes) << nodes.error().message;
  Ids ids;
  for (const NodeInfo& each : *nodes) ids.push_back(each.id);
  EXPECT_EQ(ids, (Ids{1, 2, 4, 5, 6}));
  EXPECT_EQ(list_nodes(client_, "projects/default/scenes/none").error().code, Code::kNotFound);
}

}  // namespace
}  // namespace sightline::client::cli::playback
