// Looks for damage in the rows of a store.
#pragma once

#include <string>
#include <vector>

#include "proto/result.h"
#include "server/store/sqlite.h"

namespace sightline::server::store {

/// Adds a line to `findings` for each damage: pages of the file, rows that name missing rows, gaps
/// in the revisions of a log, rows that do not match their checksums, snapshots that are missing
/// or incomplete. Errors: as Database, unless the database itself says what is damaged.
Status check_rows(SqliteDatabase& database, std::vector<std::string>& findings);

}  // namespace sightline::server::store
