// The tables of a store, and their versions.
#pragma once

#include "proto/result.h"
#include "server/store/sqlite.h"

namespace sightline::server::store {

/// The version of the tables that this program writes.
inline constexpr int kSchemaVersion = 3;

/// Sets the connection up: durable commits, write-ahead log, foreign keys. Errors: as
/// Database.
Status configure(SqliteDatabase& database);

/// Makes the tables of a new file, or brings those of an older version up to this one. Errors:
/// kFailedPrecondition (STORE_NEWER: a newer version has written the file; NOT_A_STORE: another
/// program has), kDataLoss (STORE_CORRUPT: the tables are not as they were made), as Database.
Status prepare_tables(SqliteDatabase& database);

}  // namespace sightline::server::store
