// Eager growth: from one cell's list to its finished subtree.
#pragma once

#include <atomic>
#include <cstdint>

#include "accel/geometry/triangle_mesh.h"
#include "accel/kdtree/kd_tree.h"
#include "accel/split/split_search.h"
#include "accel/wide/frame.h"

namespace sightline::accel::grow {

/// The input of grow() that does not change from cell to cell.
struct GrowContext {
  kdtree::KdTree& tree;
  const split::SplitSearch& rule;
  const geometry::MeshView* mesh = nullptr;  ///< What the references are faces of; null: others.
  const wide::Frame& frame;                  ///< Of the tree.
  int max_depth = 0;
  /// Once true, cells of kForkFrom references or more that are not begun stay deferred.
  const std::atomic<bool>* cancelled = nullptr;
};

/// Counts bytes of lists as held by a tree while it grows (KdTree::add_growing). Threads: one.
class GrowingBytes {
 public:
  explicit GrowingBytes(kdtree::KdTree& tree, std::uint64_t bytes = 0) : tree_(tree) {
    reach(bytes);
  }
  ~GrowingBytes() { tree_.add_growing(-static_cast<std::int64_t>(bytes_)); }
  GrowingBytes(const GrowingBytes&) = delete;
  GrowingBytes& operator=(const GrowingBytes&) = delete;

  /// Counts at least `bytes`, in whole pages.
  void reach(std::uint64_t bytes) {
    constexpr std::uint64_t kPage = 4096;
    if (bytes <= bytes_) return;
    const std::uint64_t pages = (bytes + kPage - 1) / kPage * kPage;
    tree_.add_growing(static_cast<std::int64_t>(pages - bytes_));
    bytes_ = pages;
  }
  void shrink(std::uint64_t bytes) {
    if (bytes >= bytes_) return;
    tree_.add_growing(static_cast<std::int64_t>(bytes) - static_cast<std::int64_t>(bytes_));
    bytes_ = bytes;
  }
  std::uint64_t bytes() const { return bytes_; }

 private:
  kdtree::KdTree& tree_;
  std::uint64_t bytes_ = 0;
};

/// Depth at which no cell of a tree over this many references is split: 8 + 1.3 log2 n is the depth
/// of a good tree (Havran 2000), the rest allows for splits that cut off empty space.
int depth_limit(std::size_t references);

/// Grows the subtree under `cell` and returns its slot, which is not published yet. `list` is
/// overwritten: a left child's list replaces its parent's, a right child's is on a stack (Hunt et
/// al. 2006, section 6.3.1). It counts as held by the tree, and is freed before the subtree is
/// compiled. Large subtrees are tasks in the caller's arena. Throws std::bad_alloc.
kdtree::Slot grow(const GrowContext& context, kdtree::ReferenceList list,
                  const geometry::Aabb& cell, const kdtree::CellPath& path,
                  kdtree::BuildCounters& counters);

}  // namespace sightline::accel::grow
