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

/// For each node of the motion's scene, returns the id of the matching node of the scene on the
/// server, or 0 if there is none. A node matches if it has the same name and its parent matches;
/// roots must be children of `under` (0: roots of the scene). Nodes with the same name and parent
/// match in the order of their ids. Errors: kFailedPrecondition, naming the node: a moving node or
/// an ancestor of it is missing, or a node whose vertices move has another mesh.
Result<std::vector<std::uint64_t>> match_nodes(const Motion& motion,
                                               const std::vector<NodeInfo>& nodes,
                                               std::uint64_t under);

struct TargetRequest {
  std::string scene;
  bool add = false;               ///< put the motion's nodes into an existing scene
  bool must_be_new = false;       ///< an existing scene is an error, kAlreadyExists
  std::string under;              ///< the parent of the motion's roots, by name or id; empty: none
  std::vector<std::string> only;  ///< the nodes that move, by id or name; empty: all
};

struct PlaybackTarget {
  /// For each node of the motion's scene, its id on the server; 0: it does not move.
  std::vector<std::uint64_t> ids;
  bool is_new = false;            ///< the scene was imported
  std::uint64_t first_moved = 0;  ///< the least id of a node that moves
  std::size_t placed = 0;
  std::size_t shaped = 0;
};

/// The up axis and unit in which a file must be read to match the scene.
importer::ImportOptions frame_of(const SceneInfo& scene);

/// Finds the motion's nodes in the scene, adds them, or imports a new scene. Errors: those of
/// upload_scene and match_nodes; kInvalidArgument: a word of `only` names no node that moves.
Result<PlaybackTarget> prepare_target(const Client& client, const TargetRequest& request,
                                      const Motion& motion, bool exists,
                                      const std::stop_token& stop);

}  // namespace sightline::client::cli::playback
