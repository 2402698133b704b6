// The leaves' boxes, and the nodes that the recursion makes over them.
#include "accel/blocks/box_hierarchy.h"

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <numeric>

#include <tbb/parallel_invoke.h>

#include "accel/blocks/block_builder.h"
#include "accel/blocks/workspace.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "accel/blocks/box_hierarchy.cpp"
#include <hwy/foreach_target.h>
// foreach_target.h comes before highway.h.
#include <hwy/highway.h>

#include "accel/blocks/growth-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::blocks {
namespace HWY_NAMESPACE {

/// Sets of this many leaves or more are divided in parallel.
constexpr std::size_t kForkFrom = 2048;

/// Joins leaves that are there already.
class JoinPolicy {
 public:
  JoinPolicy(std::span<const Node> leaves, std::span<Node> nodes,
             const std::atomic<bool>* cancelled)
      : leaves_(leaves), nodes_(nodes), cancelled_(cancelled) {}

  static void begin(const std::uint32_t*, std::size_t) {}
  static bool pays(const OrderSplit&, std::size_t) { return false; }

  template <class Box>
  const Node* leaf(const std::uint32_t* indices, std::size_t, const Box&) const {
    return &leaves_[indices[0]];
  }

  const Node* join(std::size_t at, const Node* left, const Node* right) const {
    if (left == nullptr || right == nullptr) return nullptr;
    nodes_[at] = inner_node(left, right);
    return &nodes_[at];
  }

  template <class Left, class Right>
  void grow_both(std::size_t count, const Left& left, const Right& right) const {
    if (cancelled_ != nullptr && cancelled_->load(std::memory_order_relaxed)) return;
    if (count >= kForkFrom) return tbb::parallel_invoke(left, right);
    left();
    right();
  }

 private:
  std::span<const Node> leaves_;
  std::span<Node> nodes_;
  const std::atomic<bool>* cancelled_;
};

const Node* join_boxes(Workspace& work, std::span<const Node> leaves, std::span<Node> nodes,
                       const std::atomic<bool>* cancelled) {
  JoinPolicy policy(leaves, nodes, cancelled);
  return Growth(work, policy).grow(0, leaves.size(), kMostLevels);
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::blocks
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sightline::accel::blocks {

HWY_EXPORT(join_boxes);

const Node* join(std::span<const Node> leaves, std::vector<Node>& nodes,
                 const std::atomic<bool>* cancelled) {
  assert(!leaves.empty());
  nodes.resize(leaves.size() - 1);
  Workspace work;
  work.resize(leaves.size());
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    const geometry::Aabb& box = leaves[i].box;
    work.boxes[i] = {{-box.lo.x, -box.lo.y, -box.lo.z, 0, box.hi.x, box.hi.y, box.hi.z, 0}};
  }
  std::iota(work.indices.begin(), work.indices.end(), 0u);
  return HWY_DYNAMIC_DISPATCH(join_boxes)(work, leaves, nodes, cancelled);
}

}  // namespace sightline::accel::blocks
#endif  // HWY_ONCE
