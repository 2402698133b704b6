// Growth of a plain kd-tree: from the list of its root to its leaves.
#pragma once

#include <cstddef>
#include <span>

#include "accel/geometry/triangle_mesh.h"
#include "accel/published/kd/plain_cells.h"
#include "accel/published/kd/plain_rule.h"
#include "accel/published/kd/plain_writer.h"

namespace sightline::accel::published::kd {

/// What one task of a build writes to.
struct PlainTask {
  PlainWriter& out;
  kdtree::BuildCounters& counters;
};

/// Depth at which cells of a tree over that many references become leaves.
int depth_limit(const PlainRule& rule, std::size_t references);

/// Grows the tree over references of weight 1, which are overwritten: a left child's list replaces
/// its parent's, a right child's is on a stack (Hunt et al. 2006, section 6.3.1). `mesh` is what
/// straddlers are clipped against. Large subtrees are tasks in the caller's arena; the tree does
/// not depend on the number of threads. Throws std::bad_alloc.
PlainCells grow_plain(const PlainRule& rule, const geometry::MeshView& mesh,
                      std::span<kdtree::Reference> refs, const geometry::Aabb& bounds,
                      kdtree::BuildCounters& counters);

}  // namespace sightline::accel::published::kd
