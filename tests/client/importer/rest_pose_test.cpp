// Skins and shapes at rest, with places computed by hand.
#include "client/importer/rest_pose.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "client/importer/affine.h"

namespace sightline::client::importer {
namespace {

Transform scaled(double scale, double x, double y, double z) {
  return {scale, 0, 0, x, 0, scale, 0, y, 0, 0, scale, z};
}

FileNode node(const std::string& name, std::uint32_t parent, const Transform& local,
              std::vector<std::uint32_t> meshes = {}) {
  return {name, parent, local, std::move(meshes)};
}

/// Two vertices that follow one bone each.
FileMesh two_points(std::uint32_t first_bone, std::uint32_t second_bone) {
  FileMesh mesh;
  mesh.name = "points";
  mesh.vertices = {{100, 0, 0}, {0, 100, 0}};
  mesh.skin.bones = {{first_bone, kIdentity}, {second_bone, kIdentity}};
  mesh.skin.first = {0, 1, 2};
  mesh.skin.influences = {{0, 1}, {1, 1}};
  return mesh;
}

Transform world(const FileScene& scene, std::uint32_t i) {
  Transform out = kIdentity;
  for (; i != kNone; i = scene.nodes[i].parent) out = scene.nodes[i].parent_from_local * out;
  return out;
}

/// Vertices of the only mesh of a node, in the scene.
std::vector<Point> in_world(const FileScene& scene, std::uint32_t node) {
  std::vector<Point> out;
  const FileMesh& mesh = scene.meshes[scene.nodes[node].meshes.at(0)];
  for (const Point& p : mesh.vertices) out.push_back(world(scene, node) * p);
  return out;
}

void expect_near(const std::vector<Point>& actual, const std::vector<Point>& expected) {
  ASSERT_EQ(actual.size(), expected.size());
  for (std::size_t i = 0; i < actual.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(actual[i][k], expected[i][k], 1e-9) << i;
  }
}

/// A body at (50, 0, 0), 7 times as large, whose bones are 100 times as small.
FileScene scaled_down() {
  FileScene scene;
  scene.nodes = {node("root", kNone, scaled(1, 0, 0, 1)), node("body", 0, scaled(7, 50, 0, 0), {0}),
                 node("low", 0, scaled(0.01, 0, 0, 2)), node("high", 2, scaled(1, 0, 0, 300))};
  scene.meshes = {two_points(2, 3)};
  return scene;
}

TEST(RestPose, ASkinLiesWhereItsBonesAre) {
  FileScene scene = scaled_down();
  const auto before = apply_rest_pose(scene);
  expect_near(in_world(scene, 1), {{1, 0, 3}, {0, 1, 6}});
  EXPECT_EQ(before.at(0), (std::vector<Point>{{100, 0, 0}, {0, 100, 0}}));
}

TEST(RestPose, TheNodeOfASkinDoesNotMoveIt) {
  for (const Transform& local : {kIdentity, scaled(-3, 9, 9, 9), scaled(1e-6, 0, 0, 0)}) {
    FileScene scene = scaled_down();
    scene.nodes[1].parent_from_local = local;
    apply_rest_pose(scene);
    EXPECT_EQ(scene.nodes.size(), 4U);
    expect_near(in_world(scene, 1), {{1, 0, 3}, {0, 1, 6}});
  }
}

TEST(RestPose, BonesAndWeightsAreMixed) {
  FileScene scene = scaled_down();
  Skin& skin = scene.meshes[0].skin;
  skin.bones[1].bone_from_mesh = scaled(2, 0, 0, 0);
  skin.first = {0, 2, 2};
  skin.influences = {{0, 0.25}, {1, 0.75}};
  apply_rest_pose(scene);
  // A quarter of (1, 0, 3), three quarters of (2, 0, 6); the second vertex stays with its node.
  expect_near(in_world(scene, 1), {{1.75, 0, 5.25}, {50, 700, 1}});
}

TEST(RestPose, NodesThatShareASkinGetMeshesOfTheirOwn) {
  FileScene scene = scaled_down();
  scene.nodes.push_back(node("twin", kNone, scaled(2, -8, 0, 0), {0}));
  scene.animations.resize(1);
  scene.animations[0].deformations = {{4, 0, {}}, {1, kNone, {}}};
  const auto before = apply_rest_pose(scene);
  ASSERT_EQ(scene.meshes.size(), 2U);
  EXPECT_EQ(before.size(), 2U);
  EXPECT_EQ(scene.nodes[1].meshes.at(0), 0U);
  EXPECT_EQ(scene.nodes[4].meshes.at(0), 1U);
  EXPECT_EQ(scene.animations[0].deformations[0].mesh, 1U);
  expect_near(in_world(scene, 1), {{1, 0, 3}, {0, 1, 6}});
  expect_near(in_world(scene, 4), {{1, 0, 3}, {0, 1, 6}});
}

TEST(RestPose, ASkinOfAFlatNodeMovesToTheRoot) {
  for (const Transform& local :
       {scaled(0, 5, 5, 5), Transform{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0}}) {
    FileScene scene = scaled_down();
    scene.nodes[1].parent_from_local = local;
    FileMesh rigid;
    rigid.vertices = {{1, 2, 3}};
    scene.meshes.push_back(rigid);
    scene.nodes[1].meshes = {0, 1};
    scene.animations.resize(1);
    scene.animations[0].deformations = {{1, kNone, {}}};
    apply_rest_pose(scene);
    ASSERT_EQ(scene.nodes.size(), 5U);
    EXPECT_EQ(scene.nodes[4].name, "body");
    EXPECT_EQ(scene.nodes[4].parent, kNone);
    EXPECT_EQ(scene.nodes[1].meshes, std::vector<std::uint32_t>{1});
    expect_near(in_world(scene, 4), {{1, 0, 3}, {0, 1, 6}});
    ASSERT_EQ(scene.animations[0].deformations.size(), 2U);
    EXPECT_EQ(scene.animations[0].deformations[1].node, 4U);
  }
}

TEST(RestPose, ASkinOfANodeThatAnAnimationHidesMovesToTheRoot) {
  using Keys = std::vector<Key<Point>>;
  const std::vector<std::pair<Keys, bool>> cases{{{{0, {1, 1, 1}}, {1, {0, 0, 0}}}, true},
                                                 {{{0, {1, 1, 1}}, {1, {1, -1, 1}}}, true},
                                                 {{{0, {1, 1, 1}}, {1, {5, 6, 7}}}, false}};
  for (const std::uint32_t moved : {0U, 1U}) {
    for (const auto& [keys, is_moved] : cases) {
      FileScene scene = scaled_down();
      NodeChannel channel;
      channel.node = moved;
      channel.positions.keys = {{0, {0, 0, 0}}};
      channel.rotations.keys = {{0, {1, 0, 0, 0}}};
      channel.scalings.keys = keys;
      scene.animations.resize(1);
      scene.animations[0].channels = {channel};
      apply_rest_pose(scene);
      EXPECT_EQ(scene.nodes.size(), is_moved ? 5U : 4U);
      expect_near(in_world(scene, is_moved ? 4 : 1), {{1, 0, 3}, {0, 1, 6}});
    }
  }
}

TEST(RestPose, ShapesAreBlendedByTheirWeights) {
  FileScene scene;
  scene.nodes = {node("a", kNone, kIdentity, {0}), node("b", kNone, kIdentity, {0}),
                 node("c", kNone, kIdentity, {1})};
  FileMesh mesh;
  mesh.vertices = {{1, 0, 0}, {0, 1, 0}};
  mesh.shapes = {{{0, 0, 4}, {0, 0, 0}}, {{0, 8, 0}, {16, 0, 0}}};
  mesh.weights = {0.5, -0.25};
  scene.meshes = {mesh, mesh};
  scene.meshes[1].weights = {1};
  const auto before = apply_rest_pose(scene);
  EXPECT_EQ(scene.meshes.size(), 2U) << "shapes do not depend on the node";
  EXPECT_EQ(scene.meshes[0].vertices, (std::vector<Point>{{1, -2, 2}, {-4, 1, 0}}));
  EXPECT_EQ(scene.meshes[1].vertices, (std::vector<Point>{{1, 0, 4}, {0, 1, 0}}));
  EXPECT_EQ(before[1], mesh.vertices);
}

TEST(RestPose, ShapesComeBeforeTheSkin) {
  FileScene scene = scaled_down();
  scene.meshes[0].shapes = {{{200, 0, 0}, {0, 0, 0}}};
  scene.meshes[0].weights = {1};
  apply_rest_pose(scene);
  expect_near(in_world(scene, 1), {{3, 0, 3}, {0, 1, 6}});
}

TEST(RestPose, RigidMeshesStay) {
  FileScene scene;
  scene.nodes = {node("a", kNone, scaled(3, 1, 1, 1), {0}), node("b", kNone, kIdentity, {0})};
  FileMesh mesh;
  mesh.vertices = {{1, 2, 3}};
  scene.meshes = {mesh};
  EXPECT_TRUE(apply_rest_pose(scene).at(0).empty());
  EXPECT_EQ(scene.meshes.size(), 1U);
  EXPECT_EQ(scene.meshes[0].vertices, mesh.vertices);
}

}  // namespace
}  // namespace sightline::client::importer
