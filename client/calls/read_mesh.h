// Reads the mesh of a node, part by part. Internal to the library.
#pragma once

#include <cstdint>
#include <stop_token>
#include <string>

#include "client/result.h"
#include "client/scene_info.h"

namespace sightline::client::calls {

struct Connection;

/// Does what Client::read_mesh() does.
Result<NodeMesh> read_mesh(const Connection& connection, const std::string& scene,
                           std::uint64_t node, const std::stop_token& stop);

}  // namespace sightline::client::calls
