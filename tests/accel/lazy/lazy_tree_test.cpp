// Trees that rays have grown to their end have the leaves of full trees.
#include "accel/lazy/lazy_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "accel/kdtree/epoch.h"
#include "accel/kdtree/tree_metrics.h"
#include "accel/split/scan_split.h"
#include "tests/accel/boxes.h"

namespace sightline::accel::lazy {
namespace {

/// Expands all cells below the slot, one by one.
void touch_all(LazyTree& tree, kdtree::AtomicSlot& slot) {
  kdtree::BuildCounters counters;
  while (kdtree::load(slot).is_deferred()) ASSERT_EQ(tree.expand(slot, counters), AtCell::kAdvance);
  const kdtree::Slot now = kdtree::load(slot);
  if (!now.is_node()) return;
  for (std::size_t i = 0; i < kdtree::kWidth; ++i) touch_all(tree, now.node()->slot(i));
}

/// As a scene's tree: over no mesh.
std::unique_ptr<LazyTree> tree_over(const std::vector<kdtree::Reference>& refs) {
  return std::make_unique<LazyTree>(kdtree::bounds_of(refs), refs.size(), split::default_rule(),
                                    source_of(refs));
}

TEST(LazyTree, ADivisionFillsANodeWithTheBoxesOfWhatIsInItsCells) {
  const std::vector<kdtree::Reference> refs = tests::random_boxes(3000, 0.03, 5);
  const auto tree = tree_over(refs);
  const kdtree::EpochPin pin;
  kdtree::BuildCounters counters;
  while (kdtree::load(tree->root()).is_deferred())
    ASSERT_EQ(tree->expand(tree->root(), counters), AtCell::kAdvance);
  const kdtree::Slot root = kdtree::load(tree->root());
  ASSERT_TRUE(root.is_node());
  for (std::size_t i = 0; i < kdtree::kWidth; ++i) {
    ASSERT_TRUE(root.node()->child(i).is_deferred()) << i;
    const kdtree::DeferredCell& cell = *root.node()->child(i).cell();
    geometry::Aabb box;
    cell.list.each_part(0, [&](std::span<const kdtree::Reference> part) {
      for (const kdtree::Reference& ref : part) box.grow(ref.bounds());
    });
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box.lo[axis] = std::max(box.lo[axis], cell.box.lo[axis]);
      box.hi[axis] = std::min(box.hi[axis], cell.box.hi[axis]);
    }
    EXPECT_EQ(root.node()->box(i), in_frame(tree->frame(), box)) << i;
  }
}

TEST(LazyTree, CellByCellHasTheLeavesOfATreeThatIsBuiltAtOnce) {
  const std::vector<kdtree::Reference> refs = tests::random_boxes(3000, 0.03, 5);
  const auto full = tree_over(refs), grown = tree_over(refs);
  kdtree::BuildCounters counters;
  full->expand_all(counters);
  const kdtree::EpochPin pin;
  touch_all(*grown, grown->root());
  const kdtree::TreeMetrics a = measure(full->tree()), b = measure(grown->tree());
  EXPECT_GT(a.leaves, 500u);
  EXPECT_EQ(a.leaves, b.leaves);
  EXPECT_EQ(a.references, b.references);
  EXPECT_NEAR(a.expected_intersections, b.expected_intersections, 1e-9 * a.expected_intersections);
  EXPECT_EQ(b.deferred_cells, 0u);
}

}  // namespace
}  // namespace sightline::accel::lazy
