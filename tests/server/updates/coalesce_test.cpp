// Coalesced batches: the result equals applying them one by one.
#include "server/updates/coalesce.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "scenegraph/scene.h"
#include "tests/scenegraph/put_node.h"
#include "tests/support/scenes.h"

namespace sightline::server::updates {
namespace {

using scenegraph::model::Affine;
using scenegraph::model::DeleteNode;
using scenegraph::model::PatchVertices;
using scenegraph::model::PutNode;
using scenegraph::model::SetTransforms;
using scenegraph::model::Update;

Affine at(double x) { return {{1, 0, 0, x, 0, 1, 0, 0, 0, 0, 1, 0}}; }

UpdateBatch batch(std::vector<Update> updates) {
  UpdateBatch made;
  made.updates = std::move(updates);
  return made;
}

std::deque<UpdateBatch> batches(std::vector<std::vector<Update>> all) {
  std::deque<UpdateBatch> made;
  for (auto& updates : all) made.push_back(batch(std::move(updates)));
  return made;
}

/// Four nodes; two share one mesh, two another.
void fill(scenegraph::Scene& scene) {
  std::vector<Update> updates;
  for (int m = 0; m < 2; ++m) {
    const tests::TestMesh sheet = tests::planar_sheet(4);
    const auto mesh = *scenegraph::model::Mesh::make(sheet.vertices, sheet.faces);
    for (int i = 1; i <= 2; ++i) updates.push_back(tests::put_node(-2 * m - i, 0, mesh));
  }
  ASSERT_TRUE(scene.apply(updates));
}

TEST(Coalesce, CoalescesOnlyPoseBatchesUpToTheFirstOtherBatch) {
  const std::vector<Update> pose{SetTransforms{{1}, {at(1)}}};
  const std::vector<Update> removal{DeleteNode{1}};
  EXPECT_EQ(count_to_coalesce(batches({})), 0u);
  EXPECT_EQ(count_to_coalesce(batches({pose, {}, pose, removal, pose})), 3u);
  EXPECT_EQ(count_to_coalesce(batches({removal, pose})), 0u);
  auto bad = batches({pose, pose});
  bad[1].bad = Error{};
  EXPECT_EQ(count_to_coalesce(bad), 1u);
}

TEST(Coalesce, LeavesOutInvalidUpdates) {
  const std::vector<Update> pose{SetTransforms{{1}, {at(1)}}};
  const std::vector<Update> infinite{
      SetTransforms{{1}, {at(std::numeric_limits<double>::infinity())}}};
  const std::vector<Update> alias{SetTransforms{{-1}, {at(1)}}};
  const std::vector<Update> patch_of_alias{PatchVertices{{-1}, 0, {}}};
  for (const auto& unsound : {infinite, alias, patch_of_alias})
    EXPECT_EQ(count_to_coalesce(batches({pose, unsound, pose})), 1u);
}

TEST(Coalesce, KeepsTheNewestTransformOfEachNode) {
  const auto made = coalesce(batches({{SetTransforms{{1, 2}, {at(1), at(2)}}},
                                      {SetTransforms{{3}, {at(3)}}, SetTransforms{{2}, {at(4)}}},
                                      {SetTransforms{{9}, {at(9)}}}}),
                             2);
  ASSERT_EQ(made.size(), 1u);
  const auto& set = std::get<SetTransforms>(made[0]);
  EXPECT_EQ(set.nodes, (std::vector<scenegraph::model::NodeRef>{1, 2, 3}));
  EXPECT_EQ(set.parent_from_local[1].m[3], 4);
}

TEST(Coalesce, LeavesOutAPatchThatANewerOneCovers) {
  const auto patch = [](std::vector<scenegraph::model::NodeRef> nodes, std::uint32_t first,
                        std::size_t count) {
    return Update(
        PatchVertices{std::move(nodes), first, std::vector<accel::geometry::Vec3f>(count)});
  };
  const auto made = coalesce(batches({{patch({1, 2}, 2, 3), patch({1}, 0, 4), patch({1, 2}, 0, 9)},
                                      {patch({2, 1}, 2, 4)},
                                      {patch({1, 2}, 2, 3)}}),
                             3);
  ASSERT_EQ(made.size(), 4u) << "the first is hidden by the third";
  EXPECT_EQ(std::get<PatchVertices>(made[0]).nodes.size(), 1u);
  EXPECT_EQ(std::get<PatchVertices>(made[1]).positions.size(), 9u);
  EXPECT_EQ(std::get<PatchVertices>(made[2]).positions.size(), 4u);
  EXPECT_EQ(std::get<PatchVertices>(made[3]).positions.size(), 3u);
}

TEST(Coalesce, GivesTheSameResultAsOneByOne) {
  std::mt19937 random(3);
  const auto below = [&](std::uint32_t n) { return static_cast<std::uint32_t>(random() % n); };
  for (int round = 0; round < 300; ++round) {
    scenegraph::Scene one, together;
    fill(one);
    fill(together);
    std::deque<UpdateBatch> made;
    for (std::uint32_t b = 2 + below(6); b > 0; --b) {
      std::vector<Update> updates;
      for (std::uint32_t u = 1 + below(3); u > 0; --u) {
        const auto node = static_cast<scenegraph::model::NodeRef>(1 + below(4));
        if (below(2) == 0) {
          updates.push_back(SetTransforms{{node}, {at(below(100))}});
          continue;
        }
        PatchVertices patch{{node}, below(25), {}};
        if (below(3) == 0) patch.nodes.push_back(((node - 1) ^ 1) + 1);
        patch.positions.resize(below(26 - patch.first));
        for (accel::geometry::Vec3f& p : patch.positions)
          p = {static_cast<float>(random() % 10), 1, 2};
        updates.emplace_back(std::move(patch));
      }
      made.push_back(batch(std::move(updates)));
    }
    bool all_good = true;
    for (const UpdateBatch& b : made) all_good = all_good && one.apply(b.updates);
    const bool good = together.apply(coalesce(made, made.size())).ok();
    if (!all_good) continue;  // Then they are applied one by one
    ASSERT_TRUE(good) << round;
    for (scenegraph::model::NodeId id = 1; id <= 4; ++id) {
      const scenegraph::model::Node &a = *one.snapshot()->find(id),
                                    &b = *together.snapshot()->find(id);
      EXPECT_EQ(a.parent_from_local.m, b.parent_from_local.m);
      const auto va = a.mesh->view().vertices, vb = b.mesh->view().vertices;
      ASSERT_TRUE(std::equal(va.begin(), va.end(), vb.begin(), vb.end(),
                             [](const accel::geometry::Vec3f& p, const accel::geometry::Vec3f& q) {
                               return p.x == q.x && p.y == q.y && p.z == q.z;
                             }))
          << round << " node " << id;
    }
  }
}

}  // namespace
}  // namespace sightline::server::updates
