// Encoding and decoding of updates.
#include "client/wire/scene_codec.h"

#include <gtest/gtest.h>

namespace sightline::client::wire {
namespace {

TEST(UpdateCodec, DecodesWhatItEncodes) {
  PutNode put;
  put.node = -3;
  put.parent = 8;
  put.name = "door";
  put.parent_from_local[3] = 2.5;
  put.mesh_digest = "sha256:00/0";
  put.mobility = Mobility::kDeforming;
  put.mask = 6;
  put.labels = {{"class", "IfcDoor"}, {"fire rating", ""}};
  const auto put_back = decode(encode(put));
  ASSERT_TRUE(put_back);
  const auto& node = std::get<PutNode>(*put_back);
  EXPECT_EQ(node.node, -3);
  EXPECT_EQ(node.parent, 8);
  EXPECT_EQ(node.name, "door");
  EXPECT_EQ(node.parent_from_local, put.parent_from_local);
  EXPECT_EQ(node.mesh_digest, put.mesh_digest);
  EXPECT_EQ(node.mobility, Mobility::kDeforming);
  EXPECT_EQ(node.mask, 6U);
  EXPECT_EQ(node.labels, put.labels);

  const SetTransforms set{{4, 5}, {kIdentity, put.parent_from_local}};
  const auto set_back = decode(encode(set));
  ASSERT_TRUE(set_back);
  EXPECT_EQ(std::get<SetTransforms>(*set_back).nodes, set.nodes);
  EXPECT_EQ(std::get<SetTransforms>(*set_back).parent_from_local, set.parent_from_local);

  const PatchVertices patch{{4}, 7, {{1, 2, 3}, {4, 5, 6}}};
  const auto patch_back = decode(encode(patch));
  ASSERT_TRUE(patch_back);
  EXPECT_EQ(std::get<PatchVertices>(*patch_back).first, 7U);
  EXPECT_EQ(std::get<PatchVertices>(*patch_back).positions, patch.positions);

  const auto deleted = decode(encode(DeleteNode{9, true}));
  ASSERT_TRUE(deleted);
  EXPECT_TRUE(std::get<DeleteNode>(*deleted).subtree);
}

TEST(NodeCodec, DecodesLabels) {
  v1::Node node;
  v1::Label& label = *node.add_labels();
  label.set_key("class");
  label.set_value("IfcDoor");
  EXPECT_EQ(decode(node).labels, (std::vector<Label>{{"class", "IfcDoor"}}));
}

TEST(UpdateCodec, UnreadableMessagesAreErrors) {
  v1::Update update;
  EXPECT_EQ(decode(update).error().code, Code::kInternal);
  update.mutable_patch_vertices()->set_positions("12345");
  EXPECT_EQ(decode(update).error().code, Code::kInternal);
}

TEST(UpdateCodec, AliasesOfEarlierMessagesBecomeIds) {
  NodeAliases aliases;
  aliases.add(-1, 42);
  const v1::Update update = encode(PatchVertices{{-1, -2, 3}, 0, {}}, aliases);
  EXPECT_EQ(update.patch_vertices().nodes(0), 42);
  EXPECT_EQ(update.patch_vertices().nodes(1), -2);
  EXPECT_EQ(update.patch_vertices().nodes(2), 3);
}

}  // namespace
}  // namespace sightline::client::wire
