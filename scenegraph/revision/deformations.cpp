// Applies patches to private copies of vertices.
#include "scenegraph/revision/deformations.h"

#include <algorithm>
#include <string>

namespace sightline::scenegraph::revision {
namespace {

Error invalid(std::string reason, std::string message) {
  return {Code::kInvalidArgument, std::move(message), std::move(reason)};
}

}  // namespace

Status Deformations::patch(std::span<const model::Node* const> nodes, std::uint32_t first,
                           std::span<const accel::geometry::Vec3f> positions) {
  const auto deformation = deformation_of(nodes);
  if (!deformation) return deformation.error();
  std::vector<accel::geometry::Vec3f>& vertices = (*deformation)->vertices;
  if (positions.size() > vertices.size() || first > vertices.size() - positions.size()) {
    return invalid("VERTICES_OUT_OF_RANGE", "vertices " + std::to_string(first) + " to " +
                                                std::to_string(first + positions.size()) +
                                                " are to change, but the mesh has " +
                                                std::to_string(vertices.size()));
  }
  std::copy(positions.begin(), positions.end(), vertices.begin() + first);
  return {};
}

Result<Deformations::Deformation*> Deformations::deformation_of(
    std::span<const model::Node* const> nodes) {
  if (nodes.empty()) return invalid("NO_NODES", "no node is named");
  const model::Node& one = *nodes.front();
  const std::shared_ptr<Deformation> known = find(one.id);
  std::set<model::NodeId> ids;
  for (const model::Node* node : nodes) {
    if (node->mesh == nullptr) {
      return invalid("NODE_WITHOUT_MESH",
                     described(*node) + " has no mesh whose vertices could change");
    }
    if (find(node->id) != known || node->mesh != one.mesh) {
      return invalid("MESHES_DIFFER",
                     described(one) + " and " + described(*node) + " do not have the same mesh");
    }
    ids.insert(node->id);
  }
  if (known != nullptr && known->nodes == ids) return known.get();
  // The lock of the scene's writer is held.
  if (const Status resident = one.mesh->make_resident(model::Reclaim::kForbidden); !resident)
    return resident.error();
  auto fresh = std::make_shared<Deformation>();
  fresh->mesh = one.mesh;
  if (charge_bytes_) {
    auto charged = charge_bytes_(one.mesh->bytes_deformed());
    if (!charged) return charged.error();
    fresh->charge = std::move(*charged);
  }
  const auto old = one.mesh->view().vertices;
  if (known == nullptr) {
    fresh->vertices.assign(old.begin(), old.end());
  } else {
    fresh->vertices = known->vertices;
  }
  for (const model::NodeId id : ids) {
    forget(id);
    by_node_[id] = fresh;
  }
  fresh->nodes = std::move(ids);
  return fresh.get();
}

std::shared_ptr<Deformations::Deformation> Deformations::find(model::NodeId id) const {
  const auto found = by_node_.find(id);
  return found == by_node_.end() ? nullptr : found->second;
}

void Deformations::forget(model::NodeId id) {
  const auto found = by_node_.find(id);
  if (found == by_node_.end()) return;
  found->second->nodes.erase(id);
  by_node_.erase(found);
}

Result<std::vector<std::pair<model::NodeId, std::shared_ptr<const model::Mesh>>>>
Deformations::make() {
  std::unordered_map<const Deformation*, std::shared_ptr<const model::Mesh>> made;
  std::vector<std::pair<model::NodeId, std::shared_ptr<const model::Mesh>>> meshes;
  for (const auto& [id, deformation] : by_node_) {
    std::shared_ptr<const model::Mesh>& mesh = made[deformation.get()];
    if (mesh == nullptr) {
      auto deformed = deformation->mesh->deformed(std::move(deformation->vertices),
                                                  std::move(deformation->charge));
      if (!deformed) return deformed.error();
      mesh = std::move(*deformed);
    }
    meshes.emplace_back(id, mesh);
  }
  return meshes;
}

}  // namespace sightline::scenegraph::revision
