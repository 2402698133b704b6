// Tracks of every interpolation and type.
#include "client/importer/gltf/animations.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/client/importer/gltf/read_file.h"

namespace sightline::client::importer::gltf {
namespace {

using tests::GltfFile;
using tests::read_made;
using tests::refusal_of;
using tests::triangle_under_root;
using tests::warns_of;

Animation animation_of(const GltfFile& file) {
  const auto scene = read_made(file);
  EXPECT_TRUE(scene) << scene.error().message;
  if (!scene || scene->animations.size() != 1) return {};
  return scene->animations[0];
}

GltfFile animated(const std::string& path, const std::vector<float>& seconds,
                  const std::vector<float>& values, const char* interpolation = nullptr) {
  GltfFile file = triangle_under_root();
  file.animate(1, path, seconds, values);
  if (interpolation != nullptr)
    file.json["animations"][0]["samplers"][0]["interpolation"] = interpolation;
  return file;
}

TEST(GltfAnimations, AreLinearUnlessTheySayOtherwise) {
  const std::vector<float> values{0, 0, 0, 2, 4, 8};
  for (const char* mode : {static_cast<const char*>(nullptr), "LINEAR"}) {
    const Animation animation = animation_of(animated("translation", {1, 3}, values, mode));
    EXPECT_EQ(sample(animation.channels.at(0).positions, 1.5), (Point{0.5, 1, 2}));
    EXPECT_EQ(animation.seconds, 3);
  }
  const Animation step = animation_of(animated("scale", {1, 3}, values, "STEP"));
  EXPECT_EQ(sample(step.channels.at(0).scalings, 2.9), (Point{0, 0, 0}));
  EXPECT_EQ(sample(step.channels.at(0).scalings, 3), (Point{2, 4, 8}));
  EXPECT_NE(refusal_of(animated("scale", {1, 3}, values, "SMOOTH")).find("'SMOOTH'"),
            std::string::npos);
}

// In-tangent, value and out-tangent of each key. With two keys that are 2 s apart, the middle is
// the mean of the values plus an eighth of 2 s times the difference of the tangents.
TEST(GltfAnimations, OfCubicSplinesHaveTangents) {
  const Animation moved =
      animation_of(animated("translation", {1, 3},
                            {9, 9, 9, 0, 0, 0, 4, 0, 0, 0, 8, 0, 2, 2, 2, 9, 9, 9}, "CUBICSPLINE"));
  const Track<Point>& track = moved.channels.at(0).positions;
  EXPECT_EQ(sample(track, 2), (Point{2, -1, 1}));
  EXPECT_EQ(sample(track, 0), (Point{0, 0, 0}));
  EXPECT_EQ(sample(track, 9), (Point{2, 2, 2}));
  const Animation turned =
      animation_of(animated("rotation", {0, 1}, {0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0,  //
                                                 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0},
                            "CUBICSPLINE"));
  const Quaternion half = sample(turned.channels.at(0).rotations, 0.5);
  EXPECT_NEAR(half[0], std::sqrt(0.5), 1e-12);
  EXPECT_NEAR(half[3], std::sqrt(0.5), 1e-12);
  EXPECT_NE(refusal_of(animated("scale", {1, 3}, {0, 0, 0, 2, 4, 8}, "CUBICSPLINE"))
                .find("2 keys need 6 values, but there are 2"),
            std::string::npos);
}

TEST(GltfAnimations, OfWeightsHaveOneForEachShape) {
  const auto file = [](const std::vector<float>& values, const char* interpolation) {
    GltfFile out = triangle_under_root();
    out.json["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", 0}}, {{"POSITION", 0}}};
    out.animate(1, "weights", {0, 2}, values);
    out.json["animations"][0]["samplers"][0]["interpolation"] = interpolation;
    return out;
  };
  const auto at = [&](const std::vector<float>& values, const char* interpolation, double seconds) {
    const Animation animation = animation_of(file(values, interpolation));
    EXPECT_EQ(animation.deformations.at(0).mesh, kNone);
    return sample(animation.deformations.at(0).weights, seconds);
  };
  using Weights = std::vector<double>;
  EXPECT_EQ(at({0, 1, 1, 0}, "LINEAR", 0.5), (Weights{0.25, 0.75}));
  EXPECT_EQ(at({0, 1, 1, 0}, "STEP", 1.5), (Weights{0, 1}));
  EXPECT_EQ(at({9, 9, 0, 1, 0, 0, 0, 0, 1, 0, 9, 9}, "CUBICSPLINE", 1), (Weights{0.5, 0.5}));
  EXPECT_EQ(at({9, 9, 0, 1, 4, 0, 0, 0, 1, 0, 9, 9}, "CUBICSPLINE", 1), (Weights{1.5, 0.5}));
  EXPECT_NE(refusal_of(file({0, 1, 1}, "LINEAR")), "");
  EXPECT_NE(refusal_of(file({0, 1, 1, 0, 0, 0}, "LINEAR")).find("2 keys need 2 values"),
            std::string::npos);
}

TEST(GltfAnimations, OfWeightsConcernAllInstances) {
  GltfFile file = triangle_under_root();
  file.json["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", 0}}};
  const int two = file.add({0, 0, 0, 1, 1, 1}, "VEC3");
  file.json["nodes"][1]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
      {"TRANSLATION", two}};
  file.animate(1, "weights", {0, 2}, {0, 1});
  const Animation animation = animation_of(file);
  ASSERT_EQ(animation.deformations.size(), 2U);
  EXPECT_EQ(animation.deformations[0].node, 2U);
  EXPECT_EQ(animation.deformations[1].node, 3U);
}

template <class T>
Quaternion turn_by(const std::vector<T>& values) {
  GltfFile file = triangle_under_root();
  file.animate(1, "rotation", {0, 1}, std::vector<float>(8));
  const int output = file.add(values, "VEC4");
  file.json["accessors"][output]["normalized"] = true;
  file.json["animations"][0]["samplers"][0]["output"] = output;
  return sample(animation_of(file).channels.at(0).rotations, 1);
}

TEST(GltfAnimations, HaveValuesOfNormalizedIntegers) {
  const double half = std::sqrt(0.5);
  const Quaternion bytes = turn_by<std::int8_t>({0, 0, 0, 127, 0, -90, 0, 90});
  EXPECT_NEAR(bytes[0], half, 1e-12);
  EXPECT_NEAR(bytes[2], -half, 1e-12);
  const Quaternion shorts = turn_by<std::int16_t>({0, 0, 0, 32767, 0, 0, 30000, 30000});
  EXPECT_NEAR(shorts[3], half, 1e-12);
  const Quaternion words = turn_by<std::uint16_t>({0, 0, 0, 65535, 65535, 0, 0, 65535});
  EXPECT_NEAR(words[1], half, 1e-12);
}

TEST(GltfAnimations, OfOneNodeAreOneChannelAndHoldTheRestOfIt) {
  GltfFile file = triangle_under_root();
  file.json["nodes"][1]["scale"] = {1, 2, 3};
  file.animate(1, "translation", {0, 1}, {0, 0, 0, 1, 0, 0});
  file.animate(0, "scale", {0, 4}, {1, 1, 1, 2, 2, 2});
  file.animate(1, "rotation", {0, 2}, {0, 0, 0, 1, 0, 0, 1, 0});
  const Animation animation = animation_of(file);
  ASSERT_EQ(animation.channels.size(), 2U);
  EXPECT_EQ(animation.channels[0].node, 1U);
  EXPECT_EQ(sample(animation.channels[0].scalings, 7), (Point{1, 2, 3}));
  EXPECT_EQ(animation.channels[0].positions.keys.size(), 2U);
  EXPECT_EQ(animation.channels[0].rotations.keys.size(), 2U);
  EXPECT_EQ(animation.seconds, 4);
}

TEST(GltfAnimations, OfOtherThingsAreWarnedAbout) {
  GltfFile file = animated("translation", {0, 1}, {0, 0, 0, 1, 0, 0});
  nlohmann::json& channels = file.json["animations"][0]["channels"];
  channels.push_back({{"sampler", 0}, {"target", {{"path", "pointer"}}}});
  channels.push_back({{"sampler", 0}, {"target", {{"node", 1}, {"path", "visibility"}}}});
  channels.push_back({{"sampler", 0}, {"target", {{"path", "translation"}}}});
  const auto scene = read_made(file);
  ASSERT_TRUE(scene) << scene.error().message;
  EXPECT_EQ(scene->animations.at(0).channels.size(), 1U);
  ASSERT_EQ(scene->warnings.size(), 1U);
  EXPECT_EQ(scene->warnings[0].kind, "animation_target");
  EXPECT_EQ(scene->warnings[0].count, 2U);
  EXPECT_NE(scene->warnings[0].message.find("'pointer'"), std::string::npos);
}

TEST(GltfAnimations, OfAMatrixAreWarnedAbout) {
  GltfFile file = animated("translation", {0, 1}, {0, 0, 0, 1, 0, 0});
  file.json["nodes"][1]["matrix"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 0, 0, 1};
  const auto scene = read_made(file);
  ASSERT_TRUE(scene) << scene.error().message;
  EXPECT_TRUE(scene->animations.at(0).channels.empty());
  EXPECT_TRUE(warns_of(*scene, "animated_matrix"));
}

TEST(GltfAnimations, OfOneTargetTwiceAreWarnedAbout) {
  for (const char* path : {"translation", "scale"}) {
    GltfFile file = animated(path, {0, 1}, {0, 0, 0, 1, 0, 0});
    nlohmann::json& channels = file.json["animations"][0]["channels"];
    const nlohmann::json again = channels[0];
    channels.push_back(again);
    const auto scene = read_made(file);
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_EQ(scene->animations.at(0).channels.size(), 1U);
    EXPECT_TRUE(warns_of(*scene, "animated_twice"));
    channels.erase(1);
    const nlohmann::json one = file.json["animations"][0];
    file.json["animations"].push_back(one);
    EXPECT_FALSE(warns_of(*read_made(file), "animated_twice")) << "in two animations";
  }
}

TEST(GltfAnimations, MustFit) {
  const auto said = [](const char* key, const nlohmann::json& value) {
    GltfFile file = animated("translation", {0, 1}, {0, 0, 0, 1, 0, 0});
    file.json["animations"][0]["samplers"][0][key] = value;
    return refusal_of(file);
  };
  EXPECT_NE(said("input", 9).find("accessors[9]"), std::string::npos);
  EXPECT_NE(said("output", 0).find("2 keys need 2 values, but there are 3"), std::string::npos);
  EXPECT_NE(said("output", 1), "");
  GltfFile file = animated("translation", {0, 1}, {0, 0, 0, 1, 0, 0});
  file.json["animations"][0]["channels"][0]["sampler"] = 1;
  EXPECT_NE(refusal_of(file).find("names sampler 1, but there are 1"), std::string::npos);
}

}  // namespace
}  // namespace sightline::client::importer::gltf
