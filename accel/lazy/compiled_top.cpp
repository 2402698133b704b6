// The nodes near the root as wide nodes, for packets. The slots remain: the tree grows by them.
#include <algorithm>
#include <memory>

#include "accel/blocks/hierarchy.h"
#include "accel/kdtree/epoch.h"
#include "accel/lazy/lazy_tree.h"
#include "accel/wide/wide_tree.h"

namespace sightline::accel::lazy {
namespace {

using blocks::Node;

/// The hierarchy over what is below the binary nodes: finished subtrees, and slots of all else.
class Top {
 public:
  /// `by_slots`: what is finished is entered by its slot, as it may be evicted.
  Top(const kdtree::KdTree& tree, bool by_slots) : tree_(tree), by_slots_(by_slots) {}

  /// Null: nothing is there.
  const Node* node(kdtree::AtomicSlot& slot, const geometry::Aabb& cell) {
    const kdtree::Slot now = kdtree::load(slot);
    if (now == kdtree::Slot::empty_leaf()) return nullptr;
    if (now.is_finished()) {
      const auto& subtree = static_cast<const wide::WideTree&>(*now.finished());
      return leaf(subtree.box(), by_slots_ ? wide::Child::slot(&slot) : subtree.root());
    }
    if (!now.is_binary()) return leaf(cell, wide::Child::slot(&slot));
    const geometry::HalvedCell halves = geometry::halve(cell, now.axis(), now.position());
    kdtree::AtomicSlot* children = tree_.children(now);
    return join(node(children[0], halves.left), node(children[1], halves.right));
  }

 private:
  const Node* leaf(const geometry::Aabb& box, wide::Child child) {
    Node* made = arena_.node();
    made->box = box;
    made->words = Node::kOther;
    made->other = child.bits();
    return made;
  }

  const Node* join(const Node* left, const Node* right) {
    if (left == nullptr) return right;
    if (right == nullptr) return left;
    return arena_.join(left, right);
  }

  const kdtree::KdTree& tree_;
  const bool by_slots_;
  blocks::Arena arena_;
};

}  // namespace

wide::Child LazyTree::entry() {
  const kdtree::FinishedSubtree* top = tree_.top();
  return top != nullptr ? static_cast<const wide::WideTree*>(top)->root()
                        : wide::Child::slot(&tree_.root());
}

void LazyTree::count_steps(std::uint64_t steps) {
  const std::uint64_t sum = steps_.fetch_add(steps, std::memory_order_relaxed) + steps;
  if (frame_ && sum >= kStepsPerNode * 2 * tree_.pairs()) compile_top();
}

void LazyTree::compile_top() {
  if (!frame_) return;
  if (!kdtree::load(tree_.root()).is_binary()) return;
  if (compiles_top_.exchange(true, std::memory_order_acquire)) return;
  steps_.store(0, std::memory_order_relaxed);
  {
    const kdtree::EpochPin pin;
    Top top(tree_, is_evictable());
    if (const Node* root = top.node(tree_.root(), tree_.bounds()))
      tree_.set_top(std::make_unique<wide::WideTree>(*root, frame_->center));
  }
  compiles_top_.store(false, std::memory_order_release);
}

}  // namespace sightline::accel::lazy
