// Grows subtrees of up to kSmallList references, which are most cells of a build. A set of
// references is a byte, and no lists are written.
#pragma once

#include <span>

#include "accel/published/kd/plain_growth.h"
#include "accel/split/exhaustive_split.h"

namespace sightline::accel::published::kd {

/// Grows the subtree of a cell at that depth, over references of weight 1. It makes the same splits
/// as choose_bound for every cell, and counts the same touches. It serves rules that use `rule` for
/// all lists up to this length, and do not clip. The references below and above every bound are
/// found once for the small subtree; the weights of a cell's sides are then counts of common bits,
/// without a pass over its list.
PlainNode grow_small(const split::BoundRule& rule, int max_depth,
                     std::span<const kdtree::Reference> refs, const geometry::Aabb& cell, int depth,
                     const PlainTask& task);

}  // namespace sightline::accel::published::kd
