// A cell that is not built yet: its box, its list, and the work that threads share to build it.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

#include "accel/kdtree/epoch.h"
#include "accel/kdtree/plane_counts.h"
#include "accel/kdtree/reference_list.h"

namespace sightline::accel::kdtree {

/// Work that threads join. The thread that leaves last frees it. See accel/lazy/cell_task.h.
class SharedWork {
 public:
  void join() { users_.fetch_add(1, std::memory_order_relaxed); }
  void leave() {
    if (users_.fetch_sub(1, std::memory_order_acq_rel) == 1) delete this;
  }

 protected:
  SharedWork() = default;
  virtual ~SharedWork() = default;

 private:
  std::atomic<int> users_{1};
};

/// Immutable except for the atomics, until it is retired. Readers are pinned to an epoch.
struct alignas(8) DeferredCell : Retirable {
  DeferredCell() = default;
  DeferredCell(const DeferredCell&) = delete;
  DeferredCell& operator=(const DeferredCell&) = delete;
  ~DeferredCell() {
    if (SharedWork* work = task.load(std::memory_order_acquire)) work->leave();
  }

  geometry::Aabb box;
  CellPath path;
  /// Whether `list` is made. The root's list is made from the geometry when the root is expanded;
  /// until then readers search all of the geometry.
  bool has_list = true;
  /// Some references of the list may be openable.
  bool openable = false;
  CellList list;
  std::size_t size = 0;      ///< References in the cell, also if the list is not made.
  std::uint64_t weight = 0;  ///< Sum over all references.
  ChildScan first;  ///< Counts of the first pass, if they were made when the list was written.
  /// Expanding failed because there was no memory: the cell stays deferred, and rays search its
  /// list.
  std::atomic<bool> failed{false};
  /// Set once a thread has begun to expand a large cell.
  std::atomic<SharedWork*> task{nullptr};

  std::uint64_t size_in_bytes() const { return sizeof(DeferredCell) + list.bytes(); }
};

}  // namespace sightline::accel::kdtree
