// What all cells of a tree share.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "accel/grow/grow.h"
#include "accel/kdtree/kd_tree.h"
#include "accel/lazy/reference_source.h"
#include "accel/split/split_search.h"
#include "accel/wide/frame.h"

namespace sightline::accel::lazy {

/// A mesh of at most this number of triangles becomes leaf blocks at once.
inline constexpr std::size_t kWholeMesh = 1000;

/// The subtree of a deferred cell of at most this weight is built at once: dividing it cell by cell
/// would cost more work than it defers. In trees with leaf blocks that is grow::kBlockCell.
inline constexpr std::uint64_t kEagerBelow = 64;

/// Immutable apart from `tree`. Threads: any, for all members.
struct TreeContext {
  /// See LazyTree.
  TreeContext(const geometry::Aabb& bounds, std::size_t references, split::SplitRule split_rule,
              ReferenceSource from, const geometry::MeshView* faces_of,
              std::shared_ptr<kdtree::TreeMemory> memory);

  const split::SplitRule rule;
  const std::shared_ptr<const ReferenceSource> source;
  const geometry::MeshView* const mesh;  ///< What the references are faces of; null: others.
  const std::size_t size;                ///< An upper bound on the references when all are opened.
  const int max_depth;
  const wide::Frame frame;  ///< What its wide trees are relative to. Not for empty bounds.
  /// Whether finished cells become leaf blocks: it is over faces, and floats can test them in the
  /// tree's sizes (wide::kLeastSize).
  const bool makes_blocks;
  const bool is_list;  ///< Whether the tree stays the list that it begins as: floats cannot.
  kdtree::KdTree tree;

  /// See split::SplitSearch::budget.
  double budget() const { return rule->budget(makes_blocks); }
  /// Whether the subtree of a cell is built at once.
  bool is_eager(const kdtree::DeferredCell& cell) const;
  /// Whether the source can list the cell again: no cut above has separated anything. Its boxes are
  /// then those before clipping.
  bool holds_all(const kdtree::DeferredCell& cell) const {
    return !cell.openable && cell.size == size;
  }

  /// Whether lists and finished subtrees can become compact lists.
  bool is_evictable() const { return tree.memory() != nullptr && makes_blocks && source->again; }
  /// Whether there is memory to expand a cell that a ray has come to. A long list that is divided
  /// without room leaves compact ones, an eighth of it.
  bool may_grow(const kdtree::DeferredCell& cell) const;
  /// Whether there is memory to build what no ray waits for.
  bool may_build_ahead() const {
    return tree.memory() == nullptr || tree.memory()->may_build_ahead();
  }
  /// Whether these bytes fit in the memory, and some more.
  bool has_capacity_for(std::uint64_t bytes) const {
    const kdtree::TreeMemory* const memory = tree.memory();
    return memory == nullptr || memory->held() + bytes <= memory->low_water();
  }
};

}  // namespace sightline::accel::lazy
