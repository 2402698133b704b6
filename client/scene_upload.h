// Brings an imported scene to the server: its meshes, each once, and its nodes.
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
  Mobility mobility = Mobility::kStatic;  ///< Of every node.
  std::vector<Mobility> by_node{};        ///< Of each node instead, if it is not empty.
  bool replace = false;  ///< Delete a scene of that name first; else it is kAlreadyExists.
  /// Ends the upload with kCancelled; not any more once the scene is being made, which is short.
  std::stop_token stop{};
};

/// Told how many bytes of meshes the server has, of those it lacked, on the calling thread.
using SceneUploadProgress = std::function<void(std::uint64_t done, std::uint64_t total)>;

/// Checks everything that can be checked, uploads the meshes that the server lacks, and only then
/// replaces or creates the scene. If something fails after that, the half-made scene is deleted
/// again. Node ids follow the order of scene.nodes. Errors: kAlreadyExists, before anything is
/// sent; those of check_scene and of the calls.
Result<SceneInfo> upload_scene(const Client& client, const std::string& name,
                               const importer::ImportedScene& scene,
                               const SceneUploadOptions& options,
                               const SceneUploadProgress& progress = {});

/// Puts the imported scene's nodes beside what the scene holds, its roots under `parent` (0: as
/// roots), and returns their ids, in the order of scene.nodes. `options.replace` is not looked at.
/// Errors: kNotFound; those of check_scene and of the calls.
Result<std::vector<std::uint64_t>> add_to_scene(const Client& client, const std::string& name,
                                                const importer::ImportedScene& scene,
                                                std::uint64_t parent,
                                                const SceneUploadOptions& options,
                                                const SceneUploadProgress& progress = {});

/// The names that upload_scene gives to the meshes; empty for one that no node carries.
std::vector<std::string> mesh_digests(const importer::ImportedScene& scene);

}  // namespace sightline::client
