// What cuts may add, and who may.
#include "accel/split/reference_budget.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "accel/kdtree/epoch.h"
#include "accel/mesh/mesh_tree.h"
#include "accel/published/any_builder.h"
#include "tests/support/hard_meshes.h"
#include "tests/support/scenes.h"

namespace sightline::accel::split {
namespace {

const geometry::Aabb kCell{{0, 0, 0}, {2, 1, 1}};
const kdtree::Cut kCut{.plane = {0, 0.5f}};

TEST(ReferenceBudget, IsSharedByAreaAndLength) {
  const geometry::HalvedCell halves = halve(kCell, 0, 0.5f);
  const HalvedPath below = halve_path({.depth = 3, .spare = 100}, kCut, halves, 50, 20, 40);
  // 10 were added. Half areas are 2 and 4.
  EXPECT_DOUBLE_EQ(below.left.spare, 90 * (2.0 * 20) / (2.0 * 20 + 4.0 * 40));
  EXPECT_DOUBLE_EQ(below.left.spare + below.right.spare, 90);
  EXPECT_EQ(below.left.depth, 4);
  EXPECT_DOUBLE_EQ(below.left.swell, 1.2);
}

TEST(ReferenceBudget, IsSmallBelowACutThatSeparatesNothing) {
  const kdtree::CellPath path{.spare = 5000};
  EXPECT_EQ(cap_below_useless_cut(path, 100, 100, 40).spare, 300);
  EXPECT_EQ(cap_below_useless_cut(path, 100, 40, 100).spare, 300);
  EXPECT_EQ(cap_below_useless_cut({.spare = 200}, 100, 100, 100).spare, 200);
}

TEST(ReferenceBudget, IsNotCappedBelowAnyOtherCut) {
  const kdtree::CellPath path{.spare = 5000};
  EXPECT_EQ(cap_below_useless_cut(path, 100, 99, 40), path);
  EXPECT_EQ(cap_below_useless_cut(path, 100, 100, 39), path);
  EXPECT_EQ(cap_below_useless_cut(path, 64, 64, 64), path);
  EXPECT_EQ(cap_below_useless_cut({}, 100, 100, 100), kdtree::CellPath{}) << "no budget";
}

TEST(ReferenceBudget, ACellIsSwollenByItsSwellAndItsLength) {
  EXPECT_TRUE(is_swollen({.swell = 3}, 64));
  EXPECT_FALSE(is_swollen({.swell = 3}, 63));
  EXPECT_FALSE(is_swollen({.swell = 1.9}, 100000));
}

TEST(ReferenceBudget, ACutMayAddWhatIsLeftAndNoMore) {
  EXPECT_TRUE(affords({.spare = 9, .swell = 5}, 9));
  EXPECT_FALSE(affords({.spare = 9, .swell = 5}, 10));
  EXPECT_TRUE(affords({}, 1000000));
}

TEST(ReferenceBudget, IsNeverOverdrawnNorEverGrows) {
  const geometry::HalvedCell halves = halve(kCell, 0, 0.5f);
  const HalvedPath over = halve_path({.spare = 5}, kCut, halves, 50, 50, 50);
  EXPECT_EQ(over.left.spare + over.right.spare, 0);
  const HalvedPath fewer = halve_path({.spare = 5}, kCut, halves, 50, 20, 20);
  EXPECT_EQ(fewer.left.spare + fewer.right.spare, 5);
  const HalvedPath flat = halve_path({.spare = 5}, kCut, {{{0, 0, 0}, {0, 0, 0}}, {}}, 50, 0, 0);
  EXPECT_EQ(flat.left.spare + flat.right.spare, 5);
}

TEST(ReferenceBudget, IsInfiniteUnlessSet) {
  const HalvedPath below = halve_path({}, kCut, halve(kCell, 0, 0.5f), 50, 50, 50);
  EXPECT_EQ(below.left.spare, std::numeric_limits<double>::infinity());
  EXPECT_EQ(below.right.spare, std::numeric_limits<double>::infinity());
}

kdtree::TreeMetrics built(std::string_view family, const published::AnyBuilder& builder) {
  const tests::TestMesh mesh = tests::find_hard_mesh(family)->make(2000, 1);
  mesh::MeshTree tree(mesh.view(), mesh::survey_mesh(mesh.view()), builder,
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
        published::AnyBuilder builder = *published::make_builder(name);
        ASSERT_TRUE(published::set_parameter(builder, "clip", "on"));
        ASSERT_TRUE(published::set_parameter(builder, "budget", text));
        const kdtree::TreeMetrics m = built(family, builder);
        EXPECT_EQ(m.unbuilt_cells, 0u) << family << name;
        EXPECT_LE(static_cast<double>(m.references), most * 2000) << family << name;
      }
    }
  }
}

TEST(ReferenceBudget, IsLessForTrianglesThatMeetInAVertexWhereThereIsOne) {
  published::AnyBuilder builder = *published::make_builder("sah-sort");
  EXPECT_GT(built("fan", builder).references, 20u * 2000) << "the papers' builders have none";
  builder = *published::make_builder("scan-fast");
  EXPECT_LT(built("fan", builder).references, 4u * 2000);
  ASSERT_TRUE(published::set_parameter(builder, "budget", "0"));
  EXPECT_GT(built("fan", builder).references, 20u * 2000);
}

}  // namespace
}  // namespace sightline::accel::split
