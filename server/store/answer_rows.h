// The table of answers to requests with a request id.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "proto/result.h"
#include "server/store/database.h"
#include "server/store/store.h"

namespace sightline::server::store {

/// Errors of all: as Database.

/// Adds an answer, and drops the oldest beyond the limits. Errors: also kAlreadyExists.
Status insert_answer(Database& database, SceneId scene, const RequestAnswer& answer,
                     const StoreLimits& limits);
/// Oldest first. Errors: also kDataLoss.
Result<std::vector<RequestAnswer>> read_answers(Database& database, SceneId scene);
/// Nothing: it is not kept. Errors: also kDataLoss.
Result<std::optional<RequestAnswer>> find_answer(Database& database, SceneId scene,
                                                 const std::string& request_id);

}  // namespace sightline::server::store
