// What the server derives from a batch of updates: node ids, and bytes that the old revision does
// not share.
#pragma once

#include <cstdint>
#include <vector>

#include "accel/result.h"
#include "scenegraph/model/update.h"
#include "scenegraph/revision/snapshot.h"

namespace sightline::server::scenes {

/// Replaces every node reference by its id. `put`: the ids of the PutNodes, in order. Meshes are
/// released; their digests stay.
void resolve(std::vector<scenegraph::model::Update>& updates,
             const std::vector<scenegraph::model::NodeId>& put);

/// Bytes of vertices of the meshes that one batch may patch. Whole meshes count.
inline constexpr std::uint64_t kMaxDeformedBytes = std::uint64_t{1} << 30;

/// Checks that the meshes which `updates` patch have at most kMaxDeformedBytes of vertices. A mesh
/// counts again for each patch whose nodes differ from those of the patch before. Errors:
/// kResourceExhausted, naming the limit.
Status check_deformed(const scenegraph::revision::Snapshot& before,
                      const std::vector<scenegraph::model::Update>& updates);

/// About how many bytes of `before` the next revision does not share: nodes, patched vertices and
/// their trees, the scene's dynamic tree. `updates` are resolved. Cost: proportional to the change.
std::uint64_t bytes_replaced(const scenegraph::revision::Snapshot& before,
                             const std::vector<scenegraph::model::Update>& updates);

/// About the bytes of the instances that rays have opened, and of the tree over them.
std::uint64_t bytes_of(const scenegraph::instances::SceneTree& tree);

}  // namespace sightline::server::scenes
