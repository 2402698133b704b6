// Eviction: the least valuable pieces of many meshes' trees go, until the others fit.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "accel/kdtree/tree_memory.h"
#include "scenegraph/model/mesh.h"

namespace sightline::scenegraph::model {

/// Evicts finished subtrees and lists of the meshes' trees until all trees that count in `memory`
/// hold at most `goal` bytes, or nothing is left to evict. The first to go are those that cost
/// least to build again for each byte, relative to the time since their last use. Memory is freed
/// as batches in flight go on. Hits do not change. Returns the bytes evicted. Throws
/// std::bad_alloc. Threads: any.
std::uint64_t evict(std::span<const std::shared_ptr<const Mesh>> meshes,
                    accel::kdtree::TreeMemory& memory, std::uint64_t goal);

}  // namespace sightline::scenegraph::model
