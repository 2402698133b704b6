// Uploads an imported scene to the server: each mesh once, then the nodes.
#pragma once

#include <cstdint>
#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "client/client.h"
#include "client/result.h"

namespace sightline::client::importer {
struct ImportedScene;
}

namespace sightline::client {

struct SceneUploadOptions {
  Mobility mobility = Mobility::kStatic;  ///< every node's
  std::vector<Mobility> by_node{};        ///< each node's; overrides `mobility` if not empty
  /// Takes the place of a scene of that name; otherwise the error is kAlreadyExists.
  bool replace = false;
  /// Ends the upload with kCancelled.
  std::stop_token stop{};
};

/// Called with the number of uploaded bytes, and the number of bytes of all meshes that the server
/// lacked, by one thread at a time.
using SceneUploadProgress = std::function<void(std::uint64_t done, std::uint64_t total)>;

/// Checks everything that can be checked, uploads the meshes that the server lacks, and then makes
/// the scene in one step (Client::put_scene). If something fails, or this process ends, there is no
/// scene, or the old one. Node ids follow the order of scene.nodes. Errors: kAlreadyExists, before
/// anything is sent; kInvalidArgument or kResourceExhausted, naming a node or mesh, if the scene is
/// beyond the server's limits; those of the calls.
Result<SceneInfo> upload_scene(const Client& client, const std::string& name,
                               const importer::ImportedScene& scene,
                               const SceneUploadOptions& options,
                               const SceneUploadProgress& progress = {});

/// Adds the imported scene's nodes to a scene, its roots under `parent` (0: as roots). Returns
/// their ids, in the order of scene.nodes. Ignores `options.replace`. Errors: kNotFound; as
/// upload_scene() for a scene beyond the limits; those of the calls.
Result<std::vector<std::uint64_t>> add_to_scene(const Client& client, const std::string& name,
                                                const importer::ImportedScene& scene,
                                                std::uint64_t parent,
                                                const SceneUploadOptions& options,
                                                const SceneUploadProgress& progress = {});

/// The digests that upload_scene gives to the meshes; empty for a mesh that no node has.
std::vector<std::string> mesh_digests(const importer::ImportedScene& scene);

}  // namespace sightline::client
