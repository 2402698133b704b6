// Uploads a scene of the bench to a server.
#include "tests/bench/remote/upload.h"

#include <algorithm>
#include <array>

#include "client/importer/imported_scene.h"
#include "client/scene_upload.h"

namespace sightline::bench {
namespace {

client::importer::ImportedMesh arrays_of(const SourceMesh& mesh) {
  client::importer::ImportedMesh arrays;
  for (const auto& v : mesh.vertices) arrays.vertices.push_back({v.x, v.y, v.z});
  for (const auto& face : mesh.faces) arrays.faces.push_back({face[0], face[1], face[2]});
  arrays.triangles = arrays.faces.size();
  return arrays;
}

client::importer::ImportedScene arrays_of(const SceneSource& scene) {
  client::importer::ImportedScene arrays;
  for (const SourceMesh& mesh : scene.meshes) arrays.meshes.push_back(arrays_of(mesh));
  for (const SourceNode& node : scene.nodes) {
    client::importer::ImportedNode imported{.name = node.name};
    if (node.parent) imported.parent = static_cast<std::uint32_t>(*node.parent);
    if (node.mesh) imported.mesh = static_cast<std::uint32_t>(*node.mesh);
    std::copy_n(std::begin(node.parent_from_local.m), imported.parent_from_local.size(),
                imported.parent_from_local.begin());
    arrays.nodes.push_back(std::move(imported));
  }
  return arrays;
}

}  // namespace

Error error_of(const client::Error& error) {
  return {Code::kFailedPrecondition, error.message, "REMOTE"};
}

Status upload(const client::Client& client, const SceneSource& scene) {
  const auto info = client::upload_scene(client, kRemoteScene, arrays_of(scene), {});
  if (!info) return error_of(info.error());
  const auto built = client.prefetch(kRemoteScene);
  return built ? Status() : Status(error_of(built.error()));
}

}  // namespace sightline::bench
