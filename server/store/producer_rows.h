// The tables of producers and of the nodes that their last batches put.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "proto/result.h"
#include "server/store/database.h"
#include "server/store/store.h"

namespace sightline::server::store {

/// Errors of all: as Database.

/// Records a producer's progress. Errors: also kOutOfRange (a sequence that is not beyond its
/// last).
Status insert_commit(Database& database, SceneId scene, const ProducerCommit& commit,
                     const StoreLimits& limits);
/// By name. Errors: also kDataLoss.
Result<std::vector<ProducerRecord>> read_producers(Database& database, SceneId scene);
/// Nothing: it has committed nothing. Errors: also kDataLoss.
Result<std::optional<ProducerRecord>> find_producer(Database& database, SceneId scene,
                                                    const std::string& name);

}  // namespace sightline::server::store
