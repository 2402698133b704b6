// Growing the subtree of up to split::kSmallList boxes, where a build spends most of its cells: a
// set of boxes is a byte, and lists are never written.
#pragma once

#include <cstddef>
#include <span>

#include "accel/grow/grow.h"
#include "accel/split/exhaustive_split.h"

namespace sightline::accel::grow {

/// Whether a list is short enough, and every box weighs one.
bool is_small(std::span<const kdtree::Reference> refs);

/// Makes the cuts that choose_bound would make, cell by cell, and counts the same touches; for
/// builders that cut all lists up to this length by the one rule, and do not clip. What lies below
/// or above every bound is found once for the handful; a cell then needs no pass over its list:
/// weights of its sides are counts of common bits. As grow otherwise.
kdtree::Slot grow_small(const GrowContext& context, const split::BoundRule& rule,
                        std::span<const kdtree::Reference> refs, const geometry::Aabb& cell,
                        const kdtree::CellPath& path, kdtree::BuildCounters& counters);

}  // namespace sightline::accel::grow
