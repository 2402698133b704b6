#include "accel/grow/block_subtrees.h"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <new>
#include <utility>

#include "accel/wide/wide_tree.h"

namespace sightline::accel::grow {

BlockSubtrees::BlockSubtrees(const GrowContext& context)
    : context_(context), builder_(*context.mesh, *context.center), held_(context.tree) {}

Grown BlockSubtrees::finish(std::span<const kdtree::Reference> refs, const geometry::Aabb& cell) {
  if (refs.empty()) return {};
  const blocks::Node* node = builder_.build(refs, cell, arena_);
  held_.reach(arena_.bytes());
  return {.node = node};
}

Grown BlockSubtrees::join(const kdtree::Plane& cut, const Grown& left, const Grown& right) {
  if (left.is_empty()) return right;
  if (right.is_empty()) return left;
  if (left.node != nullptr && right.node != nullptr) {
    const std::size_t levels = std::size_t{1} + std::max(left.node->levels, right.node->levels);
    if (levels <= wide::kMostLevels) {
      return {.node = arena_.join(left.node, right.node)};
    }
  }
  context_.tree.reserve();
  const std::optional<std::uint32_t> pair = context_.tree.allocate_pair();
  if (!pair) throw std::bad_alloc();
  const kdtree::Slot slot = kdtree::Slot::binary(cut, *pair);
  kdtree::AtomicSlot* children = context_.tree.children(slot);
  children[0].store(compile(left).bits(), std::memory_order_relaxed);
  children[1].store(compile(right).bits(), std::memory_order_relaxed);
  return {.slot = slot};
}

kdtree::Slot BlockSubtrees::compile(const Grown& grown) {
  if (grown.node == nullptr) return grown.slot;
  return context_.tree.finish(std::make_unique<wide::WideTree>(*grown.node, *context_.center));
}

kdtree::Slot BlockSubtrees::compile_all(const Grown& grown) {
  // Copies of smaller hierarchies take no space that is not used.
  constexpr std::size_t kLarge = std::size_t{1} << 14;
  if (grown.node == nullptr || arena_.bytes_of_words() < kLarge) return compile(grown);
  const std::size_t kept = arena_.bytes_of_words();
  auto tree = std::make_unique<wide::WideTree>(*grown.node, *context_.center, arena_.take_words());
  held_.shrink(held_.bytes() - std::min<std::uint64_t>(kept, held_.bytes()));
  return context_.tree.finish(std::move(tree));
}

void BlockSubtrees::take_over(BlockSubtrees& other) {
  arena_.append(std::move(other.arena_));
  other.held_.shrink(0);
  held_.reach(arena_.bytes());
}

}  // namespace sightline::accel::grow
