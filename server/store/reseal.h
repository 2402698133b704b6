// Seals the rows that an older version has written.
#pragma once

#include "proto/result.h"
#include "server/store/database.h"

namespace sightline::server::store {

/// Gives each row its seal, and each scene its sums. Call it within a transaction, after the tables
/// got their new columns. Damage that shows before this still shows after it. Cost: reads all rows,
/// but no updates and no bytes of snapshots. Errors: as Database.
Status seal_all(Database& database);

}  // namespace sightline::server::store
