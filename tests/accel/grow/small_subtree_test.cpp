// Small subtrees against cutting cell by cell, on every SIMD target of this machine.
#include "accel/grow/small_subtree.h"

#include <gtest/gtest.h>

#include <new>
#include <string>
#include <vector>

#include "accel/split/scan_split.h"
#include "tests/accel/boxes.h"
#include "tests/accel/simd_targets.h"

namespace sightline::accel::grow {
namespace {

using SmallGrowth = tests::OnSimdTarget;

/// Walks the tree and computes every cut again with the split rule.
class Recut {
 public:
  Recut(const kdtree::KdTree& tree, const split::BoundRule& rule, int max_depth)
      : tree_(tree), rule_(rule), max_depth_(max_depth) {}

  void expect(kdtree::Slot slot, const std::vector<kdtree::Reference>& refs,
              const geometry::Aabb& cell, int depth) {
    std::optional<kdtree::Split> cut;
    if (!refs.empty() && depth < max_depth_) cut = choose_bound(refs, cell, rule_, counters);
    std::vector<kdtree::Reference> left, right;
    if (cut) {
      const auto a = static_cast<std::size_t>(cut->plane.axis);
      for (const kdtree::Reference& r : refs) {
        if (r.lo[a] < cut->plane.position) left.push_back(r);
        if (r.hi[a] > cut->plane.position) right.push_back(r);
      }
      counters.touches += refs.size();
    }
    if (!cut || (left.size() == refs.size() && right.size() == refs.size()))
      return expect_leaf(slot, refs);
    ASSERT_TRUE(slot.is_binary());
    ASSERT_EQ(slot.axis(), cut->plane.axis);
    ASSERT_EQ(slot.position(), cut->plane.position);
    const geometry::HalvedCell halves = halve(cell, cut->plane.axis, cut->plane.position);
    expect(kdtree::load(tree_.children(slot)[0]), left, halves.left, depth + 1);
    expect(kdtree::load(tree_.children(slot)[1]), right, halves.right, depth + 1);
  }

  kdtree::BuildCounters counters;

 private:
  void expect_leaf(kdtree::Slot slot, const std::vector<kdtree::Reference>& refs) {
    ASSERT_TRUE(slot.is_leaf());
    ASSERT_EQ(slot.leaf_count(), refs.size());
    std::uint32_t storage;
    const auto ids = tree_.leaf(slot, storage);
    for (std::size_t i = 0; i < refs.size(); ++i) ASSERT_EQ(ids[i], refs[i].id);
  }

  const kdtree::KdTree& tree_;
  const split::BoundRule& rule_;
  int max_depth_;
};

void expect_same(const std::vector<kdtree::Reference>& refs, const geometry::Aabb& cell,
                 int max_depth = 20) {
  const split::SplitSearch& unused = *split::default_rule();
  for (const split::BoundRule& rule :
       {split::BoundRule{}, split::BoundRule{.cost = {}, .all_axes_up_to = 0},
        split::BoundRule{.cost = {}, .all_axes_up_to = 0, .retry_above = 0.85},
        split::BoundRule{.cost = {}, .all_axes_up_to = 4}, split::BoundRule{.cost = {0, 1, 1}},
        split::BoundRule{.cost = {1, 50, 0.8}}}) {
    kdtree::KdTree tree(cell, refs.size());
    tree.reserve();
    kdtree::BuildCounters counters;
    const kdtree::Slot root = grow_small({.tree = tree, .rule = unused, .max_depth = max_depth},
                                         rule, refs, cell, {}, counters);
    Recut recut(tree, rule, max_depth);
    recut.expect(root, refs, cell, 0);
    ASSERT_EQ(counters.touches, recut.counters.touches);
  }
}

TEST_P(SmallGrowth, MakesTheCutsOfTheRule) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const auto refs =
        tests::random_boxes(1 + seed % split::kSmallList, seed % 2 == 0 ? 0.1 : 0.6, seed);
    expect_same(refs, tests::bounds_of(refs));
    expect_same(refs, {{0.2f, 0.3f, 0.1f}, {0.8f, 0.7f, 0.9f}});  // straddlers
  }
}

TEST_P(SmallGrowth, ResolvesTiesTheSameWay) {
  for (std::uint64_t seed = 0; seed < 200; ++seed)
    expect_same(tests::lattice_boxes(1 + seed % split::kSmallList, 1, seed),
                {{0, 0, 0}, {5, 5, 5}});
}

TEST_P(SmallGrowth, StopsAtTheDepthLimit) {
  const auto refs = tests::random_boxes(split::kSmallList, 0.1, 7);
  for (const int limit : {0, 1, 2, 3}) expect_same(refs, tests::bounds_of(refs), limit);
}

TEST_P(SmallGrowth, DefersCellsBeyondTheCapacity) {
  const auto refs = tests::random_boxes(split::kSmallList, 0.01, 3);
  const geometry::Aabb cell = tests::bounds_of(refs);
  kdtree::KdTree tree(cell, refs.size());  // Nothing reserved
  const split::SplitRule unbounded = split::make_rule({.budget = 0});
  kdtree::BuildCounters counters;
  const kdtree::Slot root =
      grow_small({.tree = tree, .rule = *unbounded, .max_depth = 20}, {}, refs, cell, {}, counters);
  ASSERT_TRUE(root.is_deferred());
  EXPECT_TRUE(root.cell()->failed);
  EXPECT_EQ(root.cell()->size, refs.size());
  delete root.cell();
}

TEST_P(SmallGrowth, ThrowsBeyondTheCapacityWithABudget) {
  const auto refs = tests::random_boxes(split::kSmallList, 0.01, 3);
  const geometry::Aabb cell = tests::bounds_of(refs);
  kdtree::KdTree tree(cell, refs.size());  // Nothing reserved
  kdtree::BuildCounters counters;
  EXPECT_THROW(grow_small({.tree = tree, .rule = *split::default_rule(), .max_depth = 20}, {}, refs,
                          cell, {}, counters),
               std::bad_alloc);
}

TEST(IsSmall, NeedsFewBoxesOfWeightOne) {
  EXPECT_TRUE(is_small({}));
  EXPECT_TRUE(is_small(tests::random_boxes(split::kSmallList, 0.1, 1)));
  EXPECT_FALSE(is_small(tests::random_boxes(split::kSmallList + 1, 0.1, 1)));
  EXPECT_FALSE(is_small(std::vector{tests::box_ref({0, 0, 0}, {1, 1, 1}, 0, 2)}));
}

INSTANTIATE_TEST_SUITE_P(EveryTarget, SmallGrowth, tests::every_simd_target(),
                         tests::simd_target_name);

}  // namespace
}  // namespace sightline::accel::grow
