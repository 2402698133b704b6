// Patches of vertices: alone, together, and in any order with other updates.
#include "scenegraph/revision/deformations.h"

#include <gtest/gtest.h>

#include <limits>

#include "scenegraph/scene.h"
#include "scenegraph/trace.h"
#include "tests/scenegraph/put_node.h"

namespace sightline::scenegraph::revision {
namespace {

using accel::geometry::Vec3f;

std::shared_ptr<const model::Mesh> triangle() {
  return *model::Mesh::make({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}});
}

std::vector<model::Update> put(model::NodeRef alias,
                               const std::shared_ptr<const model::Mesh>& mesh) {
  return {tests::put_node(alias, 0, mesh)};
}

double height(const Scene& scene, model::NodeId node) {
  return static_cast<double>(scene.snapshot()->find(node)->mesh->view().vertices[0].z);
}

Status patch(Scene& scene, std::vector<model::NodeRef> nodes, std::uint32_t first,
             std::vector<Vec3f> positions) {
  const auto applied =
      scene.apply({model::PatchVertices{std::move(nodes), first, std::move(positions)}});
  return applied ? Status() : Status(applied.error());
}

TEST(Deformations, MoveVerticesAndNothingElse) {
  Scene scene;
  ASSERT_TRUE(scene.apply(put(-1, triangle())));
  const auto before = scene.snapshot();
  ASSERT_TRUE(patch(scene, {1}, 1, {{2, 0, 5}}));
  const model::Node& node = *scene.snapshot()->find(1);
  EXPECT_TRUE(node.patched);
  EXPECT_EQ(node.mesh_digest, "digest");
  EXPECT_EQ(node.mesh->view().vertices[0], (Vec3f{0, 0, 0}));
  EXPECT_EQ(node.mesh->view().vertices[1], (Vec3f{2, 0, 5}));
  EXPECT_EQ(node.mesh->view().faces.data(), before->find(1)->mesh->view().faces.data());
  EXPECT_EQ(before->find(1)->mesh->view().vertices[1], (Vec3f{1, 0, 0}));
  EXPECT_FALSE(before->find(1)->patched);
}

TEST(Deformations, AreSharedByNodesPatchedTogether) {
  Scene scene;
  const auto mesh = triangle();
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(scene.apply(put(-1, mesh)));
  ASSERT_TRUE(patch(scene, {1, 2}, 0, {{0, 0, 1}}));
  const auto snapshot = scene.snapshot();
  EXPECT_EQ(snapshot->find(1)->mesh, snapshot->find(2)->mesh);
  EXPECT_EQ(height(scene, 1), 1);
  EXPECT_EQ(snapshot->find(3)->mesh, mesh);
  // In one batch: first together, then one alone, which does not change the other.
  ASSERT_TRUE(scene.apply({model::PatchVertices{{1, 2}, 0, {{0, 0, 2}}},
                           model::PatchVertices{{2}, 0, {{0, 0, 3}}},
                           model::PatchVertices{{1}, 1, {{1, 1, 1}}}}));
  EXPECT_EQ(height(scene, 1), 2);
  EXPECT_EQ(height(scene, 2), 3);
  EXPECT_EQ(scene.snapshot()->find(2)->mesh->view().vertices[1], (Vec3f{1, 0, 0}));
}

TEST(Deformations, EndWhenANodeIsPutAgainOrDeleted) {
  Scene scene;
  const auto mesh = triangle();
  ASSERT_TRUE(scene.apply(put(-1, mesh)));
  ASSERT_TRUE(scene.apply({model::PatchVertices{{1}, 0, {{0, 0, 2}}}, put(1, mesh)[0]}));
  EXPECT_EQ(scene.snapshot()->find(1)->mesh, mesh);
  EXPECT_FALSE(scene.snapshot()->find(1)->patched);
  ASSERT_TRUE(scene.apply({model::PatchVertices{{1}, 0, {{0, 0, 2}}}, model::DeleteNode{1}}));
  EXPECT_EQ(scene.snapshot()->find(1), nullptr);
}

TEST(Deformations, OfUnknownNodesAreRefused) {
  Scene scene;
  ASSERT_TRUE(scene.apply(put(-1, triangle())));
  ASSERT_TRUE(scene.apply(put(-1, triangle())));
  ASSERT_TRUE(scene.apply(put(-1, nullptr)));
  const std::uint64_t revision = scene.snapshot()->revision();
  EXPECT_EQ(patch(scene, {}, 0, {}).error().reason, "NO_NODES");
  EXPECT_EQ(patch(scene, {9}, 0, {}).error().reason, "NODE_NOT_FOUND");
  EXPECT_EQ(patch(scene, {3}, 0, {}).error().reason, "NODE_WITHOUT_MESH");
  EXPECT_EQ(patch(scene, {1, 2}, 0, {}).error().reason, "MESHES_DIFFER");
  EXPECT_EQ(patch(scene, {1}, 3, {{}}).error().reason, "VERTICES_OUT_OF_RANGE");
  EXPECT_EQ(patch(scene, {1}, 0xffffffff, {{}}).error().reason, "VERTICES_OUT_OF_RANGE");
  EXPECT_EQ(patch(scene, {1}, 0, {{}, {}, {}, {}}).error().reason, "VERTICES_OUT_OF_RANGE");
  EXPECT_EQ(scene.snapshot()->revision(), revision);
  EXPECT_TRUE(patch(scene, {1}, 3, {}));
}

/// Every new mesh is charged before it is made, once, and its charge ends with it.
TEST(Deformations, AreChargedForEachNewMesh) {
  Scene scene;
  ASSERT_TRUE(scene.apply(put(-1, triangle())));
  ASSERT_TRUE(scene.apply(put(-1, scene.snapshot()->find(1)->mesh)));
  std::uint64_t charged = 0;
  std::vector<std::weak_ptr<const void>> charges;
  const model::ChargeBytes charge =
      [&](std::uint64_t bytes) -> Result<std::shared_ptr<const void>> {
    if (charges.size() == 2) return Error{Code::kResourceExhausted, "full", "MEMORY_BUDGET"};
    charged += bytes;
    auto made = std::make_shared<const int>(0);
    charges.push_back(made);
    return std::shared_ptr<const void>(made);
  };
  const auto patches = [](std::vector<model::NodeRef> nodes) {
    return model::PatchVertices{std::move(nodes), 0, {{0, 0, 1}}};
  };
  ASSERT_TRUE(scene.apply({patches({1}), patches({1}), patches({2})}, {.charge = charge}));
  ASSERT_EQ(charges.size(), 2u) << "patches of one node make one mesh";
  EXPECT_GE(charged, 2 * 3 * sizeof(Vec3f));
  EXPECT_FALSE(charges[0].expired());

  const auto refused = scene.apply({patches({1})}, {.charge = charge});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Code::kResourceExhausted);
  EXPECT_EQ(scene.snapshot()->revision(), 3u);

  ASSERT_TRUE(scene.apply({model::DeleteNode{1, false}}));
  EXPECT_TRUE(charges[0].expired());
  EXPECT_FALSE(charges[1].expired());
}

TEST(Deformations, MayBeNonFiniteForAWhile) {
  Scene scene;
  ASSERT_TRUE(scene.apply(put(-1, triangle())));
  const accel::geometry::Ray ray{{0.2, 0.2, 9}, {0, 0, -1}};
  accel::geometry::Hit hit;
  ASSERT_TRUE(trace(*scene.snapshot(), {&ray, 1}, {&hit, 1}, {}));
  EXPECT_EQ(hit.t, 9);
  ASSERT_TRUE(patch(scene, {1}, 0, {{std::numeric_limits<float>::quiet_NaN(), 0, 0}}));
  ASSERT_TRUE(trace(*scene.snapshot(), {&ray, 1}, {&hit, 1}, {}));
  EXPECT_EQ(hit.node, 0u);
  EXPECT_EQ(summarize(*scene.snapshot()).triangles_nonfinite, 1u);
  ASSERT_TRUE(patch(scene, {1}, 0, {{0, 0, 0}}));
  ASSERT_TRUE(trace(*scene.snapshot(), {&ray, 1}, {&hit, 1}, {}));
  EXPECT_EQ(hit.t, 9);
}

}  // namespace
}  // namespace sightline::scenegraph::revision
