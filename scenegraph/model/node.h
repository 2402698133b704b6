// A node of the scene hierarchy, as stored in a revision. Immutable: an edit makes a new one.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

#include "accel/geometry/ray.h"
#include "scenegraph/model/affine.h"
#include "scenegraph/model/labels.h"
#include "scenegraph/model/mesh.h"
#include "scenegraph/model/persistent_list.h"

namespace sightline::scenegraph::model {

/// The id of a node, given by the scene from 1 upward, and never used again within it. 0 means
/// "none".
using NodeId = std::uint64_t;

using ChildList = PersistentList<NodeId>;

/// How a node is expected to change, with all nodes below it. It chooses the tree that the node
/// begins in; a later change may move it to a dynamic tree (see Scene).
enum class Mobility : std::uint8_t { kStatic = 0, kRigid = 1, kDeforming = 2 };

inline constexpr std::size_t kMaxNodeName = 1024;  ///< The most bytes of a name.
inline constexpr int kMaxDepth = 1024;             ///< The most nodes from a root to a leaf.

struct Node {
  NodeId id = 0;
  NodeId parent = 0;  ///< 0 for a root.
  std::string name;   ///< A name for people, which need not be unique.
  Labels labels;
  Affine parent_from_local;
  /// Whether no ray can be transformed by parent_from_local (see inverse()): rays meet neither the
  /// node nor what is below it.
  bool is_flat = false;
  std::shared_ptr<const Mesh> mesh;  ///< The mesh; null for a group.
  std::string mesh_digest;  ///< Names the content of the mesh it was put with; empty without one.
  bool patched = false;     ///< Whether the mesh's vertices have changed since it was put.
  Mobility mobility = Mobility::kStatic;
  std::uint32_t mask = accel::geometry::kAllMasks;
  ChildList children;  ///< The children, in the order in which they came.
  /// Whether rays have entered the mesh; revisions share it. Null without a mesh.
  std::shared_ptr<std::atomic<bool>> entered;

  /// Sets parent_from_local and is_flat.
  void set_transform(const Affine& transform) {
    parent_from_local = transform;
    is_flat = !inverse(transform);
  }
};

/// The node's id and name, for messages.
inline std::string described(const Node& node) {
  return "node " + std::to_string(node.id) + " \"" + node.name + "\"";
}

}  // namespace sightline::scenegraph::model
