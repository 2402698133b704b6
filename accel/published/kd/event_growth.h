// Grows a tree from one list of events that is sorted once and kept in order: O(N log N).
// Source: Wald, Havran 2006, section 4.3.
#pragma once

#include <span>

#include "accel/published/kd/plain_growth.h"

namespace sightline::accel::published::kd {

/// Grows the tree over references of weight 1. It has the planes, and in each leaf the references
/// (in another order), of the tree that grow_plain() makes with ExactSearch::kSort.
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
PlainNode grow_by_events(const ExactBuilder& builder, const geometry::MeshView& mesh, int max_depth,
                         std::span<const kdtree::Reference> refs, const geometry::Aabb& bounds,
                         const PlainTask& task);

}  // namespace sightline::accel::published::kd
