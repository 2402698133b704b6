// Deletes rows that nothing needs any more, step by step.
#pragma once

#include "proto/result.h"
#include "server/store/database.h"

namespace sightline::server::store {

/// Deletes a bounded number of rows of scenes that were removed, of batches and snapshots before
/// the base, and of unfinished snapshots. Returns whether there may be more. Errors: as Database.
Result<bool> purge_some(Database& database);

}  // namespace sightline::server::store
