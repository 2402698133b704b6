// Names of meshes, what nodes share, skins and shapes.
#include "client/importer/gltf/meshes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/client/importer/gltf/read_file.h"

namespace sightline::client::importer::gltf {
namespace {

using nlohmann::json;
using tests::bending_strip;
using tests::GltfFile;
using tests::read_made;
using tests::refusal_of;
using tests::triangle_under_root;
using tests::warns_of;

json& primitive_of(GltfFile& file) { return file.json["meshes"][0]["primitives"][0]; }

TEST(Meshes, HaveTheirNameAndTheNumberOfTheirPrimitive) {
  GltfFile file = triangle_under_root();
  EXPECT_EQ(read_made(file)->meshes.at(0).name, "meshes[0]");
  file.json["meshes"][0]["name"] = "knife";
  EXPECT_EQ(read_made(file)->meshes.at(0).name, "knife");
  file.json["meshes"][0]["primitives"].push_back(primitive_of(file));
  const auto scene = read_made(file);
  ASSERT_TRUE(scene) << scene.error().message;
  ASSERT_EQ(scene->meshes.size(), 2U);
  EXPECT_EQ(scene->meshes[0].name, "knife-0");
  EXPECT_EQ(scene->meshes[1].name, "knife-1");
  EXPECT_EQ(scene->nodes[1].meshes, (std::vector<std::uint32_t>{0, 1}));
}

TEST(Meshes, AreSharedByNodesWithTheSameSkinAndWeights) {
  GltfFile file = triangle_under_root();
  const int lifted = file.add({0, 0, 2, 0, 0, 0, 0, 0, 0}, "VEC3");
  primitive_of(file)["targets"] = {{{"POSITION", lifted}}};
  file.json["meshes"][0]["weights"] = {0.5};
  file.json["nodes"][0]["children"] = {1, 2, 3, 4};
  file.json["nodes"].push_back({{"mesh", 0}});
  file.json["nodes"].push_back({{"mesh", 0}, {"weights", {1}}});
  file.json["nodes"].push_back({{"mesh", 0}, {"weights", {0.5}}});
  const auto scene = read_made(file);
  ASSERT_TRUE(scene) << scene.error().message;
  ASSERT_EQ(scene->meshes.size(), 2U);
  EXPECT_EQ(scene->nodes[1].meshes, scene->nodes[2].meshes);
  EXPECT_EQ(scene->nodes[1].meshes, scene->nodes[4].meshes);
  EXPECT_NE(scene->nodes[1].meshes, scene->nodes[3].meshes);
  EXPECT_EQ(scene->meshes[0].weights, std::vector<double>{0.5});
  EXPECT_EQ(scene->meshes[1].weights, std::vector<double>{1});
}

TEST(Shapes, AreIntegersAndSparseToo) {
  GltfFile file = triangle_under_root();
  const int bytes = file.add(std::vector<std::int8_t>{127, 0, 0, 0, -127, 0, 0, 0, 0}, "VEC3");
  file.json["accessors"][bytes]["normalized"] = true;
  const int slots = file.add(std::vector<std::uint8_t>{2}, "SCALAR");
  const int values = file.add({7, 8, 9}, "VEC3");
  file.json["accessors"].push_back(
      {{"componentType", 5126},
       {"count", 3},
       {"type", "VEC3"},
       {"sparse",
        {{"count", 1},
         {"indices",
          {{"bufferView", file.json["accessors"][slots]["bufferView"]}, {"componentType", 5121}}},
         {"values", {{"bufferView", file.json["accessors"][values]["bufferView"]}}}}}});
  primitive_of(file)["targets"] = {
      {{"POSITION", bytes}}, {{"POSITION", values + 1}}, {{"NORMAL", bytes}}};
  const auto scene = read_made(file);
  ASSERT_TRUE(scene) << scene.error().message;
  const Shapes& shapes = scene->meshes.at(0).shapes;
  ASSERT_EQ(shapes.size(), 3U);
  EXPECT_EQ(shapes[0], (Shapes::value_type{{1, 0, 0}, {0, -1, 0}, {0, 0, 0}}));
  EXPECT_EQ(shapes[1], (Shapes::value_type{{0, 0, 0}, {0, 0, 0}, {7, 8, 9}}));
  EXPECT_EQ(shapes[2], Shapes::value_type(3));
  EXPECT_EQ(scene->meshes[0].weights, std::vector<double>(3));
}

TEST(Shapes, MustFit) {
  GltfFile file = triangle_under_root();
  const int two = file.add({0, 0, 2, 0, 0, 0}, "VEC3");
  primitive_of(file)["targets"] = {{{"POSITION", two}}};
  EXPECT_NE(refusal_of(file).find("POSITION has 2 elements, but there are 3"), std::string::npos);
  primitive_of(file)["targets"] = {{{"POSITION", 0}}};
  file.json["meshes"][0]["weights"] = {1, 2};
  EXPECT_NE(refusal_of(file).find("weights has 2 numbers, but there are 1"), std::string::npos);
  file.json["meshes"][0].erase("weights");
  file.json["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", 0}}}});
  EXPECT_NE(refusal_of(file).find("1 and 0 targets"), std::string::npos);
}

TEST(Skins, AreReadByVertex) {
  const auto scene = read_made(bending_strip());
  ASSERT_TRUE(scene) << scene.error().message;
  const Skin& skin = scene->meshes.at(0).skin;
  ASSERT_EQ(skin.bones.size(), 2U);
  EXPECT_EQ(scene->nodes[skin.bones[0].node].name, "foot");
  EXPECT_EQ(scene->nodes[skin.bones[1].node].name, "knee");
  EXPECT_EQ(skin.bones[1].bone_from_mesh[7], -1);
  EXPECT_EQ(skin.first, (std::vector<std::uint32_t>{0, 1, 2, 4, 6, 7, 8}));
  EXPECT_EQ(skin.influences[2].weight, 0.5);
  EXPECT_EQ(skin.influences[3].bone, 1U);
}

template <class T>
Skin skin_by(const std::vector<T>& weights, bool is_normalized) {
  GltfFile file = triangle_under_root();
  json& attributes = primitive_of(file)["attributes"];
  const int accessor = file.add(weights, "VEC4");
  file.json["accessors"][accessor]["normalized"] = is_normalized;
  attributes["WEIGHTS_0"] = accessor;
  attributes["JOINTS_0"] =
      file.add(std::vector<std::uint8_t>{0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1}, "VEC4");
  file.json["skins"] = {{{"joints", {0, 1}}}};
  file.json["nodes"][1]["skin"] = 0;
  const auto scene = read_made(file);
  EXPECT_TRUE(scene) << scene.error().message;
  return scene ? scene->meshes.at(0).skin : Skin{};
}

TEST(Skins, HaveWeightsThatAddUpTo1) {
  const auto check = [](const Skin& skin) {
    ASSERT_EQ(skin.influences.size(), 4U);
    EXPECT_NEAR(skin.influences[0].weight, 0.25, 1e-12);
    EXPECT_NEAR(skin.influences[1].weight, 0.75, 1e-12);
    EXPECT_EQ(skin.influences[2].weight, 1);
    EXPECT_EQ(skin.influences[3].bone, 1U);
    EXPECT_EQ(skin.bones.at(0).bone_from_mesh, kIdentity) << "no inverse bind matrices";
  };
  check(skin_by<std::uint8_t>({50, 150, 0, 0, 255, 0, 0, 0, 0, 0, 0, 3}, true));
  check(skin_by<std::uint16_t>({10000, 30000, 0, 0, 65535, 0, 0, 0, 0, 0, 0, 9}, true));
  check(skin_by<float>({0.125F, 0.375F, 0, 0, 7, 0, 0, 0, 0, 0, 0, 1}, false));
}

TEST(Skins, HaveMoreThanFourInfluencesInFurtherSets) {
  GltfFile file = bending_strip();
  json& attributes = primitive_of(file)["attributes"];
  std::vector<std::uint8_t> joints(24, 1);
  std::vector<float> weights(24, 0.25F);
  attributes["JOINTS_1"] = file.add(joints, "VEC4");
  attributes["WEIGHTS_1"] = file.add(weights, "VEC4");
  const auto scene = read_made(file);
  ASSERT_TRUE(scene) << scene.error().message;
  const Skin& skin = scene->meshes.at(0).skin;
  EXPECT_EQ(skin.first[1], 5U);
  EXPECT_EQ(skin.influences[0].weight, 0.5);
  EXPECT_EQ(skin.influences[4].weight, 0.125);
}

TEST(Meshes, WithoutPrimitivesAreWarnedAbout) {
  GltfFile file = bending_strip();
  file.json["meshes"].push_back({{"name", "none"}});
  file.json["nodes"].push_back({{"mesh", file.json["meshes"].size() - 1}});
  file.json["scenes"] = {{{"nodes", {0, file.json["nodes"].size() - 1}}}};
  const auto scene = read_made(file);
  ASSERT_TRUE(scene) << scene.error().message;
  EXPECT_TRUE(warns_of(*scene, "no_primitives"));
}

TEST(Skins, HaveAffineInverseBindMatrices) {
  GltfFile file = bending_strip();
  std::vector<float> matrices(32, 0);
  for (const std::size_t i : {0, 5, 10, 15, 16, 21, 26, 31}) matrices[i] = 1;
  file.json["skins"][0]["inverseBindMatrices"] = file.add(matrices, "MAT4");
  EXPECT_EQ(refusal_of(file), "");
  matrices[31] = 1.5F;
  file.json["skins"][0]["inverseBindMatrices"] = file.add(matrices, "MAT4");
  EXPECT_NE(refusal_of(file).find("an inverse bind matrix is 0 0 0 1.5, must be 0 0 0 1"),
            std::string::npos);
}

TEST(Skins, MustNameJointsOfTheScene) {
  GltfFile file = bending_strip();
  file.json["skins"][0]["joints"] = {2};
  EXPECT_NE(refusal_of(file).find("names joint 1, but the skin has 1"), std::string::npos);
  file.json["skins"][0]["joints"] = {2, 3, 1};
  EXPECT_NE(refusal_of(file).find("2 inverse bind matrices for 3 joints"), std::string::npos);
  file.json["skins"][0]["joints"] = {2, 9};
  EXPECT_NE(refusal_of(file).find("nodes[9]"), std::string::npos);
  file.json["nodes"].push_back({{"name", "elsewhere"}});
  file.json["skins"][0]["joints"] = {2, 4};
  EXPECT_NE(refusal_of(file).find("joint nodes[4] is not in the scene"), std::string::npos);
  file.json["nodes"][1]["skin"] = 5;
  EXPECT_NE(refusal_of(file).find("skins[5]"), std::string::npos);
}

TEST(Skins, HaveJointsThatAreIntegers) {
  for (const float joint : {0.5F, -1.F, 2.F, NAN}) {
    GltfFile file = bending_strip();
    const int joints = file.add(std::vector<float>(24, joint), "VEC4");
    file.json["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"] = joints;
    EXPECT_NE(refusal_of(file).find("names joint"), std::string::npos) << joint;
  }
}

TEST(Skins, NeedWeightsAndJoints) {
  GltfFile file = bending_strip();
  primitive_of(file)["attributes"].erase("WEIGHTS_0");
  EXPECT_NE(refusal_of(file).find("has no WEIGHTS_0"), std::string::npos);
  primitive_of(file)["attributes"].erase("JOINTS_0");
  const auto scene = read_made(file);
  ASSERT_TRUE(scene) << scene.error().message;
  EXPECT_TRUE(scene->meshes.at(0).skin.bones.empty());
  EXPECT_TRUE(warns_of(*scene, "no_joints"));
  GltfFile negative = bending_strip();
  primitive_of(negative)["attributes"]["WEIGHTS_0"] =
      negative.add(std::vector<float>(24, -1.0F), "VEC4");
  EXPECT_NE(refusal_of(negative).find("has the weight -1"), std::string::npos);
}

}  // namespace
}  // namespace sightline::client::importer::gltf
