// The store in a data directory, or in PostgreSQL.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "proto/result.h"
#include "server/store/store.h"

namespace sightline::server::durable {

/// Where scenes are kept: in a directory, in PostgreSQL or, if both are empty, in memory only.
struct StoreLocation {
  std::filesystem::path directory = {};
  std::string uri = {};                   ///< postgresql://...
  std::filesystem::path mesh_cache = {};  ///< Copies of meshes in PostgreSQL. Empty: temporary.
};

/// Whether such a store could be opened, without looking for it. Errors: kInvalidArgument.
Status check_location(const StoreLocation& location);

/// Makes the directory if it is missing; its parent exists. In memory only: null. Errors: as
/// check_location() and of the store; they name the file or the database, and the remedy.
Result<std::unique_ptr<store::Store>> open_store(const StoreLocation& location);

}  // namespace sightline::server::durable
