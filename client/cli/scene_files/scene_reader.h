// Reads a whole scene from the server, as the arrays that files are made of.
#pragma once

#include <cstdint>
#include <functional>
#include <stop_token>
#include <string>

#include "client/client.h"
#include "client/importer/imported_scene.h"
#include "client/result.h"

namespace sightline::client::cli::scene_files {

/// Called with the numbers of nodes read and of all nodes.
using ReadProgress = std::function<void(std::uint64_t done, std::uint64_t total)>;

struct ReadScene {
  importer::ImportedScene scene;
  /// The scene changed meanwhile: parts may be of different revisions.
  bool has_changed = false;
};

/// Nodes come with their names, places and meshes; nodes that share a mesh share it here. Errors:
/// those of the calls; kCancelled.
Result<ReadScene> read_scene(const Client& client, const std::string& name,
                             const ReadProgress& progress, const std::stop_token& stop);

}  // namespace sightline::client::cli::scene_files
