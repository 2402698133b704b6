// What cuts may add, and who may.
#include "accel/grow/reference_budget.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <vector>

#include "accel/kdtree/epoch.h"
#include "accel/lazy/lazy_tree.h"
#include "accel/mesh/mesh_tree.h"
#include "accel/published/any_builder.h"
#include "tests/support/hard_meshes.h"
#include "tests/support/scenes.h"

namespace sightline::accel::grow {
namespace {

const geometry::Aabb kCell{{0, 0, 0}, {2, 1, 1}};
const kdtree::Split kCut{.plane = {0, 0.5f}};

TEST(ReferenceBudget, IsSharedByAreaAndLength) {
  const geometry::HalvedCell halves = halve(kCell, 0, 0.5f);
  const HalvedPath below =
      halve_path({.depth = 3, .references_left = 100}, kCut, halves, 50, {20, 40}, {20, 40});
  // 10 were added. Half areas are 2 and 4.
  EXPECT_DOUBLE_EQ(below.left.references_left, 90 * (2.0 * 20) / (2.0 * 20 + 4.0 * 40));
  EXPECT_DOUBLE_EQ(below.left.references_left + below.right.references_left, 90);
  EXPECT_EQ(below.left.depth, 4);
  EXPECT_DOUBLE_EQ(below.left.duplication, 1.2);
}

TEST(ReferenceBudget, IsSmallBelowACutThatSeparatesNothing) {
  const kdtree::CellPath path{.references_left = 5000};
  EXPECT_EQ(cap_below_useless_cut(path, 100, 100, 40).references_left, 300);
  EXPECT_EQ(cap_below_useless_cut(path, 100, 40, 100).references_left, 300);
  EXPECT_EQ(cap_below_useless_cut({.references_left = 200}, 100, 100, 100).references_left, 200);
}

TEST(ReferenceBudget, IsNotCappedBelowAnyOtherCut) {
  const kdtree::CellPath path{.references_left = 5000};
  EXPECT_EQ(cap_below_useless_cut(path, 100, 99, 40), path);
  EXPECT_EQ(cap_below_useless_cut(path, 100, 100, 39), path);
  EXPECT_EQ(cap_below_useless_cut(path, 64, 64, 64), path);
  EXPECT_EQ(cap_below_useless_cut({}, 100, 100, 100), kdtree::CellPath{}) << "no budget";
}

TEST(ReferenceBudget, ACutMayAddWhatIsLeftAndNoMore) {
  EXPECT_TRUE(within_budget({.references_left = 9, .duplication = 5}, 100, 9));
  EXPECT_FALSE(within_budget({.references_left = 9, .duplication = 5}, 100, 10));
  EXPECT_TRUE(within_budget({}, 1000000, 1000000));
}

TEST(ReferenceBudget, TheListsOfACutMayFillTheCapacityAndNoMore) {
  const kdtree::CellPath path{.references_left = 1000, .list_capacity = 150};
  EXPECT_TRUE(within_budget(path, 100, 50));
  EXPECT_FALSE(within_budget(path, 100, 51));
}

TEST(ReferenceBudget, TheListsOfSiblingsFillTheCapacity) {
  const geometry::HalvedCell halves = halve(kCell, 0, 0.5f);
  const kdtree::CellPath root = root_path(16, 50);
  EXPECT_EQ(root.references_left, 15 * 50);
  EXPECT_EQ(root.list_capacity, kListCapacity * 50);
  const HalvedPath below = halve_path(root, kCut, halves, 50, {20, 40}, {20, 40});
  EXPECT_EQ(below.left.list_capacity, root.list_capacity - 40);
  EXPECT_EQ(below.right.list_capacity, root.list_capacity - 20);
  EXPECT_EQ(root_path(0, 50), kdtree::CellPath{}) << "no budget";
}

TEST(ReferenceBudget, IsNeverExceededAndNeverGrows) {
  const geometry::HalvedCell halves = halve(kCell, 0, 0.5f);
  const HalvedPath over = halve_path({.references_left = 5}, kCut, halves, 50, {50, 50}, {50, 50});
  EXPECT_EQ(over.left.references_left + over.right.references_left, 0);
  const HalvedPath fewer = halve_path({.references_left = 5}, kCut, halves, 50, {20, 20}, {20, 20});
  EXPECT_EQ(fewer.left.references_left + fewer.right.references_left, 5);
  const HalvedPath flat =
      halve_path({.references_left = 5}, kCut, {{{0, 0, 0}, {0, 0, 0}}, {}}, 50, {}, {});
  EXPECT_EQ(flat.left.references_left + flat.right.references_left, 5);
}

TEST(ReferenceBudget, IsSharedByAnyNumberOfChildrenAsByTwo) {
  const kdtree::CellPath parent{.references_left = 1000, .duplication = 2};
  std::array<kdtree::CellPath, 3> paths;
  const std::vector<ChildCell> children{{{{0, 0, 0}, {1, 1, 1}}, 40, 40, &paths[0]},
                                        {{{1, 0, 0}, {2, 1, 1}}, 60, 60, &paths[1]},
                                        {{{0, 1, 0}, {2, 2, 1}}, 50, 50, &paths[2]}};
  share_budget(parent, 100, children);
  // 50 were added. Half areas are 3, 3 and 5.
  const double demands = 3 * 40 + 3 * 60 + 5 * 50;
  EXPECT_DOUBLE_EQ(paths[0].references_left, 950 * 3 * 40 / demands);
  EXPECT_DOUBLE_EQ(paths[1].references_left, 950 * 3 * 60 / demands);
  EXPECT_DOUBLE_EQ(paths[0].references_left + paths[1].references_left + paths[2].references_left,
                   950);
  for (const kdtree::CellPath& path : paths) EXPECT_DOUBLE_EQ(path.duplication, 3);
}

TEST(ReferenceBudget, IsInfiniteUnlessSet) {
  const HalvedPath below = halve_path({}, kCut, halve(kCell, 0, 0.5f), 50, {50, 50}, {50, 50});
  EXPECT_EQ(below.left.references_left, std::numeric_limits<double>::infinity());
  EXPECT_EQ(below.right.references_left, std::numeric_limits<double>::infinity());
}

kdtree::TreeMetrics built(std::string_view family, const published::AnyBuilder& builder) {
  const tests::TestMesh mesh = tests::find_hard_mesh(family)->make(2000, 1);
  mesh::MeshTree tree(mesh.view(), mesh::compute_mesh_stats(mesh.view()), builder,
                      mesh::References::kSoup);
  kdtree::BuildCounters counters;
  tree.expand_all(counters);
  const kdtree::EpochPin pin;
  return tree.metrics();
}

TEST(ReferenceBudget, IsKeptByTrees) {
  for (const std::string_view family : {"slivers", "fan", "rods", "stacks"}) {
    for (const std::string_view name : {"scan-fast", "scan-best"}) {
      for (const auto& [text, most] : {std::pair("2", 2.0), {"8", 8.0}}) {
        for (const std::string_view blocks : {"on", "off"}) {
          published::AnyBuilder builder = *published::make_builder(name);
          ASSERT_TRUE(published::set_parameter(builder, "clip", "on"));
          ASSERT_TRUE(published::set_parameter(builder, "budget", text));
          ASSERT_TRUE(published::set_parameter(builder, "blocks", blocks));
          const kdtree::TreeMetrics m = built(family, builder);
          EXPECT_EQ(m.deferred_cells, 0u) << family << name;
          EXPECT_LE(static_cast<double>(m.references), most * 2000) << family << name;
        }
      }
    }
  }
}

TEST(ReferenceBudget, IsSmallerForFansIfItIsSet) {
  published::AnyBuilder builder = *published::make_builder("sah-sort");
  EXPECT_GT(built("fan", builder).references, 20u * 2000) << "the papers' builders have none";
  builder = *published::make_builder("scan-fast");
  ASSERT_TRUE(published::set_parameter(builder, "blocks", "off"));
  EXPECT_LT(built("fan", builder).references, 4u * 2000);
  ASSERT_TRUE(published::set_parameter(builder, "budget", "0"));
  EXPECT_GT(built("fan", builder).references, 20u * 2000);
}

TEST(ReferenceBudget, IsSmallAboveLeafBlocksUnlessItIsSet) {
  published::AnyBuilder builder = *published::make_builder("scan-fast");
  const auto references = [&] { return static_cast<double>(built("fan", builder).references); };
  EXPECT_LE(references(), split::kBlockBudget * 2000);
  ASSERT_TRUE(published::set_parameter(builder, "budget", "0"));
  EXPECT_LE(references(), split::kBlockBudget * 2000);
  ASSERT_TRUE(published::set_parameter(builder, "budget", "8"));
  EXPECT_GT(references(), split::kBlockBudget * 2000);
  EXPECT_LE(references(), 8.0 * 2000);
}

}  // namespace
}  // namespace sightline::accel::grow
