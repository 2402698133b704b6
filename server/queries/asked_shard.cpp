// Finds the shard that a query names.
#include "server/queries/asked_shard.h"

#include <fmt/format.h>

#include <utility>

#include "server/shards/peers.h"
#include "server/shards/shard_cuts.h"

namespace sightline::server::queries {

Status check_shard(const CastQuery& query, const scenes::Services& services) {
  if (!query.shard || query.shard->count == services.shard_peers.size()) return {};
  return Error{Code::kFailedPrecondition,
               fmt::format("asked for shard {} of {}, but this server has {} --shard-peers",
                           query.shard->index, query.shard->count, services.shard_peers.size()),
               "SHARDS_DIFFER"};
}

Result<scenegraph::query::Shard> shard_of(
    const CastQuery& query, const scenes::Services& services,
    const std::shared_ptr<const scenegraph::revision::Snapshot>& snapshot) {
  if (!query.shard) return scenegraph::query::Shard();
  auto cut = services.shard_cuts.find_or_make(snapshot, query.shard->count);
  if (query.shard->cut != 0 && query.shard->cut != cut->fingerprint()) {
    return Error{Code::kFailedPrecondition,
                 fmt::format("this server cuts revision {} into other shards: is it of another "
                             "version?",
                             snapshot->revision()),
                 "SHARD_CUT_DIFFERS"};
  }
  return scenegraph::query::Shard{std::move(cut), query.shard->index};
}

bool is_for_all_shards(const CastQuery& query, const scenes::Services& services) {
  return !services.shard_peers.empty() && !query.shard;
}

}  // namespace sightline::server::queries
