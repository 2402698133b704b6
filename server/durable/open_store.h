// The store in a data directory.
#pragma once

#include <filesystem>
#include <memory>

#include "accel/result.h"
#include "server/store/store.h"

namespace sightline::server::durable {

/// Makes the directory if it is missing; its parent exists. An empty path: null. Errors: as of the
/// store; they name the file and the remedy.
Result<std::unique_ptr<store::Store>> open_store(const std::filesystem::path& directory);

}  // namespace sightline::server::durable
