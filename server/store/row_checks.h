// Looks for damage in the rows of a store.
#pragma once

#include <string>
#include <vector>

#include "proto/result.h"
#include "server/store/sqlite.h"

namespace sightline::server::store {

/// Adds a line to `findings` for each damage: pages and indexes of the file, rows that name missing
/// rows, rows that do not match their checksums or belong to another scene, gaps in the revisions
/// of a log, logs that end before or after the newest revision, rows, chunks or names of meshes
/// that are missing. Errors: as Database, unless the database itself says what is damaged.
Status check_rows(SqliteDatabase& database, std::vector<std::string>& findings);

}  // namespace sightline::server::store
