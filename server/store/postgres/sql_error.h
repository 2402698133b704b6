// The errors of PostgreSQL. Each names the database and what to do about it.
#pragma once

#include <string_view>

#include "proto/result.h"

namespace sightline::server::store::postgres {

/// The error kUnavailable (STORE_IO): there is no connection to `database`.
Error unreachable(std::string_view database, std::string_view why);
/// The error kDataLoss (STORE_CORRUPT). `what`: which part of the database is damaged.
Error damaged(std::string_view database, std::string_view what);
/// An error that the server has answered with. `state`: its SQLSTATE.
Error sql_error(std::string_view database, std::string_view state, std::string_view message);

/// Whether the connection cannot be used after this: the server ends, or takes no writes any more.
bool ends_connection(std::string_view state);

}  // namespace sightline::server::store::postgres
