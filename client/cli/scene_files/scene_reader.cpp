// Puts parents before children, and reads each mesh once.
#include "client/cli/scene_files/scene_reader.h"

#include <algorithm>
#include <unordered_map>
#include <utility>
#include <vector>

#include "client/cli/nodes.h"

namespace sightline::client::cli::scene_files {
namespace {

// The nodes with parents before children, else in their order.
std::vector<const NodeInfo*> sorted(const std::vector<NodeInfo>& nodes) {
  std::unordered_map<std::uint64_t, std::vector<const NodeInfo*>> children;
  for (const NodeInfo& node : nodes) children[node.parent].push_back(&node);
  std::vector<const NodeInfo*> order = children[0];
  for (std::size_t i = 0; i < order.size(); ++i) {
    const auto& below = children[order[i]->id];
    order.insert(order.end(), below.begin(), below.end());
  }
  return order;
}

importer::ImportedMesh imported(NodeMesh mesh) {
  importer::ImportedMesh out;
  for (const Face& face : mesh.faces) out.triangles += face[0] == kNoVertex ? 0 : 1;
  out.vertices = std::move(mesh.vertices);
  out.faces = std::move(mesh.faces);
  return out;
}

class MeshReader {
 public:
  MeshReader(const Client& client, const std::string& scene, const std::stop_token& stop)
      : client_(client), scene_(scene), stop_(stop) {}

  /// The number of the node's mesh, which is read if no node before had it.
  Result<std::uint32_t> read(const NodeInfo& node, std::vector<importer::ImportedMesh>& meshes) {
    // Patched nodes have vertices of their own.
    const auto known = node.patched ? numbers_.end() : numbers_.find(node.mesh_digest);
    if (known != numbers_.end()) return known->second;
    auto mesh = client_.read_mesh(scene_, node.id, stop_);
    if (!mesh) return mesh.error();
    const auto number = static_cast<std::uint32_t>(meshes.size());
    meshes.push_back(imported(*std::move(mesh)));
    if (!node.patched) numbers_.emplace(node.mesh_digest, number);
    return number;
  }

 private:
  const Client& client_;
  const std::string& scene_;
  const std::stop_token& stop_;
  std::unordered_map<std::string, std::uint32_t> numbers_;
};

}  // namespace

Result<ReadScene> read_scene(const Client& client, const std::string& name,
                             const ReadProgress& progress, const std::stop_token& stop) {
  const auto before = client.get_scene(name, stop);
  if (!before) return before.error();
  const auto nodes = list_nodes(client, name);
  if (!nodes) return nodes.error();
  ReadScene out;
  out.scene.up_axis = before->up_axis;
  out.scene.meters_per_unit = before->meters_per_unit;
  MeshReader meshes(client, name, stop);
  std::unordered_map<std::uint64_t, std::uint32_t> number_of;
  for (const NodeInfo* const node : sorted(*nodes)) {
    const auto parent = number_of.find(node->parent);
    importer::ImportedNode& added = out.scene.nodes.emplace_back();
    added.name = node->name;
    added.parent = parent == number_of.end() ? importer::kNone : parent->second;
    added.parent_from_local = node->parent_from_local;
    number_of.emplace(node->id, static_cast<std::uint32_t>(out.scene.nodes.size() - 1));
    if (!node->mesh_digest.empty()) {
      const auto mesh = meshes.read(*node, out.scene.meshes);
      if (!mesh) return mesh.error();
      added.mesh = *mesh;
    }
    progress(out.scene.nodes.size(), nodes->size());
  }
  const auto after = client.get_scene(name);
  if (!after) return after.error();
  out.has_changed = after->revision != before->revision;
  return out;
}

}  // namespace sightline::client::cli::scene_files
