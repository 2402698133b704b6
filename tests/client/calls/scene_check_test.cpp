// Scenes that are refused before anything is sent.
#include "client/calls/scene_check.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>

namespace sightline::client::calls {
namespace {

ServerInfo limits() {
  ServerInfo info;
  info.max_depth = 3;
  info.max_triangles_per_mesh = 2;
  return info;
}

importer::ImportedScene chain(std::uint32_t depth) {
  importer::ImportedScene scene;
  for (std::uint32_t i = 0; i < depth; ++i) {
    importer::ImportedNode node;
    node.name = "node" + std::to_string(i);
    node.parent = i == 0 ? importer::kNone : i - 1;
    scene.nodes.push_back(node);
  }
  return scene;
}

TEST(SceneCheck, AcceptsScenesWithinTheLimits) {
  importer::ImportedScene scene = chain(3);
  scene.meshes.resize(1);
  scene.meshes[0].faces.resize(2);
  EXPECT_TRUE(check_scene(scene, limits()));
}

TEST(SceneCheck, NamesTheNodeThatIsTooDeep) {
  const Status status = check_scene(chain(4), limits());
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().message, "node 'node3' is at depth 4, the limit is 3");
}

TEST(SceneCheck, NamesTheNodeThatIsNotFinite) {
  const double inf = std::numeric_limits<double>::infinity();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double bad : {inf, -inf, nan, -nan}) {
    for (const std::size_t at : {0u, 3u, 11u}) {
      importer::ImportedScene scene = chain(2);
      scene.nodes[1].parent_from_local[at] = bad;
      const Status status = check_scene(scene, limits());
      ASSERT_FALSE(status) << bad;
      EXPECT_EQ(status.error().code, Code::kInvalidArgument);
      EXPECT_NE(status.error().message.find("'node1'"), std::string::npos);
      EXPECT_NE(status.error().message.find("not finite"), std::string::npos);
      EXPECT_EQ(status.error().message.find("-nan"), std::string::npos);
    }
  }
}

TEST(SceneCheck, AcceptsMirroredAndFlatNodes) {
  importer::ImportedScene mirrored = chain(1);
  mirrored.nodes[0].parent_from_local = {0, -3, 0, 1e6, 2, 0, 0, 0, 0, 0, -1e-3, 0};
  EXPECT_TRUE(check_scene(mirrored, limits()));
  for (const double flat : {0.0, -0.0, 1e-13, 1e-300}) {
    importer::ImportedScene scene = chain(2);
    scene.nodes[1].parent_from_local[10] = flat;
    EXPECT_TRUE(check_scene(scene, limits()));
    scene.nodes[1].parent_from_local = {};
    EXPECT_TRUE(check_scene(scene, limits()));
  }
}

TEST(SceneCheck, AMeshThatIsTooLargeIsAResourceError) {
  importer::ImportedScene scene = chain(1);
  scene.meshes.resize(1);
  scene.meshes[0].faces.resize(3);
  const Status status = check_scene(scene, limits());
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, Code::kResourceExhausted);
}

}  // namespace
}  // namespace sightline::client::calls
