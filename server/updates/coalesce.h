// Merges several batches of transforms and patches into one that has only the newest values.
#pragma once

#include <cstddef>
#include <deque>
#include <vector>

#include "scenegraph/model/update.h"
#include "server/updates/producer_messages.h"

namespace sightline::server::updates {

/// How many of the first batches can be merged: those that have only SetTransforms and
/// PatchVertices and are valid in any scene. 0 or 1: nothing to merge.
std::size_t count_to_coalesce(const std::deque<UpdateBatch>& batches);

/// One batch with the effect of the first `count` batches in order: the newest transform of each
/// node, and the patches that no later patch of the same nodes covers. The batches are not changed.
std::vector<scenegraph::model::Update> coalesce(const std::deque<UpdateBatch>& batches,
                                                std::size_t count);

}  // namespace sightline::server::updates
