// Work that one of several processes does at a time.
#pragma once

#include <chrono>
#include <string_view>

#include "proto/result.h"
#include "server/store/database.h"

namespace sightline::server::store::postgres {

/// A process that has died keeps its leases this long.
inline constexpr std::chrono::seconds kLeaseTime{30};

/// Takes or renews a lease, within a transaction: until that ends, no other can. Returns whether
/// `holder` has it now. Errors: as Database.
Result<bool> take_lease(Database& database, std::string_view name, std::string_view holder);

/// Gives the lease back, if `holder` has it. Errors: as Database.
Status release_lease(Database& database, std::string_view name, std::string_view holder);

}  // namespace sightline::server::store::postgres
