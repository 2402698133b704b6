// Growing a subtree from one list of events that is sorted once and kept in order: O(N log N).
// Source: Wald, Havran 2006, section 4.3.
#pragma once

#include <span>

#include "accel/kdtree/slot.h"
#include "accel/published/kd/exact_builder.h"

namespace sightline::accel::grow {
struct GrowContext;
}

namespace sightline::accel::published::kd {

/// The subtree under `cell`, as `grow` of grow.h makes it with the same builder searching by
/// sorting: the same planes, the same references in each leaf (in another order).
///
/// The one list of the paper is ordered by position, then axis; here by axis, then position. No
/// step compares events of different axes, so each reads the axes it needs and no others.
///
/// Touches, per pass over events: half of them, as a box has two ends an axis. In a cell: one pass
/// to sweep; one over the cut's axis to classify; one to splice; the sort of new events; and, where
/// there are new events, one to merge.
///
/// At most Event::kMaxReferences references. Throws std::bad_alloc. Large subtrees become tasks in
/// the caller's arena.
kdtree::Slot grow_by_events(const grow::GrowContext& context, const ExactBuilder& builder,
                            std::span<const kdtree::Reference> refs, const geometry::Aabb& cell,
                            const kdtree::CellPath& path, kdtree::BuildCounters& counters);

}  // namespace sightline::accel::published::kd
