// What the server derives from a batch of updates: node ids, and bytes that the old revision does
// not share.
#pragma once

#include <cstdint>
#include <vector>

#include "proto/result.h"
#include "scenegraph/model/update.h"
#include "scenegraph/revision/snapshot.h"

namespace sightline::server::scenes {

/// Replaces every node reference by its id. `put`: the ids of the PutNodes, in order. Meshes are
/// released; their digests stay.
void resolve(std::vector<scenegraph::model::Update>& updates,
             const std::vector<scenegraph::model::NodeId>& put);

/// Bytes of vertices of the meshes that one batch may patch. Whole meshes count.
inline constexpr std::uint64_t kMaxDeformedBytes = std::uint64_t{1} << 30;

/// What a batch takes from the memory account.
struct Needed {
  std::uint64_t meshes = 0;  ///< Bytes of the meshes that its patches make.
  std::uint64_t read = 0;    ///< Bytes of meshes that its patches need and that are not resident.
  std::uint64_t nodes = 0;   ///< Bytes of the nodes that it puts.
  std::uint64_t log = 0;     ///< Bytes of the updates; 0 if they only delete.

  std::uint64_t bytes() const { return meshes + read + nodes + log; }
};

/// What `updates` need. A mesh counts again for each patch whose nodes differ from those of the
/// patch before. Errors: kResourceExhausted if the meshes need more than kMaxDeformedBytes, naming
/// the limit.
Result<Needed> needed_by(const scenegraph::revision::Snapshot& before,
                         const std::vector<scenegraph::model::Update>& updates);

/// About how many bytes of `before` the next revision does not share: nodes, patched vertices and
/// their trees, but not the scene's trees. Cost: proportional to the change.
struct Replaced {
  std::uint64_t bytes = 0;
  std::uint64_t meshes = 0;  ///< Bytes of these that are patched meshes and their trees.
  std::uint64_t names = 0;   ///< Bytes of names, digests and labels of nodes put again or deleted.
};
Replaced bytes_replaced(const scenegraph::revision::Snapshot& before,
                        const std::vector<scenegraph::model::Update>& updates);

/// About the bytes of the scene's trees that `before` has and `after` has not.
std::uint64_t bytes_of_replaced_trees(const scenegraph::revision::Snapshot& before,
                                      const scenegraph::revision::Snapshot& after);

/// About the bytes of `nodes` nodes that a revision alone has.
std::uint64_t bytes_of_replaced(std::uint64_t nodes);
/// About the bytes of `nodes` nodes without their names, digests and labels.
std::uint64_t bytes_of_nodes(std::uint64_t nodes);
/// About the bytes of a scene of `nodes` nodes whose names, digests and labels have `names`
/// bytes.
std::uint64_t bytes_of_scene(std::uint64_t nodes, std::uint64_t names);
/// Bytes of the name, the digest and the labels of a node or of a PutNode.
template <class Named>
std::uint64_t bytes_of_texts(const Named& node) {
  return node.name.size() + node.mesh_digest.size() +
         scenegraph::model::bytes_of_labels(node.labels);
}
/// Bytes of the names, digests and labels that the updates put.
std::uint64_t bytes_of_names(const std::vector<scenegraph::model::Update>& updates);

/// About the bytes of the instances that rays have opened, and of the tree over them.
std::uint64_t bytes_of(const scenegraph::instances::SceneTree& tree);
/// About the bytes of all these trees.
std::uint64_t bytes_of(const scenegraph::instances::SceneTrees& trees);

}  // namespace sightline::server::scenes
