// Expanding all of a tree, or all below a slot.
#pragma once

#include <atomic>

#include "accel/kdtree/kd_tree.h"
#include "accel/lazy/tree_context.h"

namespace sightline::accel::lazy {

/// Expands all cells at and below a slot, until `cancelled` or where memory is short. Returns when
/// they are built, but for those that rays have claimed. Parallel in the caller's arena. The caller
/// is not pinned: a pin would keep the lists of all cells alive. Throws std::bad_alloc.
void complete(TreeContext& context, kdtree::AtomicSlot& slot, kdtree::BuildCounters& counters,
              const std::atomic<bool>* cancelled);

/// Whether cells wait with long lists that a cancelled build left. Their bytes count towards
/// most_list_bytes(), so they keep other cells from being divided.
bool lists_are_left_over(const TreeContext& context);

/// Builds the subtree of one such cell: the first before the slot `before`, or of all if that is
/// null, in the order in which the cancelled build would have come to them. It skips cells that
/// other threads are building. It builds only one, so that a pinned caller can renew its pin, which
/// lets the cell's list be freed, before it calls again. Returns whether the cell's slot has
/// changed; false, too, if there is no such cell, memory is short or `cancelled` is set. Throws
/// what complete() throws.
bool build_left_over(TreeContext& context, const kdtree::AtomicSlot* before,
                     kdtree::BuildCounters& counters, const std::atomic<bool>* cancelled);

}  // namespace sightline::accel::lazy
