// Small subtrees against cutting cell by cell, on every SIMD target of this machine.
#include "accel/published/kd/small_subtree.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/accel/boxes.h"
#include "tests/accel/simd_targets.h"

namespace sightline::accel::published::kd {
namespace {

using SmallGrowth = tests::OnSimdTarget;

/// Walks the tree and computes every cut again with the split rule.
class Recut {
 public:
  Recut(const PlainCells& cells, const split::BoundRule& rule, int max_depth)
      : cells_(cells), rule_(rule), max_depth_(max_depth) {}

  void expect(PlainNode node, const std::vector<kdtree::Reference>& refs,
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
      return expect_leaf(node, refs);
    ASSERT_FALSE(node.is_leaf());
    ASSERT_EQ(static_cast<int>(node.axis()), cut->plane.axis);
    ASSERT_EQ(node.position(), cut->plane.position);
    const geometry::HalvedCell halves = halve(cell, cut->plane.axis, cut->plane.position);
    expect(cells_.pairs.at(node.pair())[0], left, halves.left, depth + 1);
    expect(cells_.pairs.at(node.pair())[1], right, halves.right, depth + 1);
  }

  kdtree::BuildCounters counters;

 private:
  void expect_leaf(PlainNode node, const std::vector<kdtree::Reference>& refs) {
    ASSERT_TRUE(node.is_leaf());
    ASSERT_FALSE(node.is_failed());
    ASSERT_EQ(node.count(), refs.size());
    std::uint32_t storage;
    const auto ids = cells_.leaf(node, storage);
    for (std::size_t i = 0; i < refs.size(); ++i) ASSERT_EQ(ids[i], refs[i].id);
  }

  const PlainCells& cells_;
  const split::BoundRule& rule_;
  int max_depth_;
};

PlainCells grown(const split::BoundRule& rule, const std::vector<kdtree::Reference>& refs,
                 const geometry::Aabb& cell, int max_depth, PlainCapacity& capacity,
                 kdtree::BuildCounters& counters) {
  PlainWriter out(capacity);
  return out.finish(grow_small(rule, max_depth, refs, cell, 0, {out, counters}));
}

void expect_same(const std::vector<kdtree::Reference>& refs, const geometry::Aabb& cell,
                 int max_depth = 20) {
  for (const split::BoundRule& rule :
       {split::BoundRule{}, split::BoundRule{.cost = {}, .all_axes_up_to = 0},
        split::BoundRule{.cost = {}, .all_axes_up_to = 0, .retry_above = 0.85},
        split::BoundRule{.cost = {}, .all_axes_up_to = 4}, split::BoundRule{.cost = {0, 1, 1}},
        split::BoundRule{.cost = {1, 50, 0.8}}}) {
    PlainCapacity capacity(0, refs.size());
    kdtree::BuildCounters counters;
    const PlainCells cells = grown(rule, refs, cell, max_depth, capacity, counters);
    Recut recut(cells, rule, max_depth);
    recut.expect(cells.root, refs, cell, 0);
    ASSERT_EQ(counters.touches, recut.counters.touches);
  }
}

TEST_P(SmallGrowth, MakesTheCutsOfTheRule) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const auto refs = tests::random_boxes(1 + seed % kSmallList, seed % 2 == 0 ? 0.1 : 0.6, seed);
    expect_same(refs, kdtree::bounds_of(refs));
    expect_same(refs, {{0.2f, 0.3f, 0.1f}, {0.8f, 0.7f, 0.9f}});  // straddlers
  }
}

TEST_P(SmallGrowth, ResolvesTiesTheSameWay) {
  for (std::uint64_t seed = 0; seed < 200; ++seed)
    expect_same(tests::lattice_boxes(1 + seed % kSmallList, 1, seed), {{0, 0, 0}, {5, 5, 5}});
}

TEST_P(SmallGrowth, StopsAtTheDepthLimit) {
  const auto refs = tests::random_boxes(kSmallList, 0.1, 7);
  for (const int limit : {0, 1, 2, 3}) expect_same(refs, kdtree::bounds_of(refs), limit);
}

TEST_P(SmallGrowth, FailsAtTheCapacity) {
  const auto refs = tests::random_boxes(kSmallList, 0.01, 3);
  PlainCapacity capacity(0, 0);
  while (capacity.take_pair()) continue;
  kdtree::BuildCounters counters;
  const PlainCells cells = grown({}, refs, kdtree::bounds_of(refs), 20, capacity, counters);
  ASSERT_TRUE(cells.root.is_failed());
  ASSERT_EQ(cells.failed_leaf(cells.root).size(), refs.size());
  for (std::size_t i = 0; i < refs.size(); ++i)
    EXPECT_EQ(cells.failed_leaf(cells.root)[i].bounds(), refs[i].bounds());
}

INSTANTIATE_TEST_SUITE_P(EveryTarget, SmallGrowth, tests::every_simd_target(),
                         tests::simd_target_name);

}  // namespace
}  // namespace sightline::accel::published::kd
