// A finished subtree as wide nodes over leaf blocks, in one allocation.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "accel/blocks/hierarchy.h"
#include "accel/geometry/aabb.h"
#include "accel/kdtree/finished_subtree.h"
#include "accel/kdtree/wide_node.h"

namespace sightline::accel::wide {

/// What the leaves of a subtree are.
enum class LeafKind : std::uint8_t { kBlocks, kLists };

/// A finished subtree of wide nodes. It never changes except for its last use. Threads: any.
class WideTree final : public kdtree::FinishedSubtree {
 public:
  /// Compiles a hierarchy of at most kdtree::kMostLevels levels; blocks are relative to `center`.
  /// The largest child is opened until a node is full (Wald et al. 2008). Throws std::bad_alloc.
  WideTree(const blocks::Node& root, const geometry::Vec3f& center,
           LeafKind kind = LeafKind::kBlocks);
  /// Compiles a hierarchy, and keeps the blocks where they are: `words` owns their memory.
  WideTree(const blocks::Node& root, const geometry::Vec3f& center, blocks::Chunks words);

  kdtree::Slot root() const override { return root_; }
  /// Returns the root to a ray that comes from the slot, and counts as a use.
  kdtree::Slot enter() const {
    last_use.use();
    return root_;
  }
  const geometry::Vec3f& center() const { return center_; }
  /// The box of the subtree, in mesh coordinates.
  const geometry::Aabb& box() const { return box_; }

  std::uint64_t size_in_bytes() const override;
  std::vector<std::uint32_t> ids() const override;
  void measure(double root_area, int depth, kdtree::TreeMetrics& metrics) const override;
  void measure_growth(std::vector<bool>& seen, kdtree::GrowthMetrics& growth) const override;

 private:
  struct Free {
    void operator()(std::byte* memory) const;
  };
  WideTree(const blocks::Node& root, const geometry::Vec3f& center, LeafKind kind,
           blocks::Chunks words, bool copies);

  geometry::Vec3f center_;
  geometry::Aabb box_;
  std::size_t node_count_ = 0, bytes_ = 0;
  std::unique_ptr<std::byte, Free> memory_;  ///< The nodes, then leaves that were copied.
  blocks::Chunks words_;                     ///< Blocks that were kept.
  kdtree::Slot root_;
};

}  // namespace sightline::accel::wide
