// The table of answers to requests with a request id.
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

/// The seal of the row of an answer. `nodes`: as they are stored.
std::int64_t seal_answer(const SceneKey& scene, const RequestAnswer& answer,
                         std::string_view nodes);

/// Errors of all: as Database.

/// Adds an answer, and drops the oldest beyond the limits. The scene's row counts them; it is not
/// written. Errors: also kAlreadyExists.
Status insert_answer(Database& database, SceneRow& scene, const RequestAnswer& answer,
                     const StoreLimits& limits);
/// The answers, oldest first. Errors: also kDataLoss, kNotFound (no such scene).
Result<std::vector<RequestAnswer>> read_answers(Database& database, SceneId scene);
/// The answer; nothing if it is not kept. Errors: also kDataLoss, kNotFound (no such scene).
Result<std::optional<RequestAnswer>> find_answer(Database& database, SceneId scene,
                                                 const std::string& request_id);

}  // namespace sightline::server::store
