// A node of the scene hierarchy, as stored in a revision. Immutable: an edit makes a new one.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

#include "accel/geometry/ray.h"
#include "scenegraph/model/affine.h"
#include "scenegraph/model/mesh.h"
#include "scenegraph/model/persistent_list.h"

namespace sightline::scenegraph::model {

/// Given by the scene, from 1 upward, never used again within a scene. 0 means "none".
using NodeId = std::uint64_t;

using ChildList = PersistentList<NodeId>;

/// How a node is expected to change, with all nodes below it. Chooses the tree that the node begins
/// in; later changes may move it to the other tree (see Scene).
enum class Mobility : std::uint8_t { kStatic = 0, kRigid = 1, kDeforming = 2 };

inline constexpr std::size_t kMaxNodeName = 1024;  ///< Bytes.
inline constexpr int kMaxDepth = 1024;             ///< Nodes from a root to a leaf.

struct Node {
  NodeId id = 0;
  NodeId parent = 0;  ///< 0: a root.
  std::string name;   ///< For people; need not be unique.
  Affine parent_from_local;
  /// No ray can be carried through parent_from_local (see inverse()): rays meet neither the node
  /// nor what is below it.
  bool is_flat = false;
  std::shared_ptr<const Mesh> mesh;  ///< Null: a group.
  std::string mesh_digest;  ///< Names the content of the mesh it was put with; empty without one.
  bool patched = false;     ///< The mesh's vertices have been changed since.
  Mobility mobility = Mobility::kStatic;
  std::uint32_t mask = accel::geometry::kAllMasks;
  ChildList children;  ///< In the order in which they came.
  /// Set once rays have entered the mesh; carried over from revision to revision. Null without a
  /// mesh.
  std::shared_ptr<std::atomic<bool>> entered;

  /// Sets parent_from_local and is_flat.
  void set_transform(const Affine& transform) {
    parent_from_local = transform;
    is_flat = !inverse(transform);
  }
};

/// For messages.
inline std::string described(const Node& node) {
  return "node " + std::to_string(node.id) + " \"" + node.name + "\"";
}

}  // namespace sightline::scenegraph::model
