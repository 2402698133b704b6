// Publication: what takes the place of a cell counts once, however many threads made it.
#include "accel/kdtree/kd_tree.h"

#include <gtest/gtest.h>

#include <memory>

#include "tests/accel/boxes.h"

namespace sightline::accel::kdtree {
namespace {

std::unique_ptr<DeferredCell> cell_of(std::size_t references) {
  auto cell = std::make_unique<DeferredCell>();
  cell->list =
      CellList(ReferenceList(std::span<const Reference>(tests::random_boxes(references, 0.1, 1))));
  cell->size = references;
  cell->weight = references;
  return cell;
}

/// A node over two cells, as a thread that divides the root makes it.
Slot node_of(KdTree& tree) {
  WideNode* const node = tree.make_node();
  for (std::size_t i = 0; i < 2; ++i) node->children[i] = tree.defer(cell_of(100 + i)).bits();
  return Slot::node(node);
}

TEST(KdTree, CellsOfTheThreadThatComesSecondNeverCount) {
  const auto memory = std::make_shared<TreeMemory>();
  KdTree tree({{0, 0, 0}, {1, 1, 1}}, 200, {}, memory);
  const std::uint64_t root_alone = tree.deferred_bytes();
  EXPECT_EQ(root_alone, sizeof(DeferredCell));
  const EpochPin pin;
  const Slot root = load(tree.root());
  const Slot first = node_of(tree), second = node_of(tree);
  EXPECT_EQ(tree.deferred_bytes(), root_alone) << "none is published";
  const std::uint64_t unpublished = memory->held(TreeBytes::kGrowing);
  EXPECT_GE(unpublished, 402 * sizeof(Reference));
  EXPECT_TRUE(tree.replace(tree.root(), root, first));
  const std::uint64_t published = tree.deferred_bytes();
  EXPECT_EQ(published, 2 * sizeof(DeferredCell) + 201 * sizeof(Reference));
  EXPECT_FALSE(tree.replace(tree.root(), root, second));
  EXPECT_EQ(load(tree.root()), first);
  EXPECT_EQ(tree.deferred_bytes(), published);
  EXPECT_EQ(memory->held(TreeBytes::kLists), published);
  EXPECT_EQ(memory->held(TreeBytes::kGrowing), 0u);
  EXPECT_EQ(memory->held(TreeBytes::kNodes), sizeof(WideNode));
  EXPECT_GE(tree.bytes_peak(), published + unpublished / 2);
}

TEST(KdTree, MemoryEndsAtNothing) {
  const auto memory = std::make_shared<TreeMemory>();
  {
    KdTree tree({{0, 0, 0}, {1, 1, 1}}, 200, {}, memory);
    const EpochPin pin;
    EXPECT_TRUE(tree.replace(tree.root(), load(tree.root()), node_of(tree)));
    std::unique_ptr<DeferredCell> left_over = cell_of(50);
    left_over->left_over = true;
    AtomicSlot& below = load(tree.root()).node()->slot(0);
    EXPECT_TRUE(tree.replace(below, load(below), tree.defer(std::move(left_over))));
    EXPECT_EQ(tree.left_over_bytes(), sizeof(DeferredCell) + 50 * sizeof(Reference));
    tree.discard(tree.defer(cell_of(10)));
  }
  reclaim();
  EXPECT_EQ(memory->held(), 0u);
}

}  // namespace
}  // namespace sightline::accel::kdtree
