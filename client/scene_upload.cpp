// Uploads meshes first, then nodes.
#include "client/scene_upload.h"

#include <fmt/format.h>

#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "client/calls/scene_check.h"
#include "client/importer/imported_scene.h"
#include "client/mesh_blob.h"
#include "client/mesh_uploads.h"

namespace sightline::client {
namespace {

// The blobs of the meshes that nodes have, by mesh; the others stay empty. Meshes of equal content
// get different copy numbers, so that the scene has as many meshes as the file.
struct Blobs {
  std::vector<std::optional<MeshBlob>> blob;
  std::vector<std::string> digest;
};

Blobs make_blobs(const importer::ImportedScene& scene) {
  Blobs blobs{std::vector<std::optional<MeshBlob>>(scene.meshes.size()),
              std::vector<std::string>(scene.meshes.size())};
  std::unordered_map<std::string, std::uint32_t> copies;
  for (const importer::ImportedNode& node : scene.nodes) {
    if (node.mesh == importer::kNone || blobs.blob[node.mesh]) continue;
    const importer::ImportedMesh& mesh = scene.meshes[node.mesh];
    MeshBlob blob(mesh.vertices, mesh.faces);
    std::string digest = blob.digest();
    if (const std::uint32_t copy_number = copies[digest]++; copy_number > 0) {
      blob = MeshBlob(mesh.vertices, mesh.faces, copy_number);
      digest = blob.digest();
    }
    blobs.blob[node.mesh] = blob;
    blobs.digest[node.mesh] = std::move(digest);
  }
  return blobs;
}

Status upload_meshes(const Client& client, const Blobs& blobs, const std::stop_token& stop,
                     const SceneUploadProgress& progress) {
  std::unordered_map<std::string, std::size_t> index_of;
  std::vector<std::string> asked;
  for (std::size_t i = 0; i < blobs.digest.size(); ++i) {
    if (!blobs.blob[i]) continue;
    index_of.emplace(blobs.digest[i], i);
    asked.push_back(blobs.digest[i]);
  }
  auto missing = client.missing_meshes(asked);
  if (!missing) return missing.error();

  std::vector<MeshUpload> uploads;
  for (std::string& digest : *missing)
    uploads.push_back({&*blobs.blob[index_of.at(digest)], std::move(digest)});
  return upload_all(client, uploads, stop, progress);
}

std::vector<PutNode> put_nodes(const importer::ImportedScene& scene,
                               const std::vector<std::string>& digests,
                               const SceneUploadOptions& options, NodeRef parent = 0) {
  std::vector<PutNode> puts;
  puts.reserve(scene.nodes.size());
  const auto alias = [](std::size_t i) { return NodeRef(-1 - static_cast<std::int64_t>(i)); };
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    const importer::ImportedNode& node = scene.nodes[i];
    PutNode put;
    put.node = alias(i);
    put.parent = node.parent == importer::kNone ? parent : alias(node.parent);
    put.name = node.name;
    put.parent_from_local = node.parent_from_local;
    if (node.mesh != importer::kNone) put.mesh_digest = digests[node.mesh];
    put.mobility = options.by_node.empty() ? options.mobility : options.by_node[i];
    puts.push_back(std::move(put));
  }
  return puts;
}

// Whether there is a scene of that name.
Result<bool> exists(const Client& client, const std::string& name) {
  const auto scene = client.get_scene(name);
  if (scene) return true;
  if (scene.error().code == Code::kNotFound) return false;
  return scene.error();
}

Error already_exists(const std::string& name) {
  return {Code::kAlreadyExists, fmt::format("scene {} exists", name), "SCENE_EXISTS"};
}

}  // namespace

Result<SceneInfo> upload_scene(const Client& client, const std::string& name,
                               const importer::ImportedScene& scene,
                               const SceneUploadOptions& options,
                               const SceneUploadProgress& progress) {
  const auto limits = client.server_info();
  if (!limits) return limits.error();
  if (const Status good = calls::check_scene(scene, *limits); !good) return good.error();
  const auto there = exists(client, name);
  if (!there) return there.error();
  if (*there && !options.replace) return already_exists(name);

  const Blobs blobs = make_blobs(scene);
  if (const Status sent = upload_meshes(client, blobs, options.stop, progress); !sent)
    return sent.error();
  return client.put_scene(name, put_nodes(scene, blobs.digest, options),
                          {.up_axis = scene.up_axis,
                           .meters_per_unit = scene.meters_per_unit,
                           .replace = options.replace,
                           .stop = options.stop});
}

Result<std::vector<std::uint64_t>> add_to_scene(const Client& client, const std::string& name,
                                                const importer::ImportedScene& scene,
                                                std::uint64_t parent,
                                                const SceneUploadOptions& options,
                                                const SceneUploadProgress& progress) {
  const auto limits = client.server_info();
  if (!limits) return limits.error();
  if (const Status good = calls::check_scene(scene, *limits); !good) return good.error();
  const Blobs blobs = make_blobs(scene);
  if (const Status sent = upload_meshes(client, blobs, options.stop, progress); !sent)
    return sent.error();
  if (options.stop.stop_requested()) {
    return Error{Code::kCancelled, fmt::format("cancelled before {} was changed", name), {}};
  }
  const auto puts = put_nodes(scene, blobs.digest, options, parent);
  const auto applied = client.apply_in_batches(name, std::vector<Update>(puts.begin(), puts.end()));
  if (!applied) return applied.error();
  return applied->nodes;
}

std::vector<std::string> mesh_digests(const importer::ImportedScene& scene) {
  return make_blobs(scene).digest;
}

}  // namespace sightline::client
