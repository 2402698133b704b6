// A scene kept in the plainest way: a map of nodes, copied whole for every revision. Shares no code
// with the scene graph that it judges, but for the words in which updates are told.
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
  std::shared_ptr<const scenegraph::model::Mesh> mesh;  ///< As it was put; null: a group.
  std::string mesh_digest;
  /// Where they have been changed since; null: those of the mesh.
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
  /// Nodes from a root to this one, itself included.
  int depth(scenegraph::model::NodeId id) const;
  /// Nodes on the longest way down from this one, itself included.
  int height(scenegraph::model::NodeId id) const;
  bool is_under(scenegraph::model::NodeId id,
                scenegraph::model::NodeId ancestor) const;  ///< Or is it.
  std::vector<scenegraph::model::NodeId> children(scenegraph::model::NodeId id) const;
  scenegraph::model::Affine world_from_local(scenegraph::model::NodeId id) const;

  /// One update of a batch that the scene accepts. New nodes get the ids that a scene gives: from 1
  /// upward, in the order of the batch.
  void apply(const scenegraph::model::Update& update);
  /// After the last update of a batch: the next revision.
  void publish();

  /// The id of a node that a reference names.
  scenegraph::model::NodeId resolve(scenegraph::model::NodeRef ref) const;
  /// How the batch under way names a node: by its alias if it has made it.
  scenegraph::model::NodeRef refer(scenegraph::model::NodeId id) const;
  /// Of the PutNodes of the batch under way, in order.
  const std::vector<scenegraph::model::NodeId>& put_nodes() const { return put_nodes_; }

  /// For the oracle; the arrays belong to this scene.
  std::vector<PlacedMesh> placed() const;
  /// Ascending: the nodes that a query of this root (0: all) and without these does not see.
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
