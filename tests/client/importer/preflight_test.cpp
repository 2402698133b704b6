// Files on which Assimp would hang or exhaust memory, and similar valid ones.
#include "client/importer/preflight.h"

#include <gtest/gtest.h>

#include <string>

namespace sightline::client::importer {
namespace {

std::string error_of(const Status& status) { return status ? "" : status.error().message; }

std::string little_endian(std::uint32_t x) {
  std::string bytes;
  for (unsigned i = 0; i < 4; ++i) bytes += static_cast<char>(x >> (8 * i) & 0xFFU);
  return bytes;
}

std::string glb(std::uint32_t length, const std::string& json) {
  return "glTF" + little_endian(2) + little_endian(static_cast<std::uint32_t>(20 + json.size())) +
         little_endian(length) + "JSON" + json;
}

/// Node i has node i + 1 as child `copies` times; the last node has no children.
std::string chain(int nodes, int copies) {
  std::string json = R"({"nodes": [)";
  for (int i = 0; i + 1 < nodes; ++i) {
    json += R"({"children": [)";
    for (int k = 0; k < copies; ++k) {
      if (k > 0) json += ',';
      json += std::to_string(i + 1);
    }
    json += "]},";
  }
  return json + "{}]}";
}

TEST(Preflight, AcceptsAValidFile) {
  EXPECT_EQ(error_of(preflight("good.glb", glb(2, "{}"))), "");
  EXPECT_EQ(error_of(preflight("good.gltf", chain(3, 1))), "");
  EXPECT_EQ(error_of(preflight("other.obj", "v 0 0 0\n")), "");
  EXPECT_EQ(error_of(preflight("empty.glb", "")), "");
}

TEST(Preflight, RefusesAGlbChunkBeyondTheFile) {
  for (const std::uint32_t length : {3U, 0x7FFFFFFFU, 0xFFFFFFFFU})
    EXPECT_NE(error_of(preflight("long.glb", glb(length, "{}"))), "") << length;
  EXPECT_EQ(error_of(preflight("cut.glb", glb(2, "{}") + "abcd")), "");
}

TEST(Preflight, LimitsTheNodesOfGltfAndGlb) {
  const std::string json = chain(40, 2);
  EXPECT_NE(error_of(preflight("many.gltf", json)), "");
  const std::string file = glb(static_cast<std::uint32_t>(json.size()), json);
  EXPECT_NE(error_of(preflight("many.glb", file)), "");
}

TEST(GltfNodes, AFewNodesMayHaveTwoParents) {
  EXPECT_EQ(error_of(check_gltf_nodes(chain(20, 2))), "");
  EXPECT_NE(error_of(check_gltf_nodes(chain(22, 2))).find("node 0 stands for 4194303 nodes"),
            std::string::npos);
  EXPECT_NE(error_of(check_gltf_nodes(chain(500, 9))), "");
}

TEST(GltfNodes, DepthIsLimited) {
  EXPECT_EQ(error_of(check_gltf_nodes(chain(kDeepestNode, 1))), "");
  EXPECT_NE(error_of(check_gltf_nodes(chain(kDeepestNode + 1, 1))).find("4097 deep"),
            std::string::npos);
  EXPECT_NE(error_of(check_gltf_nodes(chain(300000, 1))), "");
}

TEST(GltfNodes, BracketsAreLimited) {
  EXPECT_NE(error_of(check_gltf_nodes(std::string(100000, '['))).find("256 brackets"),
            std::string::npos);
  EXPECT_EQ(error_of(check_gltf_nodes(std::string(200, '[') + std::string(200, ']'))), "");
  std::string beside = R"(["]", "\"[[[", {)";
  for (int i = 0; i < 1000; ++i) beside += "\"k" + std::to_string(i) + R"(": [{}, "[{"], )";
  EXPECT_EQ(error_of(check_gltf_nodes(beside + R"("last": 1}])")), "");
}

TEST(GltfNodes, LeavesOtherFaultsToAssimp) {
  for (const char* json :
       {"", "{", "[]", "{}", R"({"nodes": 3})", R"({"nodes": {"a": {"children": ["a"]}}})",
        R"({"nodes": [1, null, {"children": 7}, {"children": ["x", -1, 99, 2.5]}]})",
        R"({"nodes": [{"children": [0]}]})",
        R"({"nodes": [{"children": [1]}, {"children": [2, 0]}, {"children": [1]}]})"}) {
    EXPECT_EQ(error_of(check_gltf_nodes(json)), "") << json;
  }
}

}  // namespace
}  // namespace sightline::client::importer
