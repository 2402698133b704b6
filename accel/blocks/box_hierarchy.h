// A binary hierarchy over boxes.
#pragma once

#include <atomic>
#include <span>
#include <vector>

#include "accel/blocks/hierarchy.h"

namespace sightline::accel::blocks {

/// Joins leaves to one hierarchy by the surface area heuristic, as BlockBuilder divides triangles.
/// Each of `leaves`, which are not empty, is in it once. Makes the nodes above them in `nodes`, at
/// most kMostLevels (block_builder.h) of them above a leaf. Returns the root, which refers to both;
/// null soon after `cancelled` is true. Parallel in the caller's arena. Throws std::bad_alloc.
const Node* join(std::span<const Node> leaves, std::vector<Node>& nodes,
                 const std::atomic<bool>* cancelled = nullptr);

}  // namespace sightline::accel::blocks
