// A scene in the simplest representation: a map of nodes, copied for every revision. Apart from the
// update types it shares no code with the scene graph that it checks.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "scenegraph/model/update.h"
#include "tests/support/brute_force.h"

namespace sightline::tests {

struct PlainNode {
  scenegraph::model::NodeId parent = 0;
  scenegraph::model::Affine parent_from_local;
  std::shared_ptr<const scenegraph::model::Mesh> mesh;  ///< The mesh as it was put; null: a group.
  std::string mesh_digest;
  /// The current vertices if they were patched; null: those of the mesh.
  std::shared_ptr<const std::vector<accel::geometry::Vec3f>> vertices;
  scenegraph::model::Mobility mobility = scenegraph::model::Mobility::kStatic;
  std::uint32_t mask = accel::geometry::kAllMasks;

  accel::geometry::MeshView view() const;
  bool same_mesh(const PlainNode& other) const {
    return mesh == other.mesh && vertices == other.vertices;
  }
};

class PlainScene {
 public:
  using Nodes = std::map<scenegraph::model::NodeId, PlainNode>;

  const Nodes& nodes() const { return nodes_; }
  std::uint64_t revision() const { return revision_; }
  std::uint64_t triangles() const;
  /// The number of nodes from the root to this node, including both.
  int depth(scenegraph::model::NodeId id) const;
  /// The number of nodes on the longest path down from this node, including it.
  int height(scenegraph::model::NodeId id) const;
  bool is_under(scenegraph::model::NodeId id,
                scenegraph::model::NodeId ancestor) const;  ///< True also for the node itself.
  std::vector<scenegraph::model::NodeId> children(scenegraph::model::NodeId id) const;
  scenegraph::model::Affine world_from_local(scenegraph::model::NodeId id) const;
  /// Rays can meet what the node has: neither it nor a node above it is flat, nor all together.
  bool is_reached(scenegraph::model::NodeId id) const;

  /// Applies one update of a batch that the scene accepts. New nodes get the ids that a scene
  /// assigns: from 1 upward, in the order of the batch.
  void apply(const scenegraph::model::Update& update);
  /// Ends a batch: makes the next revision.
  void publish();

  /// The id of the referenced node.
  scenegraph::model::NodeId resolve(scenegraph::model::NodeRef ref) const;
  /// How the current batch refers to a node: by its alias if the batch has created it.
  scenegraph::model::NodeRef refer(scenegraph::model::NodeId id) const;
  /// Ids of the PutNodes of the current batch, in order.
  const std::vector<scenegraph::model::NodeId>& put_nodes() const { return put_nodes_; }

  /// Meshes that rays can meet, for the oracle; the arrays belong to this scene.
  std::vector<PlacedMesh> placed() const;
  /// Ascending: the nodes that a query with this root (0: all) and these exclusions does not see.
  std::vector<scenegraph::model::NodeId> hidden(
      scenegraph::model::NodeId root, std::span<const scenegraph::model::NodeId> excluded) const;

 private:
  void put(const scenegraph::model::PutNode& put);
  void patch(const scenegraph::model::PatchVertices& patch);
  void remove(scenegraph::model::NodeId id);

  Nodes nodes_;
  std::uint64_t revision_ = 0;
  scenegraph::model::NodeId next_id_ = 1;
  std::unordered_map<scenegraph::model::NodeRef, scenegraph::model::NodeId> aliases_;
  std::vector<scenegraph::model::NodeId> put_nodes_;
};

}  // namespace sightline::tests
