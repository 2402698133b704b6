// Updates of a scene. A batch of updates is applied completely or not at all, and makes one
// revision.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "scenegraph/model/node.h"

namespace sightline::scenegraph::model {

/// In a batch, a node is named by its id (> 0) or, if an earlier PutNode of the same batch made it,
/// by the negative alias that PutNode gave it. 0 means "no node" where that is allowed.
using NodeRef = std::int64_t;

/// Creates a node (`node` is a fresh negative alias) or replaces all fields of an existing one
/// (`node` is its id, or an alias of the same batch), its parent included. Its children stay.
struct PutNode {
  NodeRef node = 0;
  NodeRef parent = 0;  ///< 0 for a root.
  std::string name;
  Labels labels;
  Affine parent_from_local;
  std::shared_ptr<const Mesh> mesh;
  std::string mesh_digest;
  Mobility mobility = Mobility::kStatic;
  std::uint32_t mask = accel::geometry::kAllMasks;
};

/// New local transforms for many nodes at once.
struct SetTransforms {
  std::vector<NodeRef> nodes;
  std::vector<Affine> parent_from_local;  ///< One for each of the nodes.
};

/// Deletes a node, with all nodes below it if `subtree` is set. Errors: kFailedPrecondition if the
/// node has children and `subtree` is not set.
struct DeleteNode {
  NodeRef node = 0;
  bool subtree = false;
};

/// New positions for `positions.size()` vertices from `first` on. The nodes must have one and the
/// same mesh, and share the new one, whose faces are the same. Other nodes that have the old one
/// keep it.
struct PatchVertices {
  std::vector<NodeRef> nodes;
  std::uint32_t first = 0;
  std::vector<accel::geometry::Vec3f> positions;  ///< New positions in the mesh's frame.
};

using Update = std::variant<PutNode, SetTransforms, DeleteNode, PatchVertices>;

}  // namespace sightline::scenegraph::model
