// The transforms of a Collada file's nodes in double. Internal to the importer.
#pragma once

#include <string_view>
#include <unordered_map>

namespace sightline::client::importer {

/// How far Assimp moves nodes as it composes their transforms in float32, in their parents' units,
/// by the names that Assimp gives them: their ids, or else their sids. Nodes that have neither have
/// one entry for all, with an empty name. `text`: as check_collada has passed it; the names are
/// valid as long as it.
std::unordered_map<std::string_view, double> collada_losses(std::string_view text);

}  // namespace sightline::client::importer
