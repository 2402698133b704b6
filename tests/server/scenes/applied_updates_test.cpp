// Updates after they were applied.
#include "server/scenes/applied_updates.h"

#include <gtest/gtest.h>

#include "scenegraph/scene.h"
#include "tests/scenegraph/put_node.h"
#include "tests/support/scenes.h"

namespace sightline::server::scenes {
namespace {

using scenegraph::Scene;
using scenegraph::model::DeleteNode;
using scenegraph::model::PatchVertices;
using scenegraph::model::PutNode;
using scenegraph::model::SetTransforms;
using scenegraph::model::Update;

std::shared_ptr<const scenegraph::model::Mesh> sheet(std::uint32_t n) {
  const tests::TestMesh mesh = tests::planar_sheet(n);
  return *scenegraph::model::Mesh::make(mesh.vertices, mesh.faces);
}

TEST(AppliedUpdates, ReferToEveryNodeByItsId) {
  std::vector<Update> updates{tests::put_node(-5, 0, sheet(1)),
                              tests::put_node(-6, -5, nullptr),
                              tests::put_node(7, -6, nullptr),
                              tests::put_node(-6, 0, nullptr),
                              SetTransforms{{-5, 3, -6}, {}},
                              PatchVertices{{-5}, 0, {}},
                              DeleteNode{-6}};
  resolve(updates, {101, 102, 7, 102});
  EXPECT_EQ(std::get<PutNode>(updates[0]).node, 101);
  EXPECT_EQ(std::get<PutNode>(updates[0]).mesh, nullptr) << "its digest names it";
  EXPECT_EQ(std::get<PutNode>(updates[1]).node, 102);
  EXPECT_EQ(std::get<PutNode>(updates[1]).parent, 101);
  EXPECT_EQ(std::get<PutNode>(updates[2]).node, 7);
  EXPECT_EQ(std::get<PutNode>(updates[2]).parent, 102);
  EXPECT_EQ(std::get<PutNode>(updates[3]).node, 102);
  EXPECT_EQ(std::get<SetTransforms>(updates[4]).nodes,
            (std::vector<scenegraph::model::NodeRef>{101, 3, 102}));
  EXPECT_EQ(std::get<PatchVertices>(updates[5]).nodes.front(), 101);
  EXPECT_EQ(std::get<DeleteNode>(updates[6]).node, 102);
}

TEST(AppliedUpdates, CountLabelsThatAreReplaced) {
  Scene scene;
  PutNode labelled = tests::put_node(-1, 0, nullptr);
  labelled.labels = std::make_shared<const std::vector<scenegraph::model::Label>>(
      std::vector<scenegraph::model::Label>{{"class", "IfcWindow"}});
  const std::uint64_t bytes = scenegraph::model::bytes_of_labels(labelled.labels);
  EXPECT_EQ(bytes_of_names({labelled}), bytes);
  ASSERT_TRUE(scene.apply({labelled, tests::put_node(-2, 0, nullptr)}));
  const Replaced with = bytes_replaced(*scene.snapshot(), {DeleteNode{1}});
  const Replaced without = bytes_replaced(*scene.snapshot(), {DeleteNode{2}});
  EXPECT_EQ(with.names - without.names, bytes);
  EXPECT_EQ(with.bytes - without.bytes, bytes) << "the earlier revision keeps them";
}

/// Their sums are recomputed by every update below them.
TEST(AppliedUpdates, CountTheGroupsAboveOnce) {
  Scene scene;
  std::vector<Update> chain;
  for (int i = 1; i <= 1000; ++i) chain.push_back(tests::put_node(-i, 1 - i, nullptr));
  chain.push_back(tests::put_node(-1001, -999, nullptr));
  ASSERT_TRUE(scene.apply(chain));
  const auto bytes_of_moving = [&](const std::vector<scenegraph::model::NodeRef>& nodes) {
    const std::vector<scenegraph::model::Affine> unmoved(nodes.size());
    return bytes_replaced(*scene.snapshot(), {SetTransforms{nodes, unmoved}}).bytes;
  };
  const std::uint64_t groups = 999 * sizeof(scenegraph::hierarchy::NodeSummary);
  EXPECT_GT(bytes_of_moving({1000}), groups);
  EXPECT_LT(bytes_of_moving({1000}), 4 * groups);
  EXPECT_LT(bytes_of_moving({1000, 1001}), bytes_of_moving({1000}) + groups / 10);
  EXPECT_LT(bytes_of_moving({1}), groups / 10);
  EXPECT_GT(bytes_replaced(*scene.snapshot(), {DeleteNode{1001}}).bytes, groups);
}

TEST(AppliedUpdates, CountPatchedVerticesThatWereReplaced) {
  Scene scene;
  ASSERT_TRUE(scene.apply({tests::put_node(-1, 0, nullptr), tests::put_node(-2, -1, sheet(200))}));
  const std::vector<Update> patch{PatchVertices{{2}, 0, {{1, 2, 3}}}};
  const std::vector<Update> removal{DeleteNode{1, true}};
  const std::uint64_t bytes = 201 * 201 * sizeof(accel::geometry::Vec3f);
  EXPECT_LT(bytes_replaced(*scene.snapshot(), patch).bytes, bytes)
      << "the store of blobs holds that mesh";
  ASSERT_TRUE(scene.apply(patch));
  EXPECT_GE(bytes_replaced(*scene.snapshot(), patch).bytes, bytes);
  EXPECT_GE(bytes_replaced(*scene.snapshot(), removal).bytes, bytes);
  EXPECT_LT(bytes_replaced(*scene.snapshot(), removal).bytes, 2 * bytes);
}

/// A patch of few vertices needs a whole mesh, once for nodes that share it.
TEST(AppliedUpdates, NeedWhatTheyMake) {
  Scene scene;
  const auto mesh = sheet(200);
  ASSERT_TRUE(scene.apply({tests::put_node(-1, 0, mesh), tests::put_node(-2, 0, mesh)}));
  const auto needed = [&](const std::vector<Update>& updates) {
    return *needed_by(*scene.snapshot(), updates);
  };
  const std::uint64_t vertices = mesh->view().vertices.size_bytes();
  const PatchVertices first{{1}, 0, {{1, 2, 3}}}, second{{2}, 0, {{1, 2, 3}}};
  EXPECT_GE(needed({first}).meshes, vertices);
  EXPECT_LT(needed({first, first}).meshes, 2 * vertices);
  EXPECT_GE(needed({first, second}).meshes, 2 * vertices);
  PutNode named = tests::put_node(-3, 0, nullptr);
  named.name = std::string(1000, 'n');
  EXPECT_GE(needed({named}).nodes, 1000 + sizeof(scenegraph::model::Node));
  EXPECT_GT(needed({SetTransforms{{1}, {{}}}}).log, 0u);
  EXPECT_EQ(needed({DeleteNode{1}, DeleteNode{2}}).bytes(), 0u) << "deletes are never refused";
}

}  // namespace
}  // namespace sightline::server::scenes
