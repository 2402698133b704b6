// The updates of a revision as bytes, in parts that each fit a message of a watch.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "scenegraph/model/update.h"
#include "sightline/v1/scene.pb.h"

namespace sightline::server::codec {

/// About the largest size of a part.
inline constexpr std::size_t kPartBytes = std::size_t{960} << 10;

/// Encodes the updates, whose nodes are named by their ids. No updates: no parts.
std::string encode_parts(const std::vector<scenegraph::model::Update>& updates);

/// Removes the first part from `parts`, which encode_parts() has made, and decodes it. `out` holds
/// its updates and nothing else.
void take_part(std::string_view& parts, v1::WatchSceneResponse& out);

}  // namespace sightline::server::codec
