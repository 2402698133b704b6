// Trees that rays have grown to their end have the leaves of full trees.
#include "accel/lazy/lazy_tree.h"

#include <gtest/gtest.h>

#include "accel/kdtree/epoch.h"
#include "accel/kdtree/tree_metrics.h"
#include "accel/split/scan_split.h"
#include "tests/accel/boxes.h"

namespace sightline::accel::lazy {
namespace {

/// Expands all cells below the slot, one by one.
void touch_all(LazyTree& tree, kdtree::AtomicSlot& slot) {
  kdtree::BuildCounters counters;
  while (kdtree::load(slot).is_deferred())
    ASSERT_EQ(tree.expand(slot, WhenPending::kWait, counters), ExpandResult::kRetry);
  const kdtree::Slot now = kdtree::load(slot);
  if (!now.is_node()) return;
  for (std::size_t i = 0; i < kdtree::kWidth; ++i) touch_all(tree, now.node()->slot(i));
}

// As a scene's tree: no mesh.
TEST(LazyTree, CellByCellHasTheLeavesOfATreeThatIsBuiltAtOnce) {
  const std::vector<kdtree::Reference> refs = tests::random_boxes(3000, 0.03, 5);
  const auto make = [&] {
    return std::make_unique<LazyTree>(tests::bounds_of(refs), refs.size(), split::default_rule(),
                                      source_of(refs));
  };
  const auto full = make(), grown = make();
  kdtree::BuildCounters counters;
  full->expand_all(counters);
  const kdtree::EpochPin pin;
  touch_all(*grown, grown->root());
  const kdtree::TreeMetrics a = measure(full->tree()), b = measure(grown->tree());
  EXPECT_GT(a.leaves, 500u);
  EXPECT_EQ(a.leaves, b.leaves);
  EXPECT_EQ(a.references, b.references);
  EXPECT_DOUBLE_EQ(a.expected_intersections, b.expected_intersections);
  EXPECT_EQ(b.deferred_cells, 0u);
}

}  // namespace
}  // namespace sightline::accel::lazy
