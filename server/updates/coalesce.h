// Several batches of poses made one, where only the newest count.
#pragma once

#include <cstddef>
#include <deque>
#include <vector>

#include "scenegraph/model/update.h"
#include "server/updates/update_batches.h"

namespace sightline::server::updates {

/// How many of the first batches may be made one: those of nothing but SetTransforms and
/// PatchVertices, that can be told to be sound without the scene. 0 or 1: nothing to gain.
std::size_t count_to_coalesce(const std::deque<UpdateBatch>& batches);

/// What the first `count` batches come to, applied one after the other: of each node the newest
/// transform, and of the patches those that no later one of the same nodes covers. The batches stay
/// as they are.
std::vector<scenegraph::model::Update> coalesce(const std::deque<UpdateBatch>& batches,
                                                std::size_t count);

}  // namespace sightline::server::updates
