// Reads the revisions of a scene as they are made. Internal to the library.
#pragma once

#include <cstdint>
#include <optional>
#include <stop_token>
#include <string>

#include "client/result.h"
#include "client/update.h"

namespace sightline::client::calls {

struct Connection;

Status watch(const Connection& connection, const std::string& scene,
             std::optional<std::uint64_t> start, const SceneChangeSink& sink,
             const std::stop_token& stop);

}  // namespace sightline::client::calls
