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

/// Whether a cancelled build has left the lists of its path, which take the room of others.
bool lists_are_left_over(const TreeContext& context);

/// Builds the first such list, from left to right as the cancelled build would have gone on: one,
/// so that a caller who is pinned can renew its pin and free it. False: there is none, or it is
/// being built, or it does not come before that slot. Throws as complete().
bool build_left_over(TreeContext& context, const kdtree::AtomicSlot* before,
                     kdtree::BuildCounters& counters, const std::atomic<bool>* cancelled);

}  // namespace sightline::accel::lazy
