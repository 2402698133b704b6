// Updates as JSON: accepted and refused text, and the errors.
#include "client/cli/files/update_json.h"

#include <gtest/gtest.h>

#include <string>

namespace sightline::client::cli::files {
namespace {

std::string error_of(const std::string& text) {
  const auto update = parse_update(text);
  return update ? "" : update.error().message;
}

constexpr const char* kMoved = "[1,0,0,4, 0,1,0,5, 0,0,1,6]";

TEST(UpdateJson, ReadsAllKinds) {
  const auto put = parse_update(std::string(R"({"put_node": {"node": -1, "parent": 3, "name": "box",
      "mobility": "rigid", "mask": 5, "mesh_digest": "sha256:0/1", "transform": )") +
                                kMoved + "}}");
  ASSERT_TRUE(put) << put.error().message;
  const auto& node = std::get<PutNode>(*put);
  EXPECT_EQ(node.node, -1);
  EXPECT_EQ(node.parent, 3);
  EXPECT_EQ(node.name, "box");
  EXPECT_EQ(node.mobility, Mobility::kRigid);
  EXPECT_EQ(node.mask, 5U);
  EXPECT_EQ(node.mesh_digest, "sha256:0/1");
  EXPECT_EQ(node.parent_from_local[7], 5);

  const auto set = parse_update(std::string(R"({"set_transforms": {"nodes": [7], "matrices": [)") +
                                kMoved + "]}}");
  ASSERT_TRUE(set) << set.error().message;
  EXPECT_EQ(std::get<SetTransforms>(*set).nodes, std::vector<NodeRef>{7});
  EXPECT_EQ(std::get<SetTransforms>(*set).parent_from_local[0][11], 6);

  const auto patch = parse_update(
      R"({"patch_vertices": {"nodes": [7, 8], "first": 2, "positions": [[1, 2, 3.5]]}})");
  ASSERT_TRUE(patch) << patch.error().message;
  EXPECT_EQ(std::get<PatchVertices>(*patch).first, 2U);
  EXPECT_EQ(std::get<PatchVertices>(*patch).positions, (std::vector<Vertex>{{1, 2, 3.5F}}));

  const auto deleted = parse_update(R"({"delete_node": {"node": 9, "subtree": true}})");
  ASSERT_TRUE(deleted) << deleted.error().message;
  EXPECT_TRUE(std::get<DeleteNode>(*deleted).subtree);
}

TEST(UpdateJson, LabelsAreAnObjectOfStrings) {
  const std::string text =
      R"({"put_node":{"node":-1,"parent":0,"name":"","mobility":"static","labels":{"b":"2","a":""}}})";
  const auto put = parse_update(text);
  ASSERT_TRUE(put) << put.error().message;
  EXPECT_EQ(std::get<PutNode>(*put).labels, (std::vector<Label>{{"b", "2"}, {"a", ""}}));
  EXPECT_EQ(json_of(*put, false).dump(), text);
  EXPECT_EQ(error_of(R"({"put_node": {"node": -1, "labels": [1]}})"),
            "put_node.labels is no object");
  EXPECT_EQ(error_of(R"({"put_node": {"node": -1, "labels": {"a": 1}}})"),
            "put_node.labels has at 'a' what is no string");
}

TEST(UpdateJson, OmittedKeysHaveTheMessagesDefaults) {
  const auto put = parse_update(R"({"put_node": {"node": -1}})");
  ASSERT_TRUE(put) << put.error().message;
  EXPECT_EQ(std::get<PutNode>(*put).mask, 0xffffffff);
  EXPECT_EQ(std::get<PutNode>(*put).parent_from_local, kIdentity);
  EXPECT_EQ(std::get<PutNode>(*put).mobility, Mobility::kStatic);
}

TEST(UpdateJson, AcceptsTheMessagesOwnForms) {
  const auto put = parse_update(
      std::string(R"({"put_node": {"node": 4, "mobility": "MOBILITY_DEFORMING", "transform": )") +
      R"({"matrix": )" + kMoved + "}}}");
  ASSERT_TRUE(put) << put.error().message;
  EXPECT_EQ(std::get<PutNode>(*put).mobility, Mobility::kDeforming);
  EXPECT_EQ(std::get<PutNode>(*put).parent_from_local[3], 4);
}

TEST(UpdateJson, NamesTheKeyThatIsWrong) {
  EXPECT_EQ(error_of("{\"put_node\""), "is no JSON, from byte 12 on");
  EXPECT_NE(error_of("[]").find("is not one of put_node"), std::string::npos);
  EXPECT_NE(error_of(R"({"fly": {}})").find("fly is not one of put_node"), std::string::npos);
  EXPECT_EQ(error_of(R"({"put_node": 3})"), "put_node is no object");
  EXPECT_EQ(error_of(R"({"put_node": {}})"), "put_node.node is missing");
  EXPECT_EQ(error_of(R"({"put_node": {"node": -1, "colour": 3}})"), "put_node.colour is not known");
  EXPECT_NE(error_of(R"({"put_node": {"node": 1.5}})").find("put_node.node is not a whole number"),
            std::string::npos);
  EXPECT_EQ(error_of(R"({"put_node": {"node": 1, "name": 2}})"), "put_node.name is no string");
  EXPECT_NE(error_of(R"({"put_node": {"node": 1, "mask": -1}})").find("put_node.mask"),
            std::string::npos);
  EXPECT_NE(error_of(R"({"put_node": {"node": 1, "mask": 4294967296}})").find("put_node.mask"),
            std::string::npos);
  EXPECT_EQ(error_of(R"({"put_node": {"node": 1, "mobility": "fast"}})"),
            "put_node.mobility is 'fast', not static, rigid or deforming");
  EXPECT_EQ(error_of(R"({"put_node": {"node": 1, "transform": [1, 2]}})"),
            "put_node.transform is not 12 or 16 numbers");
  EXPECT_EQ(error_of(R"({"set_transforms": {"nodes": [1], "matrices": []}})"),
            "set_transforms has 1 nodes but 0 matrices");
  EXPECT_EQ(error_of(R"({"set_transforms": {"nodes": [1], "matrices": [[1]]}})"),
            "set_transforms.matrices row 0 is not 12 or 16 numbers");
  EXPECT_EQ(error_of(R"({"set_transforms": {"nodes": ["a"], "matrices": []}})"),
            "set_transforms has 1 nodes but 0 matrices");
  EXPECT_EQ(error_of(R"({"patch_vertices": {"nodes": ["a"], "positions": []}})"),
            "patch_vertices.nodes holds what is no node");
  EXPECT_EQ(error_of(R"({"patch_vertices": {"nodes": [1], "positions": [[1, 2]]}})"),
            "patch_vertices.positions row 0 is not 3 numbers");
  EXPECT_EQ(error_of(R"({"delete_node": {"node": 1, "subtree": 1}})"),
            "delete_node.subtree is not true or false");
}

TEST(UpdateJson, WrittenUpdatesCanBeRead) {
  PutNode put;
  put.node = 5;
  put.name = "x";
  put.parent_from_local[3] = 0.1;
  const std::vector<Update> updates{put, SetTransforms{{1}, {put.parent_from_local}},
                                    PatchVertices{{2}, 3, {{0.1F, 2, 3}}}, DeleteNode{4, true}};
  for (const Update& update : updates) {
    const Json json = json_of(update, true);
    const auto back = parse_update(json.dump());
    ASSERT_TRUE(back) << back.error().message;
    EXPECT_EQ(json_of(*back, true), json);
  }
  EXPECT_EQ(json_of(updates[2], false)["patch_vertices"]["vertices"], 1);
}

}  // namespace
}  // namespace sightline::client::cli::files
