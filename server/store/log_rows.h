// The table of updates.
#pragma once

#include <chrono>
#include <cstdint>
#include <vector>

#include "proto/result.h"
#include "server/store/database.h"
#include "server/store/seal.h"
#include "server/store/store.h"

namespace sightline::server::store {

/// What the row of a batch says beside its updates.
struct BatchRow {
  SceneKey scene;
  std::uint64_t revision = 0;
  std::int64_t time = 0;      ///< Milliseconds since 1970.
  std::uint64_t logged = 0;   ///< Bytes of updates of the scene, with these.
  std::uint64_t named = 0;    ///< Sum of the blobs that it names: see sum_of_blobs().
  std::int64_t checksum = 0;  ///< The checksum of the updates.

  std::int64_t seal() const;
};

/// Adds all of a batch. Errors: those that Store::append() gives to `done`; then some of it may be
/// in the transaction, which must be rolled back.
Status insert_batch(Database& database, const Batch& batch, const StoreLimits& limits,
                    std::chrono::system_clock::time_point now);

/// Reads batches as Store::read() does.
Result<std::vector<LoggedBatch>> read_batches(Database& database, SceneId scene,
                                              std::uint64_t after, std::uint64_t max_bytes);

/// Bytes of updates that were logged up to a revision, which is in the log. Errors: as Database,
/// kDataLoss.
Result<std::uint64_t> logged_at(Database& database, const SceneKey& scene, std::uint64_t revision);

}  // namespace sightline::server::store
