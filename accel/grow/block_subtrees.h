// Finished cells as leaf blocks, and the hierarchy above them while a subtree grows.
#pragma once

#include <optional>
#include <span>

#include "accel/blocks/block_builder.h"
#include "accel/blocks/hierarchy.h"
#include "accel/grow/grow.h"

namespace sightline::accel::grow {

/// What a cell has become: a slot, or a hierarchy over leaf blocks that is not compiled yet.
struct Grown {
  kdtree::Slot slot = kdtree::Slot::empty_leaf();
  const blocks::Node* node = nullptr;

  bool is_empty() const { return node == nullptr && slot == kdtree::Slot::empty_leaf(); }
};

/// A cell of at most this many references becomes leaf blocks, without further cuts.
inline constexpr std::size_t kBlockCell = 512;

/// The finished cells of one task, in an arena that counts as held by the tree. Threads: one.
class BlockSubtrees {
 public:
  /// The context must have a center.
  explicit BlockSubtrees(const GrowContext& context);

  /// Makes leaf blocks of all references of a cell.
  Grown finish(std::span<const kdtree::Reference> refs, const geometry::Aabb& cell);

  /// The two sides of a cut. Two hierarchies become one; if a side is a slot, or the hierarchy
  /// would be too deep, each becomes a slot of its own. Throws std::bad_alloc.
  Grown join(const kdtree::Plane& cut, const Grown& left, const Grown& right);

  /// Compiles a hierarchy to wide nodes. Throws std::bad_alloc.
  kdtree::Slot compile(const Grown& grown);

  /// As compile(), for all that was finished: a large hierarchy keeps its blocks where they are.
  kdtree::Slot compile_all(const Grown& grown);

  /// Takes over what another task has finished.
  void take_over(BlockSubtrees& other);

 private:
  const GrowContext& context_;
  blocks::BlockBuilder builder_;
  blocks::Arena arena_;
  GrowingBytes held_;
};

}  // namespace sightline::accel::grow
