// The shard that a query names.
#pragma once

#include <memory>

#include "proto/result.h"
#include "scenegraph/query/shard_cut.h"
#include "scenegraph/revision/snapshot.h"
#include "server/queries/cast_query.h"
#include "server/scenes/services.h"

namespace sightline::server::queries {

/// Checks that the query counts as many shards as this server. Errors: kFailedPrecondition
/// (SHARDS_DIFFER).
Status check_shard(const CastQuery& query, const scenes::Services& services);

/// The shard of the revision; the whole scene, if the query names none. May walk the scene. Errors:
/// kFailedPrecondition (SHARD_CUT_DIFFERS).
Result<scenegraph::query::Shard> shard_of(
    const CastQuery& query, const scenes::Services& services,
    const std::shared_ptr<const scenegraph::revision::Snapshot>& snapshot);

/// Whether the servers of all shards are asked.
bool is_for_all_shards(const CastQuery& query, const scenes::Services& services);

}  // namespace sightline::server::queries
