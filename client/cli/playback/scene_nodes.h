// The nodes of a scene on the server, and which of them are those of a file.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "client/client.h"

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

}  // namespace sightline::client::cli::playback
