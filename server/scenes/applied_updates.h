// A batch of updates after it was applied: nodes by their ids, and what it did away with.
#pragma once

#include <cstdint>
#include <vector>

#include "accel/result.h"
#include "scenegraph/model/update.h"
#include "scenegraph/revision/snapshot.h"

namespace sightline::server::scenes {

/// Names every node by its id; `put` are those of the PutNodes, in order. Meshes are let go of:
/// their digests name them.
void resolve(std::vector<scenegraph::model::Update>& updates,
             const std::vector<scenegraph::model::NodeId>& put);

/// Vertices that one batch may make anew, whole meshes counted.
inline constexpr std::uint64_t kMaxDeformedBytes = std::uint64_t{1} << 30;

/// Of updates that are to be applied to this revision: whether the meshes that they patch are not
/// too large together. A mesh counts again where patches of it name other nodes than the one
/// before. Errors: kResourceExhausted, naming the limit.
Status check_deformed(const scenegraph::revision::Snapshot& before,
                      const std::vector<scenegraph::model::Update>& updates);

/// About how many bytes of the revision before these (resolved) updates the next one does not
/// share: nodes, vertices that were patched and their trees, the scene's dynamic tree. Cost: by
/// what was changed.
std::uint64_t bytes_replaced(const scenegraph::revision::Snapshot& before,
                             const std::vector<scenegraph::model::Update>& updates);

/// About what the instances that rays have placed take, and the tree over them.
std::uint64_t bytes_of(const scenegraph::instances::SceneTree& tree);

}  // namespace sightline::server::scenes
