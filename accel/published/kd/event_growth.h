// Grows a subtree from one list of events that is sorted once and kept in order: O(N log N).
// Source: Wald, Havran 2006, section 4.3.
#pragma once

#include <span>

#include "accel/kdtree/slot.h"
#include "accel/published/kd/exact_builder.h"

namespace sightline::accel::grow {
struct GrowContext;
}

namespace sightline::accel::published::kd {

/// The subtree under `cell`: the same planes, and the same references in each leaf (in another
/// order), as `grow` of grow.h makes with ExactSearch::kSort.
///
/// The list of the paper is ordered by position, then axis; here by axis, then position. No step
/// compares events of different axes, so each step reads only the axes it needs.
///
/// Touches: a pass over events counts half of them, as a box has two ends per axis. For a cell: one
/// pass to sweep; one over the split axis to classify; one to splice; the sort of new events; and
/// one to merge new events, if any.
///
/// At most Event::kMaxReferences references. Throws std::bad_alloc. Large subtrees become tasks in
/// the caller's arena.
kdtree::Slot grow_by_events(const grow::GrowContext& context, const ExactBuilder& builder,
                            std::span<const kdtree::Reference> refs, const geometry::Aabb& cell,
                            const kdtree::CellPath& path, kdtree::BuildCounters& counters);

}  // namespace sightline::accel::published::kd
