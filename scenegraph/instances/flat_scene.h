// The flat tree over the instances of a scene's tree.
#pragma once

#include <atomic>
#include <memory>

#include "accel/wide/flat_tree.h"

namespace sightline::scenegraph::instances {

class Instances;

/// Makes one tree over the triangles of instances whose meshes have no other instance, or few
/// triangles, as far as these are built. Other instances are entered. Returns null where there are
/// not more blocks of them than in `before`, which may be null, instances were never opened, memory
/// has no room for it, or soon after `cancelled` is true. Parallel in the caller's arena; pinned.
/// Throws std::bad_alloc.
std::unique_ptr<const accel::wide::FlatTree> flatten(const Instances& instances,
                                                     const accel::wide::FlatTree* before,
                                                     const std::atomic<bool>* cancelled);

}  // namespace sightline::scenegraph::instances
