// Grows subtrees of up to split::kSmallList references, which are most cells of a build. A set of
// references is a byte, and no lists are written.
#pragma once

#include <cstddef>
#include <span>

#include "accel/grow/grow.h"
#include "accel/split/exhaustive_split.h"

namespace sightline::accel::grow {

/// Whether a list is short enough, and every reference has weight 1.
bool is_small(std::span<const kdtree::Reference> refs);

/// Makes the same splits as choose_bound for every cell, and counts the same touches. For rules
/// that use `rule` for all lists up to this length, and do not clip. The references below and above
/// every bound are found once for the small subtree; the weights of a cell's sides are then counts
/// of common bits, without a pass over its list. Otherwise as grow().
kdtree::Slot grow_small(const GrowContext& context, const split::BoundRule& rule,
                        std::span<const kdtree::Reference> refs, const geometry::Aabb& cell,
                        const kdtree::CellPath& path, kdtree::BuildCounters& counters);

}  // namespace sightline::accel::grow
