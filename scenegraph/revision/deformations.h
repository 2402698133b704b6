// Meshes whose vertices change in a batch of updates: one new mesh each, however many patches there
// are.
#pragma once

#include <memory>
#include <set>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "accel/result.h"
#include "scenegraph/model/node.h"

namespace sightline::scenegraph {

/// One writer.
class Deformations {
 public:
  /// The nodes, which have just been looked up, are to share a mesh in which vertices from `first`
  /// on stand at `positions`. Errors: kInvalidArgument (no node, a node without a mesh, meshes that
  /// differ, vertices beyond the mesh's).
  Status patch(std::span<const Node* const> nodes, std::uint32_t first,
               std::span<const accel::Vec3f> positions);

  /// The node is deleted, or carries another mesh.
  void forget(NodeId id);

  /// The mesh of each node that was patched.
  Result<std::vector<std::pair<NodeId, std::shared_ptr<const Mesh>>>> make();

 private:
  /// Of these nodes and no others.
  struct Deformation {
    std::set<NodeId> nodes;
    std::shared_ptr<const Mesh> mesh;  // as it was
    std::vector<accel::Vec3f> vertices;
  };

  Result<Deformation*> deformation_of(std::span<const Node* const> nodes);
  std::shared_ptr<Deformation> find(NodeId id) const;

  std::unordered_map<NodeId, std::shared_ptr<Deformation>> by_node_;
};

}  // namespace sightline::scenegraph
