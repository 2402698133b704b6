// The table of updates.
#pragma once

#include <chrono>
#include <cstdint>
#include <vector>

#include "proto/result.h"
#include "server/store/database.h"
#include "server/store/store.h"

namespace sightline::server::store {

/// Adds all of a batch. Errors: those that Store::append() gives to `done`; then some of it may be
/// in the transaction, which must be rolled back.
Status insert_batch(Database& database, const Batch& batch, const StoreLimits& limits,
                    std::chrono::system_clock::time_point now);

/// As Store::read().
Result<std::vector<LoggedBatch>> read_batches(Database& database, SceneId scene,
                                              std::uint64_t after, std::uint64_t max_bytes);

}  // namespace sightline::server::store
