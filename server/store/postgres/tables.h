// The tables of a store in PostgreSQL, and their versions.
#pragma once

#include "proto/result.h"
#include "server/store/postgres/connection.h"

namespace sightline::server::store::postgres {

/// The version of the tables that this program writes.
inline constexpr int kTablesVersion = 2;

/// Makes the tables, if there are none, or brings those of an older version up to this one: servers
/// of that version cannot write any more. Where the tables are not where they were made, as after a
/// dump was restored, all scenes get new tokens. Several processes may call it at a time. Errors:
/// kFailedPrecondition (STORE_NEWER: a newer version has made them; NOT_A_STORE: another program
/// has), as Database.
Status prepare_tables(Connection& connection, const Address& address);

/// Milliseconds since 1970, by the clock of the server: those of several replicas may differ.
Result<std::int64_t> now(Database& database);

}  // namespace sightline::server::store::postgres
