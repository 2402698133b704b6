// Meshes whose vertices change in a batch of updates. All patches of a mesh make one new mesh.
#pragma once

#include <memory>
#include <set>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "proto/result.h"
#include "scenegraph/model/node.h"

namespace sightline::scenegraph::revision {

/// The meshes that a batch of updates deforms. Threads: one writer.
class Deformations {
 public:
  /// `charge` is called with the bytes of each new mesh before it is made. Empty: nothing is
  /// charged.
  explicit Deformations(model::ChargeBytes charge = {}) : charge_bytes_(std::move(charge)) {}

  /// The nodes will share a mesh whose vertices from `first` on are at `positions`. Errors:
  /// kInvalidArgument (no node, a node without a mesh, meshes that differ, vertices beyond the
  /// mesh's), and those of the charge and of Mesh::make_resident().
  Status patch(std::span<const model::Node* const> nodes, std::uint32_t first,
               std::span<const accel::geometry::Vec3f> positions);

  /// Must be called when a node is deleted or gets another mesh.
  void forget(model::NodeId id);

  /// Makes the new meshes. Returns the mesh of each node that was patched. Errors: those of
  /// Mesh::deformed().
  Result<std::vector<std::pair<model::NodeId, std::shared_ptr<const model::Mesh>>>> make();

 private:
  /// A mesh that is shared by exactly these nodes.
  struct Deformation {
    std::set<model::NodeId> nodes;
    std::shared_ptr<const model::Mesh> mesh;  // before the patches
    std::shared_ptr<const void> charge;       // for `vertices`, then for the new mesh
    std::vector<accel::geometry::Vec3f> vertices;
  };

  Result<Deformation*> deformation_of(std::span<const model::Node* const> nodes);
  std::shared_ptr<Deformation> find(model::NodeId id) const;

  const model::ChargeBytes charge_bytes_;
  std::unordered_map<model::NodeId, std::shared_ptr<Deformation>> by_node_;
};

}  // namespace sightline::scenegraph::revision
