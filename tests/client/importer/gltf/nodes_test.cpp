// Scenes, hierarchies, transforms and instances.
#include "client/importer/gltf/nodes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/client/importer/gltf/read_file.h"

namespace sightline::client::importer::gltf {
namespace {

using nlohmann::json;
using tests::GltfFile;
using tests::read_made;
using tests::refusal_of;
using tests::triangle_under_root;
using tests::warns_of;

using Names = std::vector<std::string>;

Names names_of(const Result<FileScene>& scene) {
  EXPECT_TRUE(scene) << scene.error().message;
  Names out;
  for (const FileNode& node : scene->nodes) out.push_back(node.name);
  return out;
}

GltfFile with_nodes(const json& nodes, const json& roots = json::array({0})) {
  GltfFile file = triangle_under_root();
  file.json["nodes"] = nodes;
  file.json["scenes"][0]["nodes"] = roots;
  return file;
}

TEST(Nodes, AreDepthFirstWithChildrenInOrder) {
  const auto scene = read_made(with_nodes({{{"name", "a"}, {"children", {3, 1}}},
                                           {{"name", "b"}},
                                           {{"mesh", 0}},
                                           {{"name", "d"}, {"children", {2}}}}));
  EXPECT_EQ(names_of(scene), (Names{"a", "d", "nodes[2]", "b"}));
  EXPECT_EQ(scene->nodes[2].parent, 1U);
  EXPECT_EQ(scene->nodes[3].parent, 0U);
  EXPECT_EQ(scene->nodes[2].meshes, std::vector<std::uint32_t>{0});
}

TEST(Nodes, OfSeveralRootsHaveOneRootAbove) {
  const json nodes = {{{"name", "a"}}, {{"name", "b"}}, {{"name", "unused"}}};
  EXPECT_EQ(names_of(read_made(with_nodes(nodes, {0, 1}))), (Names{"ROOT", "a", "b"}));
  EXPECT_EQ(names_of(read_made(with_nodes(nodes, {1}))), (Names{"b"}));
  EXPECT_EQ(names_of(read_made(with_nodes(nodes, json::array()))), (Names{"ROOT"}));
}

TEST(Nodes, AreThoseOfTheSceneThatTheFileNames) {
  GltfFile file = with_nodes({{{"name", "a"}}, {{"name", "b"}}});
  file.json["scenes"].push_back({{"nodes", {1}}});
  const auto first = read_made(file);
  EXPECT_EQ(names_of(first), (Names{"a"}));
  EXPECT_TRUE(warns_of(*first, "other_scenes"));
  file.json["scene"] = 1;
  EXPECT_EQ(names_of(read_made(file)), (Names{"b"}));
  file.json.erase("scene");
  EXPECT_EQ(names_of(read_made(file)), (Names{"a"}));
  file.json["scene"] = 2;
  EXPECT_NE(refusal_of(file).find("scenes[2], but there are 2"), std::string::npos);
  file.json.erase("scene");
  file.json.erase("scenes");
  const auto all = read_made(file);
  EXPECT_EQ(names_of(all), (Names{"ROOT", "a", "b"}));
  EXPECT_TRUE(warns_of(*all, "no_scene"));
}

TEST(Nodes, HaveOneParent) {
  const auto said = [](const json& nodes, const json& roots = json::array({0})) {
    return refusal_of(with_nodes(nodes, roots));
  };
  EXPECT_NE(said({{{"children", {2}}}, {{"children", {2}}}, json::object()}, {0, 1})
                .find("nodes[2] has two parents, nodes[0] and nodes[1]"),
            std::string::npos);
  EXPECT_NE(said({{{"children", {1, 1}}}, json::object()}).find("two parents"), std::string::npos);
  EXPECT_NE(said(json::array({{{"children", {0}}}})).find("nodes[0]"), std::string::npos);
  EXPECT_NE(said({{{"children", {1}}}, {{"children", {0}}}}), "");
  EXPECT_NE(said({{{"children", {1}}}, {{"children", {2}}}, {{"children", {1}}}}), "");
  EXPECT_NE(said({{{"children", {1}}}, json::object()}, {0, 1}).find("a child of nodes[0]"),
            std::string::npos);
  EXPECT_NE(said(json::array({json::object()}), {0, 0}).find("twice"), std::string::npos);
  EXPECT_NE(said(json::array({{{"children", {5}}}})).find("nodes[5], but there are 1"),
            std::string::npos);
  EXPECT_NE(said(json::array({{{"mesh", 5}}})).find("meshes[5], but there are 1"),
            std::string::npos);
}

TEST(Nodes, MayBeDeep) {
  json nodes;
  constexpr int kDeep = 5000;
  for (int i = 0; i + 1 < kDeep; ++i) nodes.push_back({{"children", {i + 1}}});
  nodes.push_back({{"mesh", 0}});
  const auto scene = read_made(with_nodes(nodes));
  ASSERT_TRUE(scene) << scene.error().message;
  EXPECT_EQ(scene->nodes.size(), static_cast<std::size_t>(kDeep));
}

Transform transform_of(const json& node) {
  const auto scene = read_made(with_nodes(json::array({node})));
  EXPECT_TRUE(scene) << scene.error().message;
  return scene ? scene->nodes[0].parent_from_local : Transform{};
}

void expect_near(const Transform& actual, const Transform& expected) {
  for (std::size_t k = 0; k < 12; ++k) EXPECT_NEAR(actual[k], expected[k], 1e-15) << k;
}

TEST(Transforms, AreMatricesOrParts) {
  expect_near(transform_of(json::object()), kIdentity);
  expect_near(transform_of({{"matrix", {1, 5, 9, 0, 2, 6, 10, 0, 3, 7, 11, 0, 4, 8, 12, 1}}}),
              {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12});
  const double half = std::sqrt(0.5);
  // A turn by 90 degrees about z, after scaling.
  expect_near(transform_of({{"translation", {0.1, 1e10, -3}},
                            {"rotation", {0, 0, half, half}},
                            {"scale", {2, -3, 0}}}),
              {0, 3, 0, 0.1, 2, 0, 0, 1e10, 0, 0, 0, -3});
  expect_near(transform_of({{"rotation", {0, 0, 2, 2}}}), {0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0});
  expect_near(transform_of({{"rotation", {0, 0, 0, 0}}}), kIdentity);
}

TEST(Transforms, MustBeWhole) {
  const auto said = [](const json& node) { return refusal_of(with_nodes(json::array({node}))); };
  const json identity = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  EXPECT_NE(said({{"matrix", {1, 2, 3}}}).find("nodes[0]: matrix has 3 numbers"),
            std::string::npos);
  EXPECT_NE(said({{"matrix", identity}, {"scale", {1, 1, 1}}}).find("nodes[0]"), std::string::npos);
  json projective = identity;
  projective[11] = -1;
  EXPECT_NE(said({{"matrix", projective}}).find("last row"), std::string::npos);
  EXPECT_NE(said({{"scale", {1, "1", 1}}}), "");
  EXPECT_NE(said({{"rotation", {0, 0, 1}}}), "");
}

TEST(Visibility, TakesMeshesOfInvisibleNodesAndTheirChildren) {
  const json hidden = {{"KHR_node_visibility", {{"visible", false}}}};
  const json shown = {{"KHR_node_visibility", {{"visible", true}}}};
  const auto scene = read_made(with_nodes({{{"name", "root"}, {"children", {1, 2, 4}}},
                                           {{"mesh", 0}, {"extensions", hidden}},
                                           {{"extensions", hidden}, {"children", {3}}},
                                           {{"mesh", 0}, {"extensions", shown}},
                                           {{"mesh", 0}, {"extensions", shown}}}));
  ASSERT_TRUE(scene) << scene.error().message;
  ASSERT_EQ(scene->nodes.size(), 5U);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(scene->nodes[i].meshes.empty(), i != 4) << i;
}

/// The triangle, with instances of these attributes.
GltfFile instanced(GltfFile file, const json& attributes) {
  file.json["nodes"][1]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = attributes;
  return file;
}

TEST(Instances, AreChildren) {
  GltfFile file = triangle_under_root();
  file.json["nodes"][1]["translation"] = {100, 0, 0};
  file.json["nodes"][1]["children"] = {2};
  file.json["nodes"].push_back({{"name", "child"}, {"mesh", 0}});
  const int translations = file.add({1, 2, 3, 4, 5, 6}, "VEC3");
  const int scales = file.add({1, 1, 1, 2, 3, 4}, "VEC3");
  const auto scene = read_made(instanced(file, {{"TRANSLATION", translations}, {"SCALE", scales}}));
  EXPECT_EQ(names_of(scene), (Names{"root", "blade", "blade#0", "blade#1", "child"}));
  EXPECT_TRUE(scene->nodes[1].meshes.empty());
  EXPECT_EQ(scene->nodes[2].parent, 1U);
  EXPECT_EQ(scene->nodes[2].parent_from_local, (Transform{1, 0, 0, 1, 0, 1, 0, 2, 0, 0, 1, 3}));
  EXPECT_EQ(scene->nodes[3].parent_from_local, (Transform{2, 0, 0, 4, 0, 3, 0, 5, 0, 0, 4, 6}));
  EXPECT_EQ(scene->nodes[4].parent, 1U);
  EXPECT_EQ(scene->meshes.size(), 1U);
  for (const std::size_t i : {2U, 3U, 4U}) EXPECT_EQ(scene->nodes[i].meshes.size(), 1U) << i;
}

TEST(Instances, TurnByFloatsAndNormalizedIntegers) {
  const Transform about_x{1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0};
  GltfFile floats = triangle_under_root();
  const float half = std::sqrt(0.5F);
  floats = instanced(floats, {{"ROTATION", floats.add({half, 0, 0, half}, "VEC4")}});
  expect_near(read_made(floats)->nodes.at(2).parent_from_local, about_x);
  GltfFile bytes = triangle_under_root();
  const int turns = bytes.add(std::vector<std::int8_t>{90, 0, 0, 90}, "VEC4");
  bytes.json["accessors"][turns]["normalized"] = true;
  expect_near(read_made(instanced(bytes, {{"ROTATION", turns}}))->nodes.at(2).parent_from_local,
              about_x);
  GltfFile shorts = triangle_under_root();
  const int more = shorts.add(std::vector<std::int16_t>{-20000, 0, 0, -20000}, "VEC4");
  shorts.json["accessors"][more]["normalized"] = true;
  expect_near(read_made(instanced(shorts, {{"ROTATION", more}}))->nodes.at(2).parent_from_local,
              about_x);
}

TEST(Instances, HaveOneCountWithinALimit) {
  GltfFile file = triangle_under_root();
  const int two = file.add({0, 0, 0, 1, 1, 1}, "VEC3"),
            three = file.add({0, 0, 0, 1, 1, 1, 2, 2, 2}, "VEC3");
  EXPECT_NE(
      refusal_of(instanced(file, {{"TRANSLATION", two}, {"SCALE", three}})).find("2 elements"),
      std::string::npos);
  EXPECT_NE(refusal_of(instanced(file, json::object())).find("attributes is empty"),
            std::string::npos);
  file.json["accessors"][two].erase("bufferView");
  file.json["accessors"][two]["count"] = kMostNodes + 1;
  EXPECT_NE(refusal_of(instanced(file, {{"TRANSLATION", two}})).find("1048577 instances"),
            std::string::npos);
  EXPECT_NE(refusal_of(instanced(file, {{"TRANSLATION", 99}})).find("accessors[99]"),
            std::string::npos);
}

}  // namespace
}  // namespace sightline::client::importer::gltf
