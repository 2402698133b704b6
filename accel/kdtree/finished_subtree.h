// A subtree that is built down to its leaves.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "accel/kdtree/epoch.h"
#include "accel/kdtree/last_use.h"
#include "accel/kdtree/slot.h"

namespace sightline::accel::kdtree {

struct TreeMetrics;
struct GrowthMetrics;
struct ListBytes;

/// A finished subtree belongs to the tree whose slot leads to it (KdTree::finish). It never changes
/// except for its last use. Threads: any.
class alignas(16) FinishedSubtree : public Retirable {
 public:
  FinishedSubtree() = default;
  virtual ~FinishedSubtree() = default;
  FinishedSubtree(const FinishedSubtree&) = delete;
  FinishedSubtree& operator=(const FinishedSubtree&) = delete;

  /// The root of the subtree: a node, a block or a list.
  virtual Slot root() const = 0;

  /// All memory that the subtree takes, in bytes.
  virtual std::uint64_t size_in_bytes() const = 0;

  /// The ids of its references; some several times. Throws std::bad_alloc.
  virtual std::vector<std::uint32_t> ids() const = 0;

  /// The last use by a ray that entered it.
  LastUse last_use;
  /// The bytes of its tree.
  std::shared_ptr<ListBytes> account;

  /// Adds its nodes and leaves. `root_area`: half the area of the tree's bounds; `depth`: that of
  /// its slot.
  virtual void measure(double root_area, int depth, TreeMetrics& metrics) const = 0;

  /// Adds its nodes and leaves, and sets `seen` for its references.
  virtual void measure_growth(std::vector<bool>& seen, GrowthMetrics& growth) const = 0;
};

}  // namespace sightline::accel::kdtree
