// The tables of producers and of the nodes that their last batches put.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "proto/result.h"
#include "server/store/database.h"
#include "server/store/scene_rows.h"
#include "server/store/store.h"

namespace sightline::server::store {

/// The seal of the row of a producer.
std::int64_t seal_producer(const SceneKey& scene, std::string_view name,
                           std::uint64_t last_committed);
/// The seal of the row of the nodes that a batch has put, as they are stored.
std::int64_t seal_put(const SceneKey& scene, std::string_view producer, std::uint64_t sequence,
                      std::string_view nodes);

/// Errors of all: as Database.

/// Records a producer's progress. The scene's row sums it up; it is not written. Errors: also
/// kOutOfRange (a sequence that is not beyond its last), kDataLoss.
Status insert_commit(Database& database, SceneRow& scene, const ProducerCommit& commit,
                     const StoreLimits& limits);
/// The producers by name. Errors: also kDataLoss, kNotFound (no such scene).
Result<std::vector<ProducerRecord>> read_producers(Database& database, SceneId scene);
/// The producer; nothing if it has committed nothing. Errors: also kDataLoss, kNotFound (no such
/// scene).
Result<std::optional<ProducerRecord>> find_producer(Database& database, SceneId scene,
                                                    const std::string& name);

}  // namespace sightline::server::store
