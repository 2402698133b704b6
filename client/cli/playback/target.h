// The scene that a motion is played into, and which of its nodes move.
#pragma once

#include <cstdint>
#include <stop_token>
#include <string>
#include <vector>

#include "client/client.h"

namespace sightline::client::importer {
struct ImportOptions;
}

namespace sightline::client::cli::playback {

struct Motion;

/// All nodes of a scene, by id. Errors: those of the calls; kAborted, it changes too fast to be
/// read.
Result<std::vector<NodeInfo>> list_nodes(const Client& client, const std::string& scene);

/// For each node of the motion's scene the id of the scene's node that it is, 0 if there is none:
/// of the same name, under the one that its parent is, roots under `under` (0: the scene's roots);
/// nodes of one name and parent in the order of their ids. Errors: kFailedPrecondition, naming it:
/// a node that moves, or one above it, is not there; one whose vertices move carries another mesh.
Result<std::vector<std::uint64_t>> match_nodes(const Motion& motion,
                                               const std::vector<NodeInfo>& nodes,
                                               std::uint64_t under);

struct Motion;

struct TargetRequest {
  std::string scene;
  bool add = false;               ///< Put the motion's nodes into an existing scene.
  bool must_be_new = false;       ///< An existing scene is kAlreadyExists.
  std::uint64_t under = 0;        ///< The node above them; 0: they are roots.
  std::vector<std::string> only;  ///< Nodes that move, by id or name; empty: all that do.
};

struct PlaybackTarget {
  /// For each node of the motion's scene that of the scene; 0: it is not to move.
  std::vector<std::uint64_t> ids;
  bool is_new = false;            ///< The scene was imported.
  std::uint64_t first_moved = 0;  ///< The least id of a node that moves.
  std::size_t placed = 0;
  std::size_t shaped = 0;
};

/// The frame in which a file is to be read so that its numbers are the scene's.
importer::ImportOptions frame_of(const SceneInfo& scene);

/// Imports the motion's scene if there is none, or adds it, or finds its nodes. Errors: those of
/// upload_scene and match_nodes; kInvalidArgument: none of `only` moves.
Result<PlaybackTarget> prepare_target(const Client& client, const TargetRequest& request, const Motion& motion,
                        bool exists, const std::stop_token& stop);

}  // namespace sightline::client::cli::playback
