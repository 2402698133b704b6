// Nodes as arguments: by id, by name, or by the names from a root down.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "client/client.h"
#include "client/result.h"

namespace CLI {
class Validator;
}

namespace sightline::client::cli {

/// A check for options that take a node: an id above 0, or a name.
CLI::Validator node_word();

/// All nodes of a scene, by id. Errors: those of the calls; kAborted, the scene changes too fast to
/// be read.
Result<std::vector<NodeInfo>> list_nodes(const Client& client, const std::string& scene);

/// The ids of nodes. A word of digits is an id. Any other is a name, or several parted by slashes,
/// each of a child of the one before; after a slash at the front, the first is a root. Asks the
/// server for the nodes only if there is a name. Errors: kNotFound (NODE_NOT_FOUND), which names a
/// node that may have been meant; kInvalidArgument, several nodes have the name: it tells their
/// ids; those of the calls.
Result<std::vector<std::uint64_t>> resolve_nodes(const Client& client, const std::string& scene,
                                                 std::span<const std::string> words);

/// The id of one node; an empty word is 0. Errors: as resolve_nodes().
Result<std::uint64_t> resolve_node(const Client& client, const std::string& scene,
                                   const std::string& word);

/// The id of a node among those that have been read. Errors: as resolve_nodes().
Result<std::uint64_t> find_node(std::span<const NodeInfo> nodes, const std::string& word);

}  // namespace sightline::client::cli
