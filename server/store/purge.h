// Deletes rows that nothing needs any more, step by step.
#pragma once

#include "accel/result.h"
#include "server/store/sqlite.h"

namespace sightline::server::store {

/// Deletes a bounded number of rows of scenes that were removed, of batches and snapshots before
/// the base, and of unfinished snapshots. Returns whether there may be more. Errors: as
/// Database::error().
Result<bool> purge_some(Database& database);

/// Gives a bounded number of free pages back to the file system, if they are many, or `all`.
/// Errors: as Database::error().
Status return_pages(Database& database, bool all);

}  // namespace sightline::server::store
