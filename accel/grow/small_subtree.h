// Grows the subtree of at most split::kSmallList boxes, to which most cells of a build belong. A
// set of boxes is a byte, and lists are never written.
#pragma once

#include <cstddef>
#include <span>

#include "accel/grow/grow.h"
#include "accel/split/exhaustive_split.h"

namespace sightline::accel::grow {

/// Whether a list is short enough, and every box weighs one.
bool is_small(std::span<const kdtree::BoxRef> refs);

/// Makes the cuts that choose_bound would make, cell by cell, and counts the same touches; for
/// rules that cut all lists up to this length by `rule` and do not clip. The boxes below and above
/// every bound are found once for the subtree. A cell then needs no pass over its list: the weights
/// of its sides are counts of common bits. Otherwise as grow().
kdtree::Slot grow_small(const GrowContext& context, const split::BoundRule& rule,
                        std::span<const kdtree::BoxRef> refs, const geometry::Aabb& cell,
                        const kdtree::CellPath& path, kdtree::BuildCounters& counters);

}  // namespace sightline::accel::grow
