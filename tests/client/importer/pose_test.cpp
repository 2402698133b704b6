// Poses with known answers, of files made for the tests and of real ones.
#include "client/importer/pose.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <numbers>
#include <string>

#include "client/importer/affine.h"
#include "client/importer/assimp_import.h"
#include "tests/client/importer/gltf_file.h"
#include "tests/client/support/temp_dir.h"

namespace sightline::client::importer {
namespace {

using tests::GltfFile;
using tests::TempDir;

constexpr double kNear = 1e-6;

AnimatedScene import(const GltfFile& file, const ImportOptions& options = {}) {
  const TempDir dir;
  auto scene = import_animated_scene(dir.write("file.gltf", file.text()), options);
  EXPECT_TRUE(scene) << scene.error().message;
  return scene ? *std::move(scene) : AnimatedScene{};
}

Transform turn_about_z(double degrees) {
  const double angle = degrees * std::numbers::pi / 180;
  return {
      std::cos(angle), -std::sin(angle), 0, 0, std::sin(angle), std::cos(angle), 0, 0, 0, 0, 1, 0};
}

void expect_near(const Transform& actual, const Transform& expected) {
  for (std::size_t k = 0; k < 12; ++k) EXPECT_NEAR(actual[k], expected[k], kNear) << k;
}

Point point(const Vertex& v) {
  return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
}

void expect_near(const Vertex& actual, const Point& expected) {
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(static_cast<double>(actual[k]), expected[k], kNear) << k;
  }
}

// By the scene's nodes.
Transform in_world(const ImportedScene& scene, const Pose& pose, std::uint32_t node) {
  Transform out = kIdentity;
  for (; node != kNone; node = scene.nodes[node].parent) {
    Transform local = scene.nodes[node].parent_from_local;
    for (const Pose::Placed& placed : pose.placed) {
      if (placed.node == node) local = placed.parent_from_local;
    }
    out = local * out;
  }
  return out;
}

Point in_world(const ImportedScene& scene, const Pose& pose, const Pose::Shaped& shaped,
               std::size_t vertex) {
  const Vertex& v = shaped.vertices[vertex];
  return in_world(scene, pose, shaped.nodes[0]) * point(v);
}

TEST(Pose, ANodeMovesLinearlyAndHoldsItsLastKey) {
  GltfFile file = tests::triangle_under_root();
  file.animate(1, "translation", {1, 2}, {0, 0, 0, 4, 0, 8});
  const AnimatedScene scene = import(file);
  ASSERT_EQ(scene.animations.size(), 1U);
  const Animation& animation = scene.animations[0];
  EXPECT_NEAR(animation.seconds, 2, kNear);
  const auto x_at = [&](double seconds) {
    const Pose at = pose(scene, animation, seconds);
    EXPECT_EQ(at.placed.size(), 1U);
    EXPECT_EQ(scene.scene.nodes[at.placed[0].node].name, "blade");
    return at.placed[0].parent_from_local[3];
  };
  EXPECT_NEAR(x_at(0), 0, kNear);
  EXPECT_NEAR(x_at(1.25), 1, kNear);
  EXPECT_NEAR(x_at(2), 4, kNear);
  EXPECT_NEAR(x_at(50), 4, kNear);
}

TEST(Pose, RotationsHaveConstantSpeedAndScalesMultiply) {
  GltfFile file = tests::triangle_under_root();
  const float half = std::sqrt(0.5F);
  file.animate(1, "rotation", {0, 1}, {0, 0, 0, 1, 0, 0, half, half});
  file.animate(1, "scale", {0, 1}, {1, 1, 1, 3, 1, 1});
  const AnimatedScene scene = import(file);
  const Pose third = pose(scene, scene.animations[0], 1.0 / 3);
  ASSERT_EQ(third.placed.size(), 1U);
  Transform expected = turn_about_z(30);
  for (const std::size_t k : {0U, 4U}) expected[k] *= 5.0 / 3;
  expect_near(third.placed[0].parent_from_local, expected);
}

TEST(Pose, ScalesOfZeroAreThoseOfTheFile) {
  GltfFile file = tests::triangle_under_root();
  file.animate(1, "scale", {0, 1}, {1, 1, 1, 0, 0, 0});
  const AnimatedScene scene = import(file);
  const Pose gone = pose(scene, scene.animations[0], 1);
  EXPECT_EQ(gone.placed.at(0).parent_from_local, Transform{});
}

TEST(Pose, RootsAreConvertedLikeTheScene) {
  GltfFile file = tests::triangle_under_root();
  file.animate(0, "translation", {0, 1}, {0, 0, 0, 0, 6, 0});
  const AnimatedScene scene = import(file, {UpAxis::kZ, 0.5});
  const Pose risen = pose(scene, scene.animations[0], 0.5);
  ASSERT_EQ(risen.placed.size(), 1U);
  expect_near(risen.placed[0].parent_from_local, {2, 0, 0, 0, 0, 0, -2, 0, 0, 2, 0, 6});
  const Pose rest = pose(scene, scene.animations[0], 0);
  EXPECT_EQ(rest.placed[0].parent_from_local, scene.scene.nodes[0].parent_from_local);
}

TEST(Pose, ASkinnedStripBends) {
  const AnimatedScene scene = import(tests::bending_strip());
  ASSERT_EQ(scene.animations.size(), 1U);
  const Pose rest_pose = pose(scene, scene.animations[0], 0);
  ASSERT_EQ(rest_pose.shaped.size(), 1U);
  // The strip is where its joints are, not where its node is, before an animation is played, too.
  EXPECT_EQ(rest_pose.shaped[0].vertices, scene.scene.meshes[0].vertices);
  expect_near(rest_pose.shaped[0].vertices[0], {-10.5, 0, 0});
  expect_near(rest_pose.shaped[0].vertices[5], {-9.5, 2, 0});
  const Pose bent = pose(scene, scene.animations[0], 1);
  const std::array<Point, 6> expected{
      {{-0.5, 0, 0}, {0.5, 0, 0}, {-0.25, 0.75, 0}, {0.25, 1.25, 0}, {-1, 0.5, 0}, {-1, 1.5, 0}}};
  for (std::size_t v = 0; v < 6; ++v) {
    const Point at = in_world(scene.scene, bent, bent.shaped[0], v);
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(at[k], expected[v][k], kNear) << v;
  }
  const Pose halfway = pose(scene, scene.animations[0], 0.5);
  const Point top = in_world(scene.scene, halfway, halfway.shaped[0], 5);
  const Point turned = turn_about_z(45) * Point{0.5, 1, 0};
  EXPECT_NEAR(top[0], turned[0], kNear);
  EXPECT_NEAR(top[1], turned[1] + 1, kNear);
}

TEST(Pose, ASkinFollowsItsBonesForAnyMotionOfItsNode) {
  GltfFile file = tests::bending_strip();
  file.animate(1, "translation", {0, 1}, {10, 0, 0, 77, 5, 3});
  const AnimatedScene scene = import(file);
  const Pose bent = pose(scene, scene.animations[0], 1);
  const Point top = in_world(scene.scene, bent, bent.shaped.at(0), 5);
  EXPECT_NEAR(top[0], -1, 1e-5);
  EXPECT_NEAR(top[1], 1.5, 1e-5);
}

TEST(Pose, RebasedMeshesKeepTheirWorldPositions) {
  GltfFile near = tests::bending_strip();
  near.animate(2, "translation", {0, 1}, {0, 0, 0, 0, 0, 3});
  GltfFile far = near;
  // The strip is the same, with joints that are 1,048,576 further along x.
  far.json["nodes"][2]["translation"] = {1048576, 0, 0};
  far.json["animations"][0]["samplers"][1]["output"] =
      far.add({1048576.0F, 0, 0, 1048576.0F, 0, 3}, "VEC3");
  const AnimatedScene a = import(near);
  const AnimatedScene b = import(far);
  ASSERT_GT(b.rig.offsets.at(0)[0], 1048000.0);
  const Pose here = pose(a, a.animations[0], 0.7);
  const Pose there = pose(b, b.animations[0], 0.7);
  for (std::size_t v = 0; v < 6; ++v) {
    const Point p = in_world(a.scene, here, here.shaped[0], v);
    const Point q = in_world(b.scene, there, there.shaped[0], v);
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_NEAR(p[k] + (k == 0 ? 1048576.0 : 0.0), q[k], 1e-5) << v;
  }
}

TEST(Pose, AnAnimatedNodeWithARebasedMeshRotatesAboutItsOwnOrigin) {
  GltfFile file = tests::triangle_under_root();
  file.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] =
      file.add({1024, 0, 0, 1025, 0, 0, 1024, 1, 0}, "VEC3");
  const float half = std::sqrt(0.5F);
  file.animate(1, "rotation", {0, 1}, {0, 0, 0, 1, 0, 0, half, half});
  const AnimatedScene scene = import(file);
  ASSERT_EQ(scene.rig.offsets.at(0)[0], 1024.0);
  const Pose turned = pose(scene, scene.animations[0], 1);
  const Vertex& v = scene.scene.meshes[0].vertices[1];
  const Point at = turned.placed.at(0).parent_from_local * point(v);
  EXPECT_NEAR(at[0], 0, 1e-3);
  EXPECT_NEAR(at[1], 1025, 1e-3);
}

TEST(Pose, ShapesAreBlended) {
  GltfFile file = tests::triangle_under_root();
  const int lifted = file.add({0, 0, 2, 0, 0, 0, 0, 0, 0}, "VEC3");
  file.json["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", lifted}}};
  file.json["meshes"][0]["weights"] = {0};
  file.animate(1, "weights", {0, 1}, {0, 1});
  const AnimatedScene scene = import(file);
  ASSERT_EQ(scene.animations.size(), 1U);
  const Pose half = pose(scene, scene.animations[0], 0.25);
  ASSERT_EQ(half.shaped.size(), 1U);
  expect_near(half.shaped[0].vertices[0], {0, 0, 0.5});
  expect_near(half.shaped[0].vertices[1], {1, 0, 0});
}

TEST(Pose, RestWeightsHoldUntilAnAnimationHasOthers) {
  GltfFile file = tests::triangle_under_root();
  const int lifted = file.add({0, 0, 2, 0, 0, 0, 0, 0, 0}, "VEC3");
  file.json["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", lifted}}};
  file.json["meshes"][0]["weights"] = {0.5};
  EXPECT_EQ(import(file).scene.meshes[0].vertices[0], (Vertex{0, 0, 1}));
  file.json["nodes"][1]["weights"] = {-1};
  EXPECT_EQ(import(file).scene.meshes[0].vertices[0], (Vertex{0, 0, -2}));
  file.animate(1, "weights", {0, 1}, {0.25F, 1});
  const AnimatedScene scene = import(file);
  EXPECT_EQ(scene.scene.meshes[0].vertices[0], (Vertex{0, 0, -2}));
  expect_near(pose(scene, scene.animations[0], 0).shaped.at(0).vertices[0], {0, 0, 0.5});
}

TEST(Pose, RestWeightsAreKeptWhileASkinMoves) {
  GltfFile file = tests::bending_strip();
  const int lifted =
      file.add(std::vector<float>{0, 0, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 8}, "VEC3");
  file.json["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", lifted}}};
  file.json["nodes"][1]["weights"] = {0.5};
  const AnimatedScene scene = import(file);
  const Pose bent = pose(scene, scene.animations[0], 1);
  const Point top = in_world(scene.scene, bent, bent.shaped.at(0), 5);
  EXPECT_NEAR(top[0], -1, kNear);
  EXPECT_NEAR(top[1], 1.5, kNear);
  EXPECT_NEAR(top[2], 4, kNear);
}

TEST(Pose, StepsAndSplinesArePlayed) {
  const auto x_at = [](const char* interpolation, const std::vector<float>& values,
                       double seconds) {
    GltfFile file = tests::triangle_under_root();
    file.animate(1, "translation", {0, 2}, values);
    file.json["animations"][0]["samplers"][0]["interpolation"] = interpolation;
    const AnimatedScene scene = import(file);
    return pose(scene, scene.animations.at(0), seconds).placed.at(0).parent_from_local[3];
  };
  EXPECT_EQ(x_at("STEP", {1, 0, 0, 5, 0, 0}, 1.9), 1);
  EXPECT_EQ(x_at("STEP", {1, 0, 0, 5, 0, 0}, 2), 5);
  const std::vector<float> spline{0, 0, 0, 1, 0, 0, 8, 0, 0, 0, 0, 0, 5, 0, 0, 0, 0, 0};
  EXPECT_EQ(x_at("CUBICSPLINE", spline, 1), 3 + 2 * 8 / 8.0);
  EXPECT_EQ(x_at("CUBICSPLINE", spline, 3), 5);
}

// The node that has the strip vanishes, but its joints do not.
TEST(Pose, ASkinOutlivesItsNode) {
  GltfFile file = tests::bending_strip();
  file.animate(1, "scale", {0, 1}, {1, 1, 1, 0, 0, 0});
  const AnimatedScene scene = import(file);
  const Pose bent = pose(scene, scene.animations[0], 1);
  ASSERT_EQ(bent.shaped.size(), 1U);
  EXPECT_EQ(scene.scene.nodes[bent.shaped[0].nodes[0]].parent, kNone);
  const Point top = in_world(scene.scene, bent, bent.shaped[0], 5);
  EXPECT_NEAR(top[0], -1, kNear);
  EXPECT_NEAR(top[1], 1.5, kNear);
}

TEST(Pose, AFileWithoutAnimationsHasNone) {
  EXPECT_TRUE(import(tests::triangle_under_root()).animations.empty());
}

TEST(AnimatedImport, TheSceneEqualsThatOfAPlainImport) {
  const TempDir dir;
  const std::string path = dir.write("strip.gltf", tests::bending_strip().text());
  const auto animated = import_animated_scene(path, {UpAxis::kZ, {}});
  const auto plain = import_scene(path, {UpAxis::kZ, {}});
  ASSERT_TRUE(animated && plain);
  ASSERT_EQ(animated->scene.nodes.size(), plain->nodes.size());
  for (std::size_t i = 0; i < plain->nodes.size(); ++i) {
    EXPECT_EQ(animated->scene.nodes[i].name, plain->nodes[i].name);
    EXPECT_EQ(animated->scene.nodes[i].parent_from_local, plain->nodes[i].parent_from_local);
  }
  EXPECT_EQ(animated->scene.meshes[0].vertices, plain->meshes[0].vertices);
}

TEST(AnimatedImport, RefusesUnorderedKeys) {
  GltfFile file = tests::triangle_under_root();
  file.animate(1, "translation", {1, 0}, {0, 0, 0, 4, 0, 8});
  const TempDir dir;
  const auto scene = import_animated_scene(dir.write("file.gltf", file.text()));
  ASSERT_FALSE(scene);
  EXPECT_NE(scene.error().message.find("node 'blade'"), std::string::npos);
}

class RealAnimations : public testing::Test {
 protected:
  static AnimatedScene import_real(const std::string& name) {
    auto scene = import_animated_scene(std::string(std::getenv("SIGHTLINE_SCENES")) + "/" + name);
    EXPECT_TRUE(scene) << scene.error().message;
    return scene ? *std::move(scene) : AnimatedScene{};
  }
  void SetUp() override {
    if (std::getenv("SIGHTLINE_SCENES") == nullptr) GTEST_SKIP() << "SIGHTLINE_SCENES is not set";
  }
};

// The angles are slerps of the file's own numbers, computed independently of this code.
TEST_F(RealAnimations, TheWheelsOfTheMilkTruckTurnOnceIn1250Milliseconds) {
  const AnimatedScene truck = import_real("cesium_milk_truck.glb");
  ASSERT_EQ(truck.animations.size(), 1U);
  EXPECT_NEAR(truck.animations[0].seconds, 1.25, 1e-5);
  const std::vector<std::pair<double, double>> degrees{{0, 349.8469851},      {0.1, 321.8595883},
                                                       {0.3125, 262.3854996}, {0.625, 174.9239959},
                                                       {0.9, 97.9572176},     {1.25, 0}};
  for (const auto& [seconds, angle] : degrees) {
    const Pose now = pose(truck, truck.animations[0], seconds);
    ASSERT_EQ(now.placed.size(), 2U);
    const Transform expected = turn_about_z(angle);
    for (const Pose::Placed& wheel : now.placed) {
      for (std::size_t k = 0; k < 12; ++k) {
        EXPECT_NEAR(wheel.parent_from_local[k], expected[k], 1e-5) << seconds << " " << k;
      }
    }
  }
}

TEST_F(RealAnimations, TheRobotsSkinsDoNotTear) {
  const AnimatedScene robot = import_real("brainstem.glb");
  ASSERT_EQ(robot.animations.size(), 1U);
  EXPECT_NEAR(robot.animations[0].seconds, 34.88, 1e-4);
  EXPECT_EQ(robot.animations[0].channels.size(), 19U);
  ASSERT_EQ(robot.animations[0].deformations.size(), 59U);
  const Pose walking = pose(robot, robot.animations[0], 10);
  double low = 1e9, high = -1e9;
  for (const Pose::Shaped& shaped : walking.shaped) {
    for (std::size_t v = 0; v < shaped.vertices.size(); ++v) {
      const double up = in_world(robot.scene, walking, shaped, v)[1];
      low = std::min(low, up);
      high = std::max(high, up);
    }
  }
  EXPECT_GT(low, -0.3) << "it stands on the ground";
  EXPECT_GT(high - low, 1.4);
  EXPECT_LT(high - low, 2.2) << "as tall as in its rest pose";
}

TEST_F(RealAnimations, TheDroneMovesItsPartsAndBlendsAShape) {
  const AnimatedScene drone = import_real("buster_drone/scene.gltf");
  ASSERT_EQ(drone.animations.size(), 1U);
  EXPECT_NEAR(drone.animations[0].seconds, 25, 1e-3);
  EXPECT_EQ(drone.animations[0].channels.size(), 33U);
  EXPECT_EQ(drone.animations[0].deformations.size(), 1U);
}

}  // namespace
}  // namespace sightline::client::importer
